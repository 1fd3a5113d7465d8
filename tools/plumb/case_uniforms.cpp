#include "tools/plumb/case_uniforms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "core/error.h"
#include "gi/rsm/gather.h"
#include "gi/uniform_words.h"
#include "io/file.h"

namespace plumb::cli {

namespace {

bool has_uniform(const StageBinding& binding, const std::string& name) {
    return std::any_of(binding.uniforms.begin(), binding.uniforms.end(),
                       [&](const UniformMember& m) { return m.name == name; });
}

// Members that the stage's size gives.
std::array<std::pair<const char*, int>, 2> of_size(const StageData& data) {
    return {std::pair("width", data.size.x), std::pair("height", data.size.y)};
}

// ---- Views --------------------------------------------------------------------------------------------------------

// What follows from the matrix of a view, whatever the handedness of the spaces between.
struct SeenView {
    glm::dvec4 x, y, w;     // rows of world to clip, y downwards
    glm::dvec3 eye, forward;
    bool perspective;
    double at_unit;         // w at a depth of 1 m; of parallel rays w everywhere

    explicit SeenView(const io::ViewSpec& spec) {
        auto row = [&](std::size_t r) {
            const double* m = &spec.view_proj[4 * r];
            return glm::dvec4(m[0], m[1], m[2], m[3]);
        };
        x = row(0), y = spec.y_up ? -row(1) : row(1), w = row(3);
        const glm::dvec4 z = row(2);
        perspective = w.x != 0 || w.y != 0 || w.z != 0;
        if (perspective) {
            // Where x, y and w are 0 all rays meet, and w grows along the axis.
            forward = glm::dvec3(w), at_unit = length(forward);
            eye = solved(spec, glm::dvec3(x), glm::dvec3(y), glm::dvec3(w), -glm::dvec3(x.w, y.w, w.w));
        } else {
            // A point of the near plane, and the way in which depth grows.
            const double nearest = spec.reversed_z ? 1 : spec.below_zero ? -1 : 0;
            forward = glm::dvec3(z) * ((spec.reversed_z ? -1.0 : 1.0) * (w.w < 0 ? -1.0 : 1.0)), at_unit = w.w;
            eye = solved(spec, glm::dvec3(x), glm::dvec3(y), glm::dvec3(z), -glm::dvec3(x.w, y.w, z.w - nearest * w.w));
        }
        const double size = length(forward);
        if (!(size > 0) || !(std::fabs(at_unit) > 0)) fail(spec);
        forward /= size;
    }

    // How much clip x or y changes over 1 m across the axis.
    double across(const glm::dvec4& row) const {
        const glm::dvec3 a(row);
        return length(a - forward * glm::dot(a, forward));
    }

  private:
    static double length(const glm::dvec3& v) { return std::sqrt(glm::dot(v, v)); }
    [[noreturn]] static void fail(const io::ViewSpec& spec) {
        throw InputError(spec.place + ": is no view: expected a matrix from world to clip space that has an inverse");
    }
    static glm::dvec3 solved(const io::ViewSpec& spec, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                             const glm::dvec3& right) {
        const glm::dmat3 m = glm::transpose(glm::dmat3(a, b, c));
        if (!(std::fabs(glm::determinant(m)) > 0)) fail(spec);
        return glm::inverse(m) * right;
    }
};

std::vector<double> four(const glm::dvec3& v, double w) { return {v.x, v.y, v.z, w}; }

// clip / w is -1 to 1 across `side` texels.
std::vector<double> in_texels(const glm::dvec4& row, const glm::dvec4& w, int side) {
    const glm::dvec4 texels = (row + w) * (0.5 * side);
    return {texels.x, texels.y, texels.z, texels.w};
}

// raster/project_kernel.h, and what shadow tests and paths hold of the same light.
std::map<std::string, std::vector<double>> members_of_map(const std::string& name, const SeenView& view, int side) {
    const double footprint = 2 * view.at_unit / (view.across(view.x) * side);
    const double half = 0.5 * side;
    const glm::dvec4 area = rsm::texel_area((view.x + view.w) * half, (view.y + view.w) * half, view.w);
    return {{name + ".to_texel_x", in_texels(view.x, view.w, side)},
            {name + ".to_texel_y", in_texels(view.y, view.w, side)},
            {"texel_area", {area.x, area.y, area.z, area.w}},
            {name + ".to_texel_w", four(glm::dvec3(view.w), view.w.w)},
            {name + ".size", {double(side)}},
            {"eye", four(view.eye, 0)},
            {"forward", four(view.forward, 0)},
            {"axis", four(-view.forward, 0)},
            {"perspective", {view.perspective ? 1.0 : 0.0}},
            {"footprint_scale", {view.perspective ? footprint : 0}},
            {"footprint_base", {view.perspective ? 0 : footprint}}};
}

// gi/screen/view_kernel.h: rows take what is seen from the anchor, and depth is in metres.
std::map<std::string, std::vector<double>> members_of_view(const std::string& name, const SeenView& view, glm::ivec2 size) {
    const glm::dvec3 anchor{glm::vec3(view.eye)};
    auto from_anchor = [&](const std::vector<double>& row) {
        const glm::dvec3 a(row[0], row[1], row[2]);
        return four(a / view.at_unit, (glm::dot(a, anchor) + row[3]) / view.at_unit);
    };
    return {{name + ".anchor", four(anchor, 0)},
            {name + ".forward", four(view.forward, glm::dot(view.forward, anchor - view.eye))},
            {name + ".to_x", from_anchor(in_texels(view.x, view.w, size.x))},
            {name + ".to_y", from_anchor(in_texels(view.y, view.w, size.y))},
            {name + ".width", {double(size.x)}},
            {name + ".height", {double(size.y)}},
            {name + ".perspective", {view.perspective ? 1.0 : 0.0}}};
}

// The image that the view sees: of a size of its own, or the frame's where there is no such input.
glm::ivec2 image_of(const StageBinding& binding, const StageData& data) {
    for (const Slot& slot : binding.inputs) {
        const Array* image = slot.kind == SlotKind::image && !slot.frame ? find(data.inputs, slot.name) : nullptr;
        if (image && image->shape.size() >= 2) return {int(image->shape[1]), int(image->shape[0])};
    }
    return data.size;
}

// Names of what it has set.
std::vector<std::string> set_view(const io::ManifestStage& stage, const std::string& name, const io::ViewSpec& spec,
                                  const StageBinding& binding, StageData& data) {
    const bool map = has_uniform(binding, name + ".to_texel_x");
    if (!map && !has_uniform(binding, name + ".anchor"))
        throw InputError(fmt::format("{}: {} has no view \"{}\" in its uniforms that a matrix could give", spec.place,
                                     binding.info.name, name));
    const glm::ivec2 size = image_of(binding, data);
    if (map && size.x != size.y)
        throw InputError(fmt::format("{}: the light's map is {} x {}: expected a square", spec.place, size.x, size.y));
    const SeenView view(spec);
    std::vector<std::string> names;
    for (const auto& [member, value] : map ? members_of_map(name, view, size.x) : members_of_view(name, view, size)) {
        if (!has_uniform(binding, member)) continue;
        // A map's size is its images', whoever says it.
        const bool sized = member == name + ".size" || member == name + ".width" || member == name + ".height";
        if (sized && stage.uniforms.count(member)) continue;
        // What a shader has beside the matrix, as where the light is, goes before what follows from it.
        const bool of_view = member.starts_with(name + ".");
        if (!of_view && stage.uniforms.count(member)) continue;
        if (stage.uniforms.count(member))
            throw InputError(fmt::format("{}: gives {}, which [stage.uniforms] gives, too", spec.place, member));
        set_uniform(binding, data, member, value, spec.place);
        names.push_back(member);
    }
    return names;
}

}  // namespace

void set_uniforms(const io::ManifestStage& stage, const StageBinding& binding, StageData& data) {
    const std::string place = stage.place + ": uniforms";
    const bool whole = !data.uniforms.empty() || !stage.uniforms_file.empty();
    if (!stage.uniforms_file.empty()) {
        const std::vector<unsigned char> bytes = io::read_bytes(stage.uniforms_file.string(), 1 << 20);
        if (bytes.size() != binding.uniform_bytes)
            throw InputError(fmt::format("{}: {} has {} bytes: the block of {} has {}", place,
                                         io::shown(stage.uniforms_file.string()), bytes.size(), stage.stage,
                                         binding.uniform_bytes));
        data.uniforms = bytes;
    }
    data.uniforms.resize(binding.uniform_bytes);
    for (const auto& [name, side] : of_size(data)) {
        const double number = side;
        if (!whole && has_uniform(binding, name)) set_uniform(binding, data, name, {&number, 1}, "size");
    }
    for (const auto& [name, value] : stage.uniforms) set_uniform(binding, data, name, value, place);
    for (const auto& [name, side] : of_size(data))
        if (has_uniform(binding, name) && uniform_value(binding, data, name)[0] != side)
            throw InputError(fmt::format("{}: {} = {}: the stage's outputs are {} x {}", place, name,
                                         uniform_value(binding, data, name)[0], data.size.x, data.size.y));
}

namespace {

// What a word of gi/uniform_words.h says may be taken, once all others are set.
std::optional<double> harmless(const StageBinding& binding, const StageData& data, const UniformMember& member) {
    const UniformWords* words = words_of(binding, member.name);
    if (!words || !words->value) return {};
    if (words->alone.empty()) return words->value;
    // A member of the same struct.
    const std::size_t dot = member.name.find('.');
    const std::string alone = (dot == std::string::npos ? "" : member.name.substr(0, dot + 1)) + words->alone;
    return uniform_value(binding, data, alone)[0] == 1 ? words->value : std::nullopt;
}

}  // namespace

void complete_uniforms(const io::ManifestStage& stage, const StageBinding& binding, bool whole, bool pattern,
                       StageData& data, std::vector<std::string>& notes) {
    std::vector<std::string> given = {"width", "height"};
    for (const auto& [name, value] : stage.uniforms) given.push_back(name);
    if (pattern) given.insert(given.end(), {"samples", "rotations", "reach"});
    // Which of a tile's patterns a pixel has follows from its place, and not from the hash.
    if (pattern && stage.inputs.at("pattern").tile[0] > 0 && has_uniform(binding, "seed")) {
        set_uniform(binding, data, "seed", std::vector<double>{0}, stage.place);
        given.push_back("seed");
    }
    for (const auto& [name, spec] : stage.views) {
        const std::vector<std::string> set = set_view(stage, name, spec, binding, data);
        given.insert(given.end(), set.begin(), set.end());
    }
    if (whole) return;
    std::vector<std::string> missing, taken;
    for (const UniformMember& m : binding.uniforms) {
        if (std::find(given.begin(), given.end(), m.name) != given.end()) continue;
        const std::optional<double> value = harmless(binding, data, m);
        if (!value) {
            missing.push_back(m.name);
            continue;
        }
        const std::vector<double> all(uniform_value(binding, data, m.name).size(), *value);
        set_uniform(binding, data, m.name, all, stage.place);
        taken.push_back(fmt::format("{} = {}", m.name, *value));
    }
    if (!missing.empty())
        throw InputError(fmt::format("{}: uniforms: missing: {}; give them by name, the block as file = \"...\", or a scene; "
                                     "`plumb stages` explains them", stage.place, fmt::join(missing, ", ")));
    if (!taken.empty())
        notes.push_back(fmt::format("uniforms that were not given are taken as harmless: {}", fmt::join(taken, ", ")));
}

}  // namespace plumb::cli
