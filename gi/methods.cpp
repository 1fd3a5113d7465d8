#include "gi/methods.h"

#include "gi/compose/compose.h"
#include "gi/ddgi/blend.h"
#include "gi/ddgi/sample.h"
#include "gi/direct/direct.h"
#include "gi/direct/log_blur.h"
#include "gi/direct/visibility_filter.h"
#include "gi/filter/filter.h"
#include "gi/isr/isr.h"
#include "gi/probes/bake_steps.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/density.h"
#include "gi/probes/indirect_shadow.h"
#include "gi/probes/lambda.h"
#include "gi/probes/radiance.h"
#include "gi/probes/level.h"
#include "gi/probes/lightmap_uv.h"
#include "gi/probes/lookup.h"
#include "gi/probes/relief.h"
#include "gi/probes/run_stages.h"
#include "gi/probes/shadow_rays.h"
#include "gi/probes/shadow_spheres.h"
#include "gi/probes/share.h"
#include "gi/probes/supports.h"
#include "gi/probes/update.h"
#include "gi/probes/volume.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/host_stages.h"
#include "gi/radiosity/items.h"
#include "gi/radiosity/lookup.h"
#include "gi/radiosity/reduce.h"
#include "gi/reference/reference.h"
#include "gi/rsm/all_rays.h"
#include "gi/rsm/gather.h"
#include "gi/screen/screen.h"
#include "gi/zbuffer/zbuffer.h"
#include "raster/bindings.h"
#include "raster/hemicube.h"
#include "raster/texture_space.h"

namespace plumb {

namespace {

ListedStage listed(const StageBinding& binding, bool of_frame = true) { return {binding.info, &binding, of_frame}; }
ListedStage unbound(const StageInfo& info, bool of_frame = true) { return {info, nullptr, of_frame}; }

}  // namespace

const std::vector<ListedStage>& stages() {
    static const std::vector<ListedStage> all = {
        listed(raster::gbuffer_binding()),
        listed(raster::gbuffer_layer_binding()),
        listed(raster::rsm_binding()),
        listed(stage<direct::LogBlurKernel>()),
        listed(stage<direct::ShadowKernel>()),
        listed(stage<direct::VisibilityFilterKernel>()),
        listed(rsm::stage_of(rsm::Gather::disc)),
        listed(rsm::stage_of(rsm::Gather::disc, rsm::Texels::continuous)),
        listed(rsm::stage_of(rsm::Gather::paths)),
        listed(rsm::stage_of(rsm::Gather::paths, rsm::Texels::continuous)),
        listed(rsm::stage_of(rsm::Gather::all)),
        unbound(rsm::info_all_rays()),
        listed(stage<direct::DirectKernel>()),
        listed(stage<zbuffer::VerticesKernel>()),
        listed(stage<zbuffer::InterpolateKernel>()),
        listed(stage<zbuffer::PixelsKernel>()),
        listed(stage<isr::DownsampleKernel>()),
        listed(stage<isr::GatherKernel>()),
        listed(stage<isr::BounceKernel>()),
        listed(stage<isr::UnseenKernel>()),
        listed(stage<isr::GatherCameraKernel>()),
        listed(stage<isr::SsaoKernel>()),
        listed(stage<isr::BlurKernel>()),
        listed(stage<isr::UpsampleKernel>()),
        listed(stage<isr::ComposeKernel>()),
        listed(stage<filter::ReduceKernel>()),
        listed(stage<filter::UpsampleKernel>()),
        listed(stage<filter::BlurKernel>()),
        unbound(probes::info_run_data()),
        unbound(probes::info_hit_surfaces()),
        unbound(probes::info_rounds()),
        unbound(probes::info_active()),
        unbound(probes::info_static_light()),
        listed(stage<probes::LevelKernel>()),
        listed(stage<probes::RadianceKernel>()),
        listed(stage<probes::LambdaKernel>()),
        listed(stage<probes::BasisKernel>()),
        listed(stage<probes::IrradianceKernel>()),
        listed(stage<probes::LightmapKernel>()),
        listed(stage<probes::VolumeKernel>()),
        listed(stage<probes::LightmapUvKernel>()),
        listed(stage<probes::LookupKernel>()),
        unbound(probes::info_shadow_spheres()),
        listed(stage<probes::IndirectShadowKernel>()),
        unbound(probes::info_shadow_rays()),
        listed(stage<probes::ReliefKernel>()),
        unbound(radiosity::info_elements()),
        unbound(radiosity::info_rows()),
        unbound(radiosity::info_light()),
        unbound(radiosity::info_solve()),
        listed(stage<radiosity::GatherKernel>()),
        listed(stage<radiosity::LookupKernel>()),
        listed(stage<screen::ReuseKernel>()),
        listed(stage<screen::SsaoKernel>()),
        listed(stage<screen::HorizonKernel>()),
        listed(stage<screen::BlurKernel>()),
        listed(stage<screen::OccludeKernel>()),
        listed(stage<compose::ComposeKernel>()),
        listed(stage<screen::LobeKernel>()),
        listed(stage<screen::ReflectKernel>()),
        listed(stage<screen::NearestKernel>()),
        listed(stage<screen::CellsKernel>()),
        listed(stage<screen::MirrorKernel>()),
        unbound(reference::info()),
        listed(stage<compose::TonemapKernel>()),
        unbound(probes::info_atlas(), false),
        unbound(probes::info_receivers(), false),
        listed(stage<probes::DensityKernel>(), false),
        unbound(probes::info_placement(), false),
        listed(stage<probes::SupportsKernel>(), false),
        unbound(probes::info_spatial(), false),
        unbound(probes::info_directions(), false),
        unbound(probes::info_relight(), false),
        unbound(probes::info_rays(), false),
        listed(stage<probes::ShareKernel>(), false),
        listed(stage<probes::CoefficientsKernel>(), false),
        unbound(probes::info_clusters(), false),
        listed(stage<ddgi::BlendKernel>(), false),
        listed(stage<ddgi::BorderKernel>(), false),
        listed(stage<ddgi::SampleKernel>(), false),
        listed(stage<radiosity::ItemsKernel>(), false),
        listed(stage<radiosity::ReduceKernel>(), false),
        unbound(raster::info_hemicube(), false),
        unbound(raster::info_texture_space(), false),
    };
    return all;
}

}  // namespace plumb
