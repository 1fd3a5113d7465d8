#include "tools/plumb/case_sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/error.h"
#include "gi/rsm/sampled.h"
#include "tools/plumb/case_pattern.h"
#include "tools/plumb/slot_array.h"

namespace plumb::cli {

const StageBinding& sampled_binding(const io::ManifestStage& stage, const StageBinding& binding, StageData& data) {
    constexpr std::array images = {"rsm_position", "rsm_normal", "rsm_flux"};
    // Filter, address, and three of the border's colour, an image; then the tile's sides.
    std::vector<float> sampling;
    bool any = false, linear = false;
    for (const char* image : images) {
        const auto input = stage.inputs.find(image);
        const io::SamplerSpec s = input == stage.inputs.end() ? io::SamplerSpec{} : input->second.sampler.value_or(io::SamplerSpec{});
        any |= input != stage.inputs.end() && input->second.sampler;
        linear |= s.linear;
        sampling.insert(sampling.end(), {float(s.linear), float(s.address), float(s.colour[0]), float(s.colour[1]), float(s.colour[2])});
    }
    const StageBinding* sampled = rsm::sampled_stage(binding.info.name);
    for (const auto& [name, spec] : stage.inputs) {
        const bool of_map = sampled && std::find(images.begin(), images.end(), name) != images.end();
        if (spec.sampler && !of_map)
            throw InputError(fmt::format("{}: input.{}: filter, address and border are of the light's map of {}", stage.place,
                                         name, fmt::join(rsm::sampled_stages(), " and ")));
        if (spec.tile[0] > 0 && !sampled)
            throw InputError(fmt::format("{}: input.{}: tile: {} has no such pattern; expected {}", stage.place, name,
                                         binding.info.name, fmt::join(rsm::sampled_stages(), " or ")));
        any |= spec.tile[0] > 0;
    }
    if (!any) return binding;
    if (linear && pattern_slot(binding)->name == "offsets")
        throw InputError(fmt::format("{}: filter = \"linear\": samples lie on texels{}", stage.place, continuous_stage(binding)));
    const auto pattern = stage.inputs.find("pattern");
    for (const std::size_t side : {0, 1})
        sampling.push_back(pattern == stage.inputs.end() ? 0.0f : float(pattern->second.tile[side]));
    Bundle made;
    replace(data.inputs, add(made, "sampling", {std::int64_t(sampling.size())}, sampling.data()));
    return *sampled;
}

}  // namespace plumb::cli
