#include "gi/frame/frame.h"

#include <algorithm>

#include "gi/direct/log_blur.h"
#include "gi/rsm/all_rays.h"
#include "raster/hemicube.h"
#include "raster/texture_space.h"

namespace plumb::frame {

namespace {

std::vector<StageInfo> frame_stages() {
    return {raster::info_gbuffer(), raster::info_gbuffer_layer(), raster::info_rsm(), stage<direct::LogBlurKernel>().info,
            stage<direct::ShadowKernel>().info, rsm::stage_of(rsm::Gather::disc).info,
            rsm::stage_of(rsm::Gather::disc, rsm::Texels::continuous).info, rsm::stage_of(rsm::Gather::paths).info,
            rsm::stage_of(rsm::Gather::paths, rsm::Texels::continuous).info, rsm::stage_of(rsm::Gather::all).info,
            rsm::info_all_rays(), stage<direct::DirectKernel>().info,
            stage<isr::DownsampleKernel>().info, stage<isr::GatherKernel>().info, stage<isr::BounceKernel>().info,
            stage<isr::UnseenKernel>().info, stage<isr::GatherCameraKernel>().info, stage<isr::SsaoKernel>().info,
            stage<isr::BlurKernel>().info, stage<isr::UpsampleKernel>().info, stage<isr::ComposeKernel>().info,
            stage<filter::ReduceKernel>().info, stage<filter::UpsampleKernel>().info, stage<filter::BlurKernel>().info,
            stage<compose::ComposeKernel>().info, reference::info(),    stage<compose::TonemapKernel>().info};
}

}  // namespace

bool is_gather(const std::string& stage) {
    for (const auto& [gather, texels] : rsm::gather_stages)
        if (stage == rsm::stage_name(gather, texels)) return true;
    return false;
}

const Traced* find_traced(const Frame& frame, const std::string& layer) {
    for (const Traced& traced : frame.traced)
        if (traced.layer == layer) return &traced;
    return nullptr;
}

std::vector<StageInfo> all_stages() {
    std::vector<StageInfo> all = frame_stages();
    all.push_back(raster::info_hemicube());
    all.push_back(raster::info_texture_space());
    return all;
}

bool in_a_frame(const std::string& stage) {
    const std::vector<StageInfo> stages = frame_stages();
    return std::any_of(stages.begin(), stages.end(), [&](const StageInfo& s) { return s.name == stage; });
}

}  // namespace plumb::frame
