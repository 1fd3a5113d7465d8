// What the kernels of all_rays_kernel.h read: the texels of a light's maps that shine, in the order in which they are
// asked.
#pragma once

#include <span>
#include <vector>

#include "core/image.h"
#include "gi/rsm/all_rays.h"
#include "gi/rsm/all_rays_kernel.h"

namespace plumb::rsm {

struct LitTexels {
    Buffer<float> records;                          // [lit][record_stride]
    std::vector<std::int32_t> map_ends, row_ends;   // of the complete sum
    std::vector<std::int32_t> starts, firsts;       // of a subset

    std::int32_t count() const { return std::int32_t(records.size() / record_stride); }
};

// Everything that a run or an explanation starts from; `view` points into the texels and into the inputs. Moves, but is
// not copied.
struct AllRaysData {
    RaysReport report;
    LitTexels texels;
    AllRaysView view{};

    AllRaysData() = default;
    AllRaysData(AllRaysData&&) = default;
};

// Throws what validate() of gather.h throws for a map that is not left out.
AllRaysData prepare_all_rays(const GatherParams& params, const GatherInputs& inputs,
                             std::span<const raster::Rsm> maps);

}  // namespace plumb::rsm
