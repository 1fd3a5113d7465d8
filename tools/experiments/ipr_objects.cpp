// plumb experiment ipr: what moves, in frames (IPR 5.2.1.3 to 5.2.1.6): layers of shading, shadows, static light, normal maps.
//
// Held against path traced radiance: of what moves, of its shadow, or of what has a normal map.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/error.h"
#include "tools/experiments/ipr_parts.h"
#include "tools/experiments/ipr_pictures.h"

namespace plumb::cli {

namespace {

using Pixels = Image<std::uint8_t>;

bool moves(const Mesh& m) { return m.dynamic && !m.triangles.empty(); }

// Materials of meshes that move, or of those that do not.
std::set<std::int32_t> materials_of(const Scene& scene, bool dynamic) {
    std::set<std::int32_t> used;
    for (const Mesh& m : scene.meshes)
        if (m.dynamic == dynamic) used.insert(m.material.begin(), m.material.end());
    return used;
}

// A bake knows which texture a material with a normal map has: it stays, in one colour. Alpha stays.
void fill_with_mean(Texture& t) {
    std::uint64_t sum[3] = {};
    for (const std::uint32_t texel : t.texels.texels)
        for (int c = 0; c < 3; ++c) sum[c] += texel >> (8 * c) & 255;
    std::uint32_t mean = 0;
    for (int c = 0; c < 3; ++c) mean |= std::uint32_t(sum[c] / std::max(t.texels.size(), std::size_t(1))) << (8 * c);
    for (std::uint32_t& texel : t.texels.texels) texel = (texel & 0xff000000u) | mean;
}

// Whether a frame knows the key; it is set where it does.
bool set_key(probes::RunParams& run, const std::string& name, const std::string& value) {
    std::vector<Field> all = probes::fields(run);
    const auto found = std::find_if(all.begin(), all.end(), [&](const Field& f) { return f.name == name; });
    if (found == all.end()) return false;
    set_field(*found, FieldValue(value), "experiment ipr: probes." + name);
    return true;
}

class Objects {
  public:
    explicit Objects(const IprPart& part) : part_(part), scene_(part.scene) {
        scene_.frame_size = part.request.size;
        base_.bake = as_published(part);
        base_.bake.placement.count = 11, base_.bake.spatial_receivers = part.request.quick ? 200 : 4096;
        base_.bake.lightmap_size = part.size_for(base_.bake, part.request.quick ? 700 : 15608, 256);
    }

    void layers();
    void shadow();
    void static_light();
    void normal_maps();

  private:
    IprSheet begin(const std::string& id, const std::string& title, const std::string& where) const {
        IprSheet sheet{id, title, "errors: of radiance, against path tracing of the whole scene", {{"pixels"}, {"SSIM truth", 4}}, {}, {}, {}};
        add_error_heads(sheet.heads, where);
        return sheet;
    }
    IprVariant traced() const {
        IprVariant v = base_;
        v.traced = true;
        return v;
    }
    frame::Frame frame_of(const Scene& scene, const IprVariant& variant) {
        (void)part_.bench.bake(variant.bake);
        return part_.bench.frame_of(scene, variant);
    }
    static const reference::Estimate& truth_of(const frame::Frame& f) {
        const frame::Traced* traced = frame::find_traced(f, "truth");
        if (!traced) throw InputError("the frame has no traced truth");
        return traced->estimate;
    }
    // Of the scene as it is, traced once.
    const reference::Estimate& own_truth() {
        if (own_truth_.mean.empty()) own_truth_ = truth_of(frame_of(scene_, traced()));
        return own_truth_;
    }
    // truth: of the frame itself, or of another.
    IprSheetRow row_of(const std::string& name, const std::string& settings, const frame::Frame& f, const reference::Estimate& truth, const Pixels& pixels) const;
    Pixels moving(const frame::Frame& f) const;
    void leave_out(const std::string& what, const std::string& why) { part_.result.left_out.push_back(what + ": " + why); }

    const IprPart& part_;
    Scene scene_;
    IprVariant base_;
    reference::Estimate own_truth_;
};

Pixels Objects::moving(const frame::Frame& f) const {
    Pixels pixels(f.gbuffer.id.width, f.gbuffer.id.height);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const int object = f.gbuffer.id.texels[i].x;
        pixels.texels[i] = object >= 0 && scene_.meshes[std::size_t(object)].dynamic ? 1 : 0;
    }
    return pixels;
}

IprSheetRow Objects::row_of(const std::string& name, const std::string& settings, const frame::Frame& f, const reference::Estimate& truth, const Pixels& pixels) const {
    const double white = white_of(truth.mean);
    const Image4 display = displayed(f.radiance, white), traced = displayed(truth.mean, white);
    IprSheetRow row{name, settings, {}, {}};
    row.values = {double(std::count(pixels.texels.begin(), pixels.texels.end(), 1)), ssim_of(display, traced)};
    std::optional<IprErrors> errors;
    const compare::Plane own = compare::luminances(f.radiance), plane = compare::luminances(truth.mean), error = compare::luminance_errors(truth.error);
    if (*row.values[0] > 0) errors = ipr_errors(own, plane, error, pixels);
    add_error_values(row.values, errors);
    row.pictures = {{"", display}, {"path traced", traced}};
    if (errors) row.pictures.push_back({"error of radiance", error_picture(own, plane, error, pixels, 0.1 * errors->truth)});
    return row;
}

// Figure 5.20.
void Objects::layers() {
    part_.tell("figure 5.20: layers of shading");
    Scene plain = scene_;
    for (const std::int32_t m : materials_of(scene_, true))
        if (const int t = scene_.materials[std::size_t(m)].texture; t >= 0) fill_with_mean(plain.textures[std::size_t(t)]);
    IprSheet sheet = begin("figure 5.20", "layers of shading of what moves", "what moves");
    struct Layer {
        const char *name, *relief;
        bool texture;
    };
    bool known = true;
    const reference::Estimate plain_truth = truth_of(frame_of(plain, traced()));
    for (const Layer& l : {Layer{"diffuse", "off", false}, {"normal maps", "normals", false}, {"diffuse, specular", "specular", false}, {"all, texture", "all", true}}) {
        IprVariant v = base_;
        known = set_key(v.run, "relief", l.relief);
        if (!known && std::string(l.relief) != "off" && !l.texture) continue;
        const frame::Frame f = frame_of(l.texture ? scene_ : plain, v);
        sheet.rows.push_back(row_of(l.name, l.texture ? "" : "textures are their mean colour", f, l.texture ? own_truth() : plain_truth, moving(f)));
    }
    if (!known) sheet.lines.push_back("frames show neither normal maps nor highlights of indirect light: there is no probes.relief");
    part_.result.sheets.push_back(std::move(sheet));
}

// Figure 5.21.
void Objects::shadow() {
    part_.tell("figure 5.21: shadow of what moves");
    IprSheet sheet = begin("figure 5.21", "shadow of what moves", "shadow");
    sheet.notes += "; of static pixels whose direct light it changes; then of all static pixels in view";
    Scene alone = scene_;
    for (Mesh& m : alone.meshes)
        if (m.dynamic) m.triangles.clear(), m.material.clear();
    const frame::Frame with = frame_of(scene_, base_), without = frame_of(alone, base_);
    Pixels shadow(with.direct.width, with.direct.height), still = shadow;
    const Pixels moved = moving(with);
    for (std::size_t i = 0; i < shadow.size(); ++i) {
        still.texels[i] = with.gbuffer.normal.texels[i].w != 0 && !moved.texels[i] ? 1 : 0;
        shadow.texels[i] = still.texels[i] && with.direct.texels[i] != without.direct.texels[i] ? 1 : 0;
    }
    sheet.rows.push_back(row_of("with shadow", "where it falls", with, own_truth(), shadow));
    sheet.rows.push_back(row_of("without", "where it falls", without, own_truth(), shadow));
    sheet.rows.push_back(row_of("with shadow", "all static pixels", with, own_truth(), still));
    sheet.rows.back().pictures.clear();
    part_.result.sheets.push_back(std::move(sheet));
}

// Figure 5.22.
void Objects::static_light() {
    part_.tell("figure 5.22: static light on what moves");
    IprSheet sheet = begin("figure 5.22", "static light sources on what moves", "what moves");
    Scene dark = scene_;
    dark.lights.clear(), dark.environment = {};
    const std::set<std::int32_t> walls = materials_of(scene_, false);
    std::vector<std::int32_t> lamps, colours;
    for (const std::int32_t m : walls) {
        (scene_.materials[std::size_t(m)].emission != glm::vec3(0) ? lamps : colours).push_back(m);
        dark.materials[std::size_t(m)].emission = glm::vec3(0);
    }
    // The most colourful first: blending shows there.
    const auto saturation = [&](std::int32_t m) {
        const glm::vec3& r = scene_.materials[std::size_t(m)].reflectance;
        const float most = std::max({r.x, r.y, r.z});
        return most > 0 ? (most - std::min({r.x, r.y, r.z})) / most : 0;
    };
    std::stable_sort(colours.begin(), colours.end(), [&](std::int32_t a, std::int32_t b) { return saturation(a) > saturation(b); });
    std::vector<std::vector<std::int32_t>> sets;
    if (!lamps.empty()) sets.push_back(lamps);
    if (!colours.empty()) sets.push_back({colours[0]});
    if (colours.size() > 1) sets.push_back({colours[0], colours[1]});
    for (const std::vector<std::int32_t>& set : sets) {
        Scene lit = dark;
        std::string names;
        for (const std::int32_t m : set) {
            const Material& own = scene_.materials[std::size_t(m)];
            lit.materials[std::size_t(m)].emission = own.emission != glm::vec3(0) ? own.emission : 10.0f * own.reflectance;
            names += (names.empty() ? "" : ", ") + own.name;
        }
        const frame::Frame f = frame_of(lit, traced());
        sheet.rows.push_back(row_of(names, "emits, lamps are off", f, truth_of(f), moving(f)));
    }
    // Lamps as static ones: they light what moves by spatial receivers alone.
    std::string names;
    for (const Light& l : scene_.lights) names += (names.empty() ? "" : ", ") + l.name;
    IprVariant fixed = base_;
    if (!names.empty() && set_key(fixed.run, "static_lamps", names)) {
        const frame::Frame f = frame_of(scene_, fixed);
        sheet.rows.push_back(row_of(names, "static lamps", f, own_truth(), moving(f)));
    }
    part_.result.sheets.push_back(std::move(sheet));
}

// Figure 5.23.
void Objects::normal_maps() {
    const std::set<std::int32_t> walls = materials_of(scene_, false);
    const auto mapped = [&](std::int32_t m) { return scene_.materials[std::size_t(m)].normal_texture >= 0; };
    if (std::none_of(walls.begin(), walls.end(), mapped)) return leave_out("figure 5.23", "nothing static has a normal map in this scene");
    IprVariant off = base_, on = base_;
    if (!set_key(off.run, "relief", "off") || !set_key(on.run, "relief", "all"))
        return leave_out("figure 5.23", "frames show no normal maps in indirect light: there is no probes.relief");
    part_.tell("figure 5.23: normal maps of the static scene");
    IprSheet sheet = begin("figure 5.23", "normal maps of the static scene", "static pixels");
    const frame::Frame without = frame_of(scene_, off), with = frame_of(scene_, on);
    Pixels still = moving(without);
    for (std::size_t i = 0; i < still.size(); ++i) still.texels[i] = without.gbuffer.normal.texels[i].w != 0 && !still.texels[i] ? 1 : 0;
    sheet.rows.push_back(row_of("without", "probes.relief = off", without, own_truth(), still));
    sheet.rows.push_back(row_of("with", "probes.relief = all", with, own_truth(), still));
    part_.result.sheets.push_back(std::move(sheet));
}

}  // namespace

void measure_objects(const IprPart& part) {
    Objects objects(part);
    const auto add = [&](const char* name, void (Objects::*measure)()) {
        try {
            (objects.*measure)();
        } catch (const InputError& e) {
            part.result.left_out.push_back(std::string(name) + ": " + e.what());
        }
    };
    if (std::any_of(part.scene.meshes.begin(), part.scene.meshes.end(), moves)) {
        add("figure 5.20", &Objects::layers);
        add("figure 5.21", &Objects::shadow);
        add("figure 5.22", &Objects::static_light);
    } else
        part.result.left_out.push_back("figures 5.20 to 5.22: nothing moves in this scene");
    add("figure 5.23", &Objects::normal_maps);
}

}  // namespace plumb::cli
