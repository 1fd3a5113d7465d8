#include "raster/layout.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "core/quantise_kernel.h"

namespace plumb::raster {
namespace {

Layout all_half(const char* name) {
    Layout l;
    l.name = name;
    l.position = l.normal = l.albedo = l.emission = Format::rgba16f;
    l.rsm_position = l.rsm_normal = l.rsm_flux = Format::rgba16f;
    l.depth = l.rsm_depth = l.visibility = Format::r16f;
    l.indirect = Format::rgba16f;
    return l;
}

Layout make_isr() {
    Layout l;
    l.name = "isr";
    l.normal = Format::normal8;
    l.albedo = Format::rgba8;
    l.depth_buffer = Format::d24s8;
    l.position_from_depth = l.depth_over_far = l.radiation_mask = true;
    return l;
}

Layout make_lra() {
    Layout l = all_half("lra");
    l.depth = Format::r32f;
    l.depth_from_position = true;
    l.rsm_depth = l.visibility = Format::r32f;
    l.indirect = Format::rgba32f;
    return l;
}

std::vector<std::string> format_names() {
    std::vector<std::string> names;
    for (const FormatInfo& f : formats()) names.push_back(f.name);
    return names;
}

// A buffer of a layout and the formats that can hold it: signed and far-reaching, unit vectors, or colours.
struct BufferRule {
    const char* name;
    Format Layout::* format;
    const char* meaning;
    std::vector<Format> allowed;
};
const std::vector<BufferRule>& buffer_rules() {
    using enum Format;
    static const std::vector<Format> positions{rgba32f, rgba16f}, depths{r32f, r16f};
    static const std::vector<Format> normals{rgba32f, rgba16f, r10g10b10a2, octahedral16, octahedral8, normal8};
    static const std::vector<Format> colours{rgba32f, rgba16f, rgba8, r11g11b10f, r10g10b10a2, rgbe};
    static const std::vector<Format> radiances{rgba32f, rgba16f, r11g11b10f, rgbe};
    static const std::vector<BufferRule> rules = {
        {"position", &Layout::position, "target of world-space positions, xyz", positions},
        {"normal", &Layout::normal, "target of unit normals", normals},
        {"albedo", &Layout::albedo, "target of the diffuse reflectance", colours},
        {"emission", &Layout::emission, "target of the radiant exitance", radiances},
        {"depth", &Layout::depth, "target of linear eye depth", depths},
        {"depth_buffer", &Layout::depth_buffer, "format of the depth test's buffer", {d32f, d24s8, r32f}},
        {"rsm_position", &Layout::rsm_position, "target of positions in reflective shadow maps", positions},
        {"rsm_normal", &Layout::rsm_normal, "target of normals in reflective shadow maps", normals},
        {"rsm_flux", &Layout::rsm_flux, "target of flux in reflective shadow maps", radiances},
        {"rsm_depth", &Layout::rsm_depth, "target of linear depth in reflective shadow maps", depths},
        {"visibility", &Layout::visibility, "target of each light's shadow density (VRSM fig. 4.3)", depths},
        {"indirect", &Layout::indirect, "target of each gather's irradiance (VRSM fig. 4.4)", positions},
    };
    return rules;
}

}  // namespace

const Layout Layout::fp32{};
const Layout Layout::rgba16f = all_half("rgba16f");
const Layout Layout::vrsm = all_half("vrsm");
const Layout Layout::isr = make_isr();
const Layout Layout::lra = make_lra();

const std::vector<Layout>& layouts() {
    static const std::vector<Layout> all = {Layout::fp32, Layout::rgba16f, Layout::vrsm, Layout::isr, Layout::lra};
    return all;
}

Layout parse_layout(const std::string& name, const std::string& place) {
    int index = 0;
    Field field{"layout", &index, "", "", 0, 0, {}};
    for (const Layout& l : layouts()) field.choices.push_back(l.name);
    field.choices.push_back("custom");
    set_field(field, name, place);
    if (index < int(layouts().size())) return layouts()[std::size_t(index)];
    Layout custom;
    custom.name = "custom";
    return custom;
}

std::vector<Field> fields(Layout& l) {
    std::vector<Field> all;
    for (const BufferRule& rule : buffer_rules())
        all.push_back({rule.name, as_int(l.*rule.format), "", rule.meaning, 0, 0, format_names()});
    auto add = [&](const char* name, bool& value, const char* meaning) {
        all.push_back({name, &value, "", meaning, 0, 0, {}});
    };
    add("position_from_depth", l.position_from_depth, "rebuild positions from the stored depth (ISR 4.3)");
    add("depth_from_position", l.depth_from_position, "take linear depth from the stored position");
    add("depth_over_far", l.depth_over_far, "store depth divided by the far plane (ISR Listing 4)");
    add("radiation_mask", l.radiation_mask, "albedo's alpha: luminance of the reflectance (ISR 4.2)");
    return all;
}

void validate(const Layout& layout, const std::string& place) {
    for (const Layout& preset : layouts())
        if (preset.name == layout.name && !(preset == layout))
            throw InputError(fmt::format("{}: layout \"{}\" is a preset: [layout] is for [render] layout = \"custom\"",
                                         place, layout.name));
    for (const BufferRule& rule : buffer_rules()) {
        const Format format = layout.*rule.format;
        if (std::find(rule.allowed.begin(), rule.allowed.end(), format) != rule.allowed.end()) continue;
        std::vector<std::string> names;
        for (const Format allowed : rule.allowed) names.push_back(info(allowed).name);
        throw InputError(fmt::format("{}: [layout] {} = \"{}\" cannot hold it: expected one of {}", place, rule.name,
                                     info(format).name, fmt::join(names, ", ")));
    }
    if (layout.position_from_depth && layout.depth_from_position)
        throw InputError(place + ": [layout] position_from_depth and depth_from_position: one of them must be stored");
    if (layout.radiation_mask && (layout.albedo == Format::r11g11b10f || layout.albedo == Format::rgbe))
        throw InputError(fmt::format("{}: [layout] radiation_mask: albedo = \"{}\" has no alpha", place,
                                     info(layout.albedo).name));
}

void quantise_rest(Format format, Image4& image, glm::ivec2 first, glm::ivec2 end) {
    if (quantised_by_kernel(format) || image.empty()) return;
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) quantise(format, image(x, y));
}

}  // namespace plumb::raster
