#include "tools/experiments/some_receivers.h"

namespace plumb::cli {

probes::Receivers some_of(const probes::Receivers& all, const std::vector<int>& index) {
    probes::Receivers some;
    some.size = all.size;
    for (const int i : index) {
        const std::size_t at = std::size_t(i);
        some.position.push_back(all.position[at]), some.normal.push_back(all.normal[at]), some.shift.push_back(all.shift[at]);
        some.texel.push_back(all.texel[at]), some.material.push_back(all.material[at]), some.triangle.push_back(all.triangle[at]);
        some.border.push_back(all.border[at]);
    }
    return some;
}

}  // namespace plumb::cli
