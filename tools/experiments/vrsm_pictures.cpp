// The pictures of plumb experiment vrsm: irradiance on one scale, amplified differences, signed errors, enlarged
// regions.
#include <algorithm>
#include <cmath>

#include "gi/compose/compose.h"
#include "tools/experiments/vrsm.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

namespace {

using compare::Plane;

constexpr float no_surface = 0.25f;  // grey

bool on_surface(const VrsmViews& views, std::size_t i) { return views.gbuffer->normal.texels[i].w != 0; }

// Irradiance whose luminance 98 of 100 points of the truth stay below; 1 W/m2 in the dark.
double white_of(const VrsmViews& views, const Plane& truth) {
    std::vector<double> seen;
    for (std::size_t i = 0; i < truth.size(); ++i)
        if (on_surface(views, i) && std::isfinite(truth.texels[i])) seen.push_back(truth.texels[i]);
    const double white = seen.empty() ? 0 : quantile(std::move(seen), 0.98);
    return white > 0 ? white : 1;
}

Image4 shown(const Image4& irradiance, double white, const RunOptions& options) {
    Image4 display;
    compose::run(compose::TonemapParams{compose::Operator::clamp, float(1 / white)}, compose::TonemapInputs{&irradiance}, options,
                 display);
    return display;
}

// Irradiance, W/m2, as if it were grey.
Image4 grey(const Plane& plane, double factor) {
    Image4 image(plane.width, plane.height);
    for (std::size_t i = 0; i < plane.size(); ++i) image.texels[i] = glm::vec4(float(factor * plane.texels[i]));
    return image;
}

Image4 signed_picture(const VrsmViews& views, const Plane& a, const Plane& truth, double floor) {
    const Plane errors = compare::relative_errors(a, truth, floor, *views.truth_error, vrsm_judgement.sigmas);
    Image4 image(a.width, a.height, glm::vec4(no_surface));
    for (std::size_t i = 0; i < errors.size(); ++i)
        if (on_surface(views, i))
            image.texels[i] = glm::vec4(compare::signed_color(errors.texels[i], vrsm_error_swing), 1);
    return image;
}

// Sums over the rectangles from the top left corner: [height + 1][width + 1].
Plane summed(const Plane& plane) {
    Plane sums(plane.width + 1, plane.height + 1);
    for (int y = 0; y < plane.height; ++y)
        for (int x = 0; x < plane.width; ++x) {
            const double v = plane(x, y);
            sums(x + 1, y + 1) = sums(x, y + 1) + sums(x + 1, y) - sums(x, y) + (std::isfinite(v) ? v : 0);
        }
    return sums;
}

bool overlap(const glm::ivec4& a, const glm::ivec4& b) {
    return a.x < b.x + b.z && b.x < a.x + a.z && a.y < b.y + b.w && b.y < a.y + a.w;
}

// Squares of a quarter of the side where the difference sums to most, none over another.
std::vector<glm::ivec4> largest(const Plane& difference, int count) {
    const Plane sums = summed(difference);
    const int side = std::max(1, std::min(difference.width, difference.height) / 4), step = std::max(1, side / 8);
    std::vector<glm::ivec4> found;
    for (int n = 0; n < count; ++n) {
        double most = 0;
        glm::ivec4 best(0);
        for (int y = 0; y + side <= difference.height; y += step)
            for (int x = 0; x + side <= difference.width; x += step) {
                const glm::ivec4 here(x, y, side, side);
                const double sum = sums(x + side, y + side) - sums(x, y + side) - sums(x + side, y) + sums(x, y);
                if (sum > most && std::none_of(found.begin(), found.end(),
                                               [&](const glm::ivec4& other) { return overlap(here, other); }))
                    most = sum, best = here;
            }
        if (most > 0) found.push_back(best);
    }
    return found;
}

}  // namespace

VrsmPictures vrsm_pictures(const VrsmViews& views, int crops, const RunOptions& options) {
    const Plane truth = compare::luminances(*views.truth), without = compare::luminances(*views.without),
                with = compare::luminances(*views.with), best = compare::luminances(*views.best);
    VrsmPictures p;
    p.white = white_of(views, truth);
    p.truth = shown(*views.truth, p.white, options);
    p.indirect_without = shown(*views.without, p.white, options);
    p.indirect_with = shown(*views.with, p.white, options);
    p.noised = shown(*views.noised, p.white, options);
    p.without_check = shown(*views.without_check, p.white, options);
    Plane difference(truth.width, truth.height);
    double total = 0, seen = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        difference.texels[i] = std::abs(without.texels[i] - with.texels[i]);
        if (on_surface(views, i) && std::isfinite(truth.texels[i])) total += truth.texels[i], ++seen;
    }
    p.difference = shown(grey(difference, vrsm_difference_gain), p.white, options);
    const double floor = vrsm_error_floor * (seen > 0 ? total / seen : 1);
    p.error_without = signed_picture(views, without, truth, floor);
    p.error_with = signed_picture(views, with, truth, floor);
    p.error_best = signed_picture(views, best, truth, floor);
    p.crops = largest(difference, crops);
    return p;
}

}  // namespace plumb::cli
