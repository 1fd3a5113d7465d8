// plumb experiment isr: what points of the world receive as the camera turns away from them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/compare_pictures.h"
#include "core/content_hasher.h"
#include "core/error.h"
#include "core/host_math.h"
#include "core/signed_error.h"
#include "tools/experiments/isr.h"
#include "tools/shared/sweep_subject.h"

namespace plumb::cli {

namespace {

constexpr int steps = 12;               // on each side of the middle
constexpr glm::ivec2 point_grid{4, 3};  // of points, over the middle half of the frame
constexpr double same_depth = 0.02;     // of the point's depth: what is seen there is the point

struct Point {
    glm::dvec3 position{0};
    double truth = 0, error = 0;  // luminance of the irradiance of ISR's own transport, W/m2
};

const std::vector<std::pair<const char*, std::vector<std::string>>>& turned_settings() {
    static const std::vector<std::pair<const char*, std::vector<std::string>>> all = {
        {"ISR", {}},
        {"guard band of 64", {"isr.guard=64"}},
        {"2 layers", {"isr.layers=2"}},
        {"guard band of 64, 2 layers", {"isr.guard=64", "isr.layers=2"}}};
    return all;
}

// The camera, turned about its own up axis.
Camera turned(const Camera& camera, double degrees) {
    const CameraAxes a = axes(camera);
    const double s = host::sin(degrees * host::pi / 180), c = host::cos(degrees * host::pi / 180);
    Camera out = camera;
    out.look_at = camera.position + c * a.forward + s * a.right;
    out.up = a.up;
    return out;
}

// The pixel that shows the point; none where it lies outside the frame.
std::optional<glm::ivec2> pixel_of(const Camera& camera, glm::ivec2 size, const glm::dvec3& position) {
    const CameraAxes a = axes(camera);
    const glm::dvec3 d = position - camera.position;
    const double depth = glm::dot(d, a.forward), half = host::tan(camera.fov_y_deg * host::pi / 360);
    if (!(depth > camera.near)) return std::nullopt;
    const double y = glm::dot(d, a.up) / (depth * half);
    const double x = glm::dot(d, a.right) / (depth * half) * size.y / size.x;
    if (std::fabs(x) >= 1 || std::fabs(y) >= 1) return std::nullopt;
    return glm::ivec2(int((x + 1) / 2 * size.x), int((1 - y) / 2 * size.y));
}

// Points of the middle of the frame with a surface, and what one bounce of lamps and what emits sends to each, traced.
std::vector<Point> points_of(const Scene& scene, const frame::Frame& f, const RunOptions& options) {
    const glm::ivec2 size = scene.frame_size;
    Image4 position(point_grid.x, point_grid.y), normal(point_grid.x, point_grid.y);
    for (int y = 0; y < point_grid.y; ++y)
        for (int x = 0; x < point_grid.x; ++x) {
            const int px = size.x / 4 + (2 * x + 1) * size.x / (4 * point_grid.x),
                      py = size.y / 4 + (2 * y + 1) * size.y / (4 * point_grid.y);
            position(x, y) = f.gbuffer.position(px, py), normal(x, y) = f.gbuffer.normal(px, py);
        }
    const reference::Estimate truth = isr_own_irradiance(scene, {&position, &normal}, 1, false, 16384, options);
    const compare::Plane mean = compare::luminances(truth.mean), error = compare::luminance_errors(truth.error);
    std::vector<Point> points;
    for (std::size_t i = 0; i < position.size(); ++i)
        if (normal.texels[i].w != 0 && mean.texels[i] > 0)
            points.push_back({glm::dvec3(glm::vec3(position.texels[i])), mean.texels[i], error.texels[i]});
    return points;
}

double luminance_at(const frame::Frame& f, const Camera& camera, glm::ivec2 size, const Point& point) {
    constexpr double unseen = std::numeric_limits<double>::quiet_NaN();
    const std::optional<glm::ivec2> p = pixel_of(camera, size, point.position);
    if (!p || f.gbuffer.normal(p->x, p->y).w == 0) return unseen;
    const double depth = linear_depth(camera, point.position), seen = f.gbuffer.position(p->x, p->y).w;
    if (!(std::fabs(depth - seen) <= same_depth * depth)) return unseen;
    const glm::vec4 e = f.indirect(p->x, p->y);
    return compare::luminance(glm::dvec3(e.x, e.y, e.z));
}

IsrTurningView turn(const IsrCommon& common, const BatchView& view) {
    const RunOptions& options = common.options;
    Scene scene = common.scenes.scene(view, common.request.size);
    const Camera middle = scene.camera;
    IsrTurningView result;
    result.name = view.name;
    const frame::Frame first = isr_frame(scene, isr_settings(scene, "isr", {}), options);
    const std::vector<Point> points = points_of(scene, first, options);
    for (const Point& p : points)
        result.truth.push_back(p.truth), result.truth_error += p.error / double(points.size());
    // So far that a point of the middle leaves the frame.
    const double half_width =
        host::atan(host::tan(middle.fov_y_deg * host::pi / 360) * scene.frame_size.x / scene.frame_size.y) * 180 /
        host::pi;
    for (const auto& [name, sets] : turned_settings()) {
        IsrTurning t{name, sets, "", {}, std::vector<std::vector<double>>(points.size())};
        try {
            frame::KeptStages kept;
            for (int s = -steps; s <= steps; ++s) {
                const double yaw = half_width * s / steps;
                scene.camera = turned(middle, yaw);
                const frame::Settings settings = isr_settings(scene, "isr", sets);
                const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), options, kept);
                t.yaw_deg.push_back(yaw);
                for (std::size_t i = 0; i < points.size(); ++i)
                    t.irradiance[i].push_back(luminance_at(f, scene.camera, scene.frame_size, points[i]));
            }
        } catch (const InputError& e) {
            t.refused = e.what(), t.irradiance.clear(), t.yaw_deg.clear();
        }
        result.settings.push_back(std::move(t));
    }
    return result;
}

Json turning_json(const IsrTurningView& v) {
    Json settings = Json::array();
    for (const IsrTurning& t : v.settings) {
        Json rows = Json::array();
        for (const std::vector<double>& r : t.irradiance) {
            Json row = Json::array();
            for (const double x : r) row.push_back(std::isfinite(x) ? Json(x) : Json(nullptr));
            rows.push_back(row);
        }
        settings.push_back({t.setting, t.sets, t.refused, t.yaw_deg, rows});
    }
    return {v.name, v.truth, v.truth_error, settings};
}
IsrTurningView turning_of(const Json& j) {
    IsrTurningView v{j.at(0), j.at(1), j.at(2), {}};
    for (const Json& t : j.at(3)) {
        IsrTurning s{t.at(0), t.at(1), t.at(2), t.at(3), {}};
        for (const Json& row : t.at(4)) {
            s.irradiance.emplace_back();
            for (const Json& x : row)
                s.irradiance.back().push_back(x.is_null() ? std::numeric_limits<double>::quiet_NaN() : x.get<double>());
        }
        v.settings.push_back(std::move(s));
    }
    return v;
}

}  // namespace

std::vector<IsrYaw> isr_turning_curve(const IsrTurning& turning, const std::vector<double>& truth) {
    std::vector<IsrYaw> curve;
    for (std::size_t y = 0; y < turning.yaw_deg.size(); ++y) {
        double sum = 0, truths = 0;
        int n = 0;
        for (std::size_t p = 0; p < turning.irradiance.size(); ++p)
            if (const double e = turning.irradiance[p].at(y); std::isfinite(e)) sum += e, truths += truth.at(p), ++n;
        if (n > 0) curve.push_back({turning.yaw_deg[y], sum / truths, n});
    }
    return curve;
}

IsrSpread isr_spread(const IsrTurning& turning, const std::vector<double>& truth) {
    IsrSpread s;
    double all = 0, all_truths = 0, truths = 0;
    for (std::size_t p = 0; p < turning.irradiance.size(); ++p) {
        double sum = 0, squares = 0, low = 1e300, high = -1e300;
        int n = 0;
        for (const double e : turning.irradiance[p])
            if (std::isfinite(e)) sum += e, low = std::min(low, e), high = std::max(high, e), ++n;
        all += sum, all_truths += n * truth.at(p);
        // A point that is seen from two yaws at least.
        if (n < 2) continue;
        const double mean = sum / n;
        for (const double e : turning.irradiance[p])
            if (std::isfinite(e)) squares += (e - mean) * (e - mean);
        const double deviation = std::sqrt(squares / n);
        s.deviation += deviation, s.range += high - low;
        // A point that receives nothing from any yaw does not vary.
        if (mean > 0) s.relative += truth[p] * deviation / mean;
        truths += truth[p], s.seen += n, ++s.points;
    }
    if (all_truths > 0) s.mean = all / all_truths;
    if (truths > 0) s.deviation /= truths, s.range /= truths, s.relative /= truths;
    return s;
}

std::vector<IsrTurningView> isr_turning(const IsrCommon& common, const std::vector<BatchView>& views) {
    std::vector<IsrTurningView> all;
    const std::size_t n = std::min(views.size(), std::size_t(common.request.turning_views));
    for (std::size_t i = 0; i < n; ++i) {
        const BatchView& view = views[(2 * i + 1) * views.size() / (2 * n)];
        show_progress(fmt::format("view dependency: {} of {}", i + 1, n));
        ContentHasher key;
        key.add(program_hash(), common.scenes.content(view, common.request.size));
        const std::string name = "turning_" + view.name;
        if (const std::optional<Json> found = common.results.find(name, key.hash)) {
            all.push_back(turning_of(*found));
            continue;
        }
        all.push_back(turn(common, view));
        common.results.keep(name, key.hash, turning_json(all.back()));
    }
    return all;
}

}  // namespace plumb::cli
