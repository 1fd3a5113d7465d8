#include "core/kernel_stage.h"
#include "gi/rsm/descriptions.h"
#include "twins/gi.rsm.gather.comp.h"
#include "twins/gi.rsm.gather_all.comp.h"
#include "twins/gi.rsm.gather_continuous.comp.h"
#include "twins/gi.rsm.paths.comp.h"
#include "twins/gi.rsm.paths_continuous.comp.h"

namespace plumb {

using namespace rsm;

template <>
const StageBinding& stage<DiscKernel<false>>() {
    return made<DiscKernel<false>, twins::gi_rsm_gather_comp, DiscKernel<false, Half>>();
}
template <>
const StageBinding& stage<DiscKernel<true>>() {
    return made<DiscKernel<true>, twins::gi_rsm_gather_continuous_comp, DiscKernel<true, Half>>();
}
template <>
const StageBinding& stage<PathsKernel<false>>() {
    return made<PathsKernel<false>, twins::gi_rsm_paths_comp, PathsKernel<false, Half>>();
}
template <>
const StageBinding& stage<PathsKernel<true>>() {
    return made<PathsKernel<true>, twins::gi_rsm_paths_continuous_comp, PathsKernel<true, Half>>();
}
template <>
const StageBinding& stage<AllKernel>() { return made<AllKernel, twins::gi_rsm_gather_all_comp>(); }

const StageBinding& rsm::stage_of(Gather gather, Texels texels) {
    const bool continuous = texels == Texels::continuous;
    switch (gather) {
        case Gather::disc: return continuous ? stage<DiscKernel<true>>() : stage<DiscKernel<false>>();
        case Gather::paths: return continuous ? stage<PathsKernel<true>>() : stage<PathsKernel<false>>();
        case Gather::all: return stage<AllKernel>();
        case Gather::all_rays: break;
    }
    throw std::logic_error("rsm.all_rays is bound to no device");
}

}  // namespace plumb
