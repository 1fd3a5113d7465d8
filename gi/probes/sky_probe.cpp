#include "gi/probes/sky_probe.h"

namespace plumb::probes {

void add_sky(Supports& supports, const Buffer<glm::vec4>& probes) {
    if (standing_probes(probes) == int(probes.size())) return;
    const std::size_t slots = std::size_t(supports.overlaps), receivers = supports.probe.size() / slots;
    Buffer<std::int32_t> probe;
    Buffer<float> weight;
    probe.reserve(receivers * (slots + 1)), weight.reserve(receivers * (slots + 1));
    for (std::size_t i = 0; i < receivers; ++i) {
        const auto first = std::ptrdiff_t(i * slots), last = first + std::ptrdiff_t(slots);
        probe.insert(probe.end(), supports.probe.begin() + first, supports.probe.begin() + last);
        weight.insert(weight.end(), supports.weight.begin() + first, supports.weight.begin() + last);
        probe.push_back(std::int32_t(probes.size()) - 1), weight.push_back(1);
    }
    supports.probe = std::move(probe), supports.weight = std::move(weight), supports.overlaps += 1;
    supports.unsupported = 0;
}

}  // namespace plumb::probes
