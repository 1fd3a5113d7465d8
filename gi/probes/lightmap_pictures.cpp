#include "gi/probes/lightmap_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/compare_pictures.h"
#include "gi/compose/tonemap_kernel.h"
#include "gi/probes/scene_view.h"

namespace plumb::probes {

namespace {

const glm::vec4 red(0.95f, 0.1f, 0.1f, 1), magenta(0.9f, 0.2f, 0.9f, 1), yellow(1, 0.85f, 0.1f, 1), orange(1, 0.5f, 0.1f, 1),
    cyan(0.1f, 0.8f, 0.9f, 1), dim(0.4f, 0.4f, 0.43f, 1), inside(0.4f, 0.5f, 0.85f, 1);

// White is 2.5 times the median.
glm::vec4 shown(const glm::vec4& light, double median) {
    glm::vec4 colour(0, 0, 0, 1);
    for (int c = 0; c < 3; ++c)
        colour[c] = compose::srgb_encode(float(std::clamp(double(light[c]) / (2.5 * (median > 0 ? median : 1)), 0.0, 1.0)));
    return colour;
}

template <class ColourOf>
Image4 on_receivers(const Receivers& r, ColourOf colour) {
    Image4 picture(r.size.x, r.size.y, nothing);
    for (int i = 0; i < r.count(); ++i) picture(r.texel[std::size_t(i)].x, r.texel[std::size_t(i)].y) = colour(i);
    return picture;
}

double luminance(const glm::vec4& v) { return compare::luminance(glm::dvec3(v)); }

Image4 error_picture(const Image4& map, const Receivers& r, const ReceiverIrradiance& truth, const LightmapCheck& check) {
    compare::Plane user(r.count(), 1), light(r.count(), 1), error(r.count(), 1);
    for (int i = 0; i < r.count(); ++i) {
        const glm::ivec2 t = r.texel[std::size_t(i)];
        user(i, 0) = luminance(map(t.x, t.y));
        light(i, 0) = luminance(truth.mean[std::size_t(i)]), error(i, 0) = luminance(check.error[std::size_t(i)]);
    }
    const compare::Plane relative = compare::relative_errors(user, light, 0.05 * check.median, error, check.sigmas);
    return on_receivers(r, [&](int i) { return glm::vec4(compare::signed_color(relative(i, 0), picture_swing), 1); });
}

// From dark grey over yellow to red: nothing, and `full`.
glm::vec4 excess_colour(double excess, double full) {
    const float t = float(std::min(excess / full, 1.0));
    return t < 0.5f ? glm::mix(glm::vec4(0.45f, 0.45f, 0.5f, 1), yellow, 2 * t) : glm::mix(yellow, red, 2 * t - 1);
}

void draw(Image4& picture, const glm::dvec2& from, const glm::dvec2& to, const glm::vec4& colour) {
    const glm::dvec2 d = to - from;
    const int steps = 1 + int(2 * std::max(std::fabs(d.x), std::fabs(d.y)));
    for (int k = 0; k <= steps; ++k) {
        const glm::ivec2 at(glm::floor(from + d * (double(k) / steps)));
        if (at.x >= 0 && at.y >= 0 && at.x < picture.width && at.y < picture.height) picture(at.x, at.y) = colour;
    }
}

Image4 seam_picture(const Receivers& r, const LightmapCheck& check, double full) {
    Image4 picture = on_receivers(r, [](int) { return dim; });
    for (auto seam = check.seams.rbegin(); seam != check.seams.rend(); ++seam) {  // the worst one on top
        const glm::vec4 colour = excess_colour(seam->excess, full);
        draw(picture, seam->a_from, seam->a_to, colour), draw(picture, seam->b_from, seam->b_to, colour);
    }
    return picture;
}

Image4 leak_picture(const Lightmap& l, const LightmapCheck& check) {
    Image4 picture = on_receivers(l.receivers, [&](int i) {
        const glm::ivec2 t = l.receivers.texel[std::size_t(i)];
        const int mark = check.leak_marks(t.x, t.y);
        if (mark > 0) return LeakKind(mark - 1) == LeakKind::black ? magenta : red;
        return l.receivers.shift[std::size_t(i)].w != 0 ? inside : dim;
    });
    for (const Bleeding& b : check.bleeding)
        picture(b.place.texel.x, b.place.texel.y) = b.kind == BleedingKind::unwritten     ? yellow
                                                    : b.kind == BleedingKind::other_chart ? orange
                                                                                          : cyan;
    return picture;
}

}  // namespace

std::vector<DebugLayer> lightmap_pictures(const Image4& map, const Lightmap& l, const ReceiverIrradiance& truth,
                                          const LightmapCheck& check, const CheckParams& params, const DebugView& view,
                                          const RunOptions& options) {
    const Receivers& r = l.receivers;
    const SceneView scene(l.atlas, l.surfaces, view.view, view.size, options);
    std::vector<DebugLayer> layers;
    const auto add = [&](const std::string& name, const std::string& meaning, Image4 on_map) {
        const Image4 extended = extend_borders(r, on_map);
        layers.push_back({name, "lightmap", meaning, std::move(on_map)});
        layers.push_back({name + ".scene", "lightmap", meaning, scene.with(&extended)});
    };
    const std::string white = fmt::format("white: {:.4g} W/m2", 2.5 * check.median);
    add("truth", "what was traced; " + white, on_receivers(r, [&](int i) { return shown(truth.mean[std::size_t(i)], check.median); }));
    add("map", "the map that is checked; " + white, on_receivers(r, [&](int i) {
            return shown(map(r.texel[std::size_t(i)].x, r.texel[std::size_t(i)].y), check.median);
        }));
    add("error", fmt::format("blue: too dark, red: too bright, full colour: by {:.0f} %; {:.3g} standard errors taken off", 100 * picture_swing,
                             check.sigmas),
        error_picture(map, r, truth, check));
    const double full = 4 * params.seam;
    const std::string seam_meaning =
        fmt::format("edges with two places on the map: grey fits, red differs by {:.0f} % more than the truth does", 100 * full);
    layers.push_back({"seams", "lightmap", seam_meaning, seam_picture(r, check, full)});
    Image4 seams = scene.with(nullptr);
    for (auto seam = check.seams.rbegin(); seam != check.seams.rend(); ++seam)
        scene.line(seams, seam->from, seam->to, excess_colour(seam->excess, full));
    layers.push_back({"seams.scene", "lightmap", seam_meaning, std::move(seams)});
    add("leaks", "red: light where there is little, magenta: where no path found any; beside charts yellow: nothing was written, "
                 "orange: another chart lies there, cyan: another value; blue: lies inside of something",
        leak_picture(l, check));
    return layers;
}

}  // namespace plumb::probes
