#include "tools/plumb/case_sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "gi/rsm/sampled.h"
#include "tools/plumb/case_pattern.h"
#include "tools/plumb/slot_array.h"

namespace plumb::cli {

bool is_unit_once_filtered(const io::DumpSpec& spec) { return spec.normalized && spec.sampler && spec.sampler->linear; }

namespace {

// A sampler may keep no more bits of what it blends than a texel of 8 bits has, and cut off or round the rest: by a code at
// most, each time that it blends two. lavapipe does (data/parity/probes.md), and the tests of conformance (VK-GL-CTS,
// functional/texture: lookup precision) allow as much. In units of what the stage reads.
float step_of(const io::DumpSpec& spec) {
    const auto of_8_bits = [&](const std::string& kind) {
        return (spec.vk_format.starts_with("R8") || spec.vk_format.starts_with("B8")) && spec.vk_format.ends_with(kind);
    };
    const Format stored = spec.vk_format.empty() ? io::read_dump(spec).stored : Format::rgba32f;
    const bool unorm = of_8_bits("_UNORM") || stored == Format::rgba8 || (stored == Format::normal8 && spec.encoding == "biased");
    const double code = unorm ? 1.0 / 255 : of_8_bits("_SNORM") ? 1.0 / 127 : 0;
    double scale = spec.encoding == "biased" ? 2 : 1;
    if (!spec.scale.empty()) scale *= std::max(std::fabs(*std::max_element(spec.scale.begin(), spec.scale.end())),
                                               std::fabs(*std::min_element(spec.scale.begin(), spec.scale.end())));
    return float(code * scale * (1 + 0x1p-20));
}

}  // namespace

const StageBinding& sampled_binding(const io::ManifestStage& stage, const StageBinding& binding, const DeviceProfile& profile,
                                    StageData& data) {
    constexpr std::array images = {"rsm_position", "rsm_normal", "rsm_flux"};
    // Filter, address, three of the border's colour and two steps, an image; then the tile's sides, and what follows.
    std::vector<float> sampling;
    bool any = false, linear = false;
    for (const char* image : images) {
        const auto input = stage.inputs.find(image);
        const io::SamplerSpec s = input == stage.inputs.end() ? io::SamplerSpec{} : input->second.sampler.value_or(io::SamplerSpec{});
        any |= input != stage.inputs.end() && input->second.sampler;
        linear |= s.linear;
        sampling.insert(sampling.end(), {float(s.linear), float(s.address), float(s.colour[0]), float(s.colour[1]), float(s.colour[2])});
        const float step = s.linear ? step_of(input->second) : 0.0f;
        const bool fine = step == 0 && profile.bilinear_weight_bits == 0;
        sampling.insert(sampling.end(), {fine ? rsm::fine_fraction : rsm::coarse_fraction, step});
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
        if (spec.along_normal != 0 && !(sampled && name == "rsm_position"))
            throw InputError(fmt::format("{}: input.{}: along_normal: expected it of rsm_position of {}", stage.place, name,
                                         fmt::join(rsm::sampled_stages(), " and ")));
        if (spec.skips_beyond && !sampled)
            throw InputError(fmt::format("{}: input.{}: beyond: expected it of {}", stage.place, name,
                                         fmt::join(rsm::sampled_stages(), " and ")));
        any |= spec.tile[0] > 0 || spec.along_normal != 0 || spec.skips_beyond;
    }
    if (!any) return binding;
    if (linear && pattern_slot(binding)->name == "offsets")
        throw InputError(fmt::format("{}: filter = \"linear\": samples lie on texels{}", stage.place, continuous_stage(binding)));
    const auto pattern = stage.inputs.find("pattern");
    for (const std::size_t side : {0, 1})
        sampling.push_back(pattern == stage.inputs.end() ? 0.0f : float(pattern->second.tile[side]));
    const auto position = stage.inputs.find("rsm_position"), normal = stage.inputs.find("rsm_normal");
    sampling.push_back(position == stage.inputs.end() ? 0.0f : float(position->second.along_normal));
    sampling.push_back(normal != stage.inputs.end() && is_unit_once_filtered(normal->second));
    sampling.push_back(pattern != stage.inputs.end() && pattern->second.skips_beyond);
    Bundle made;
    replace(data.inputs, add(made, "sampling", {std::int64_t(sampling.size())}, sampling.data()));
    return *sampled;
}

}  // namespace plumb::cli
