#include "tools/plumb/init_stub.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>

#include "gi/uniform_words.h"
#include "tools/plumb/case_pattern.h"

namespace plumb::cli {

namespace {

bool follows_from_view(const UniformWords& words) { return words.meaning.ends_with("a view_proj gives it"); }

std::string key_of(const std::string& member) {
    return member.find('.') == std::string::npos ? member : "\"" + member + "\"";
}

// What is known without asking.
std::optional<double> known_value(const UniformMember& m, const UniformWords& words, const io::ManifestStage& stage, int map) {
    const std::string inner = m.name.substr(m.name.find('.') == std::string::npos ? 0 : m.name.find('.'));
    if (m.name == "width" && stage.width > 0) return stage.width;
    if (m.name == "height" && stage.height > 0) return stage.height;
    if (inner == ".size" && map > 0) return map;
    if (words.value && words.alone.empty()) return words.value;
    return {};
}

}  // namespace

std::string uniforms_stub(const StageBinding& binding, const io::ManifestStage& stage, int map_side) {
    if (binding.uniforms.empty()) return "";
    std::string text, of_view;
    for (const UniformMember& m : binding.uniforms) {
        const UniformWords* words = words_of(binding, m.name);
        if (!words) continue;
        if (follows_from_view(*words) && m.name.find('.') != std::string::npos) of_view = m.name.substr(0, m.name.find('.'));
        const std::optional<double> value = known_value(m, *words, stage, map_side);
        const std::string unit = words->unit.empty() ? "" : words->unit + ": ";
        const std::string harmless = words->harmless.empty() ? "" : "; harmless: " + words->harmless;
        const std::string all = !value                       ? ""
                                : m.type.starts_with("vec") ? fmt::format("[{}]", fmt::join(std::vector<double>(std::size_t(m.type[3] - '0'), *value), ", "))
                                                            : fmt::format("{}", *value);
        const std::string assigned =
            value ? fmt::format("{} = {}", key_of(m.name), all)
                  : fmt::format("# {} = {}", key_of(m.name), m.type.starts_with("vec") ? "[ ]" : "?");
        text += fmt::format("{}  # {}{}{}\n", assigned, unit, words->meaning, harmless);
    }
    if (pattern_slot(binding))
        text += "# [stage.input.pattern]: the shader's own samples, file = a .npy [N, 3] of dx, dy in texels and weights; it sets "
                "samples, rotations and reach\n";
    if (!of_view.empty())
        text += fmt::format("# instead of what a view_proj gives:\n# [stage.{}]\n# columns = [ 16 numbers ]  # world to clip; or "
                            "rows\n# clip_depth = [-1, 1]       # of OpenGL\n# y = \"up\"                   # of OpenGL, with "
                            "flip_y = true for maps dumped lowest row first\n",
                            of_view == "map" ? "light_view_proj" : "view_proj." + of_view);
    return "[stage.uniforms]  # where a scene is named, it gives them: take this table out\n" + text;
}

}  // namespace plumb::cli
