#include "gi/parity/stages.h"

#include <fmt/format.h>

#include "core/error.h"
#include "gi/compose/compose.h"
#include "gi/direct/direct.h"
#include "gi/direct/log_blur.h"
#include "gi/filter/filter.h"
#include "gi/isr/isr.h"
#include "gi/rsm/gather.h"
#include "raster/bindings.h"

namespace plumb::parity {

const std::vector<StageBinding>& bindings() {
    static const std::vector<StageBinding> all = {
        raster::gbuffer_binding(), raster::gbuffer_layer_binding(), raster::rsm_binding(),
        stage<direct::LogBlurKernel>(), stage<direct::ShadowKernel>(),
        rsm::stage_of(rsm::Gather::disc), rsm::stage_of(rsm::Gather::paths), rsm::stage_of(rsm::Gather::all),
        rsm::stage_of(rsm::Gather::disc, rsm::Texels::continuous),
        rsm::stage_of(rsm::Gather::paths, rsm::Texels::continuous),
        stage<filter::ReduceKernel>(), stage<filter::UpsampleKernel>(), stage<filter::BlurKernel>(),
        stage<isr::DownsampleKernel>(), stage<isr::GatherKernel>(), stage<isr::BounceKernel>(), stage<isr::UnseenKernel>(),
        stage<isr::GatherCameraKernel>(), stage<isr::SsaoKernel>(),
        stage<isr::BlurKernel>(), stage<isr::UpsampleKernel>(), stage<isr::ComposeKernel>(),
        stage<direct::DirectKernel>(), stage<compose::ComposeKernel>(), stage<compose::TonemapKernel>(),
    };
    return all;
}

const StageBinding& find_binding(const std::string& stage, const std::string& place) {
    std::vector<std::string> names;
    for (const StageBinding& b : bindings()) {
        if (b.info.name == stage) return b;
        names.push_back(b.info.name);
    }
    throw InputError(fmt::format("{}: unknown stage \"{}\"; the nearest known one is \"{}\"", place, stage,
                                 nearest_name(stage, names)));
}

}  // namespace plumb::parity
