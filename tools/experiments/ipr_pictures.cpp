#include "tools/experiments/ipr_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/host_math.h"
#include "core/ssim.h"

namespace plumb::cli {

namespace {

// As core/compare has it: of the values as they are shown.
Image<double> luminance_of(const Image4& display) {
    Image<double> plane(display.width, display.height);
    for (std::size_t i = 0; i < plane.size(); ++i) {
        const glm::vec4& v = display.texels[i];
        plane.texels[i] = 0.2126 * double(v.x) + 0.7152 * double(v.y) + 0.0722 * double(v.z);
    }
    return plane;
}

constexpr int window_radius = 5;

std::array<double, 2 * window_radius + 1> window_weights() {
    std::array<double, 2 * window_radius + 1> w{};
    double sum = 0;
    for (int k = -window_radius; k <= window_radius; ++k) sum += w[std::size_t(k + window_radius)] = host::exp(-k * k / (2 * 1.5 * 1.5));
    for (double& x : w) x /= sum;
    return w;
}

// The index of the window around (x, y), of values 0..1.
double window_index(const Image<double>& a, const Image<double>& b, int x, int y) {
    static const auto weights = window_weights();
    double p = 0, q = 0, squares = 0, product = 0;
    for (int j = -window_radius; j <= window_radius; ++j)
        for (int i = -window_radius; i <= window_radius; ++i) {
            const double w = weights[std::size_t(i + window_radius)] * weights[std::size_t(j + window_radius)], u = a(x + i, y + j), v = b(x + i, y + j);
            p += w * u, q += w * v, squares += w * (u * u + v * v), product += w * u * v;
        }
    constexpr double c1 = 1e-4, c2 = 9e-4;
    return (2 * p * q + c1) * (2 * (product - p * q) + c2) / ((p * p + q * q + c1) * (squares - p * p - q * q + c2));
}

}  // namespace

double white_of(const Image4& radiance) {
    const compare::Plane luminances = compare::luminances(radiance);
    std::vector<double> values(luminances.texels.begin(), luminances.texels.end());
    const auto at = values.begin() + std::ptrdiff_t(values.size() - 1 - values.size() / 50);
    std::nth_element(values.begin(), at, values.end());
    return std::max(*at, 1e-30);
}

Image4 displayed(const Image4& radiance, double white) {
    Image4 shown(radiance.width, radiance.height);
    for (std::size_t i = 0; i < shown.size(); ++i)
        for (int c = 0; c < 3; ++c)
            shown.texels[i][c] = float(host::pow(std::clamp(double(radiance.texels[i][c]) / white, 0.0, 1.0), 1 / 2.2));
    return shown;
}

std::optional<double> ssim_of(const Image4& a, const Image4& b) { return compare::ssim(luminance_of(a), luminance_of(b), 1, 0); }

Image4 ssim_map(const Image4& a, const Image4& b) {
    if (a.width != b.width || a.height != b.height || a.width <= 2 * window_radius || a.height <= 2 * window_radius) return {};
    const Image<double> p = luminance_of(a), q = luminance_of(b);
    Image4 map(a.width, a.height);
    for (int y = window_radius; y < map.height - window_radius; ++y)
        for (int x = window_radius; x < map.width - window_radius; ++x)
            map(x, y) = glm::vec4(glm::vec3(std::clamp(float(window_index(p, q, x, y)), 0.0f, 1.0f)), 1);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            map(x, y) = map(std::clamp(x, window_radius, map.width - 1 - window_radius), std::clamp(y, window_radius, map.height - 1 - window_radius));
    return map;
}

Image4 error_picture(const compare::Plane& own, const compare::Plane& truth, const compare::Plane& error, const Image<std::uint8_t>& compared,
                     double floor) {
    const compare::Plane relative = compare::relative_errors(own, truth, floor, error, 3);
    Image4 picture(own.width, own.height, glm::vec4(0.25f));
    for (std::size_t i = 0; i < relative.size(); ++i)
        if (compared.texels[i]) picture.texels[i] = glm::vec4(compare::signed_color(relative.texels[i], ipr_swing), 1);
    return picture;
}

void draw_balls(Image4& picture, const Image4& seen, const View& view, const std::vector<glm::dvec3>& centres, double radius_m,
                const glm::vec3& colour) {
    const glm::dmat4 to_clip = view.world_to_clip();
    const glm::dvec2 size(picture.width, picture.height);
    for (const glm::dvec3& centre : centres) {
        const glm::dvec4 clip = to_clip * glm::dvec4(centre, 1);
        const double depth = glm::dot(centre - view.eye, view.forward);
        if (!(clip.w > 0) || !(depth > 0)) continue;
        const glm::dvec2 at = (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size;
        if (!(std::fabs(at.x) < 1e6 && std::fabs(at.y) < 1e6)) continue;
        // A step across the view, of the radius, as pixels see it.
        const double pixels = std::max(radius_m * std::fabs(view.view_to_clip[1][1]) / clip.w * 0.5 * size.y, 1.0);
        for (int y = int(std::floor(at.y - pixels)); y <= int(at.y + pixels); ++y)
            for (int x = int(std::floor(at.x - pixels)); x <= int(at.x + pixels); ++x) {
                const glm::dvec2 off = glm::dvec2(x + 0.5, y + 0.5) - at;
                if (x < 0 || y < 0 || x >= picture.width || y >= picture.height || glm::dot(off, off) > pixels * pixels) continue;
                const double before = seen.empty() ? 0 : double(seen(x, y).w);
                if (before > 0 && before < depth - radius_m) continue;
                const float shade = float(1 - 0.5 * glm::dot(off, off) / (pixels * pixels));
                picture(x, y) = glm::vec4(shade * colour, 1);
            }
    }
}

Image4 smaller(const Image4& image, int side) {
    const int step = std::max(1, (std::max(image.width, image.height) + side - 1) / side);
    Image4 picked((image.width + step - 1) / step, (image.height + step - 1) / step);
    for (int y = 0; y < picked.height; ++y)
        for (int x = 0; x < picked.width; ++x) picked(x, y) = image(x * step, y * step);
    return picked;
}

}  // namespace plumb::cli
