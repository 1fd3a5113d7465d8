#include "core/kernel_stage.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/items.h"
#include "gi/radiosity/lookup.h"
#include "gi/radiosity/reduce.h"
#include "twins/gi.radiosity.gather.comp.h"
#include "twins/gi.radiosity.items.comp.h"
#include "twins/gi.radiosity.lookup.comp.h"
#include "twins/gi.radiosity.reduce.comp.h"

namespace plumb {

using namespace radiosity;

// Their items are for one lane.
template <>
inline constexpr bool by_packets<ItemsKernel> = false;
template <>
inline constexpr bool by_packets<GatherKernel> = false;

template <>
const StageBinding& stage<GatherKernel>() { return made<GatherKernel, twins::gi_radiosity_gather_comp>(); }
template <>
const StageBinding& stage<ItemsKernel>() { return made<ItemsKernel, twins::gi_radiosity_items_comp>(); }
template <>
const StageBinding& stage<LookupKernel>() { return made<LookupKernel, twins::gi_radiosity_lookup_comp>(); }
template <>
const StageBinding& stage<ReduceKernel>() { return made<ReduceKernel, twins::gi_radiosity_reduce_comp>(); }

}  // namespace plumb
