// plumb experiment one-bounce: one bounce of light by path tracing against the sum over all texels of reflective shadow
// maps with a shadow ray each, as the maps grow. What is left between them is the quadrature of the map.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/frame/frame.h"
#include "gi/frame/truth.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct OneBounceOptions {
    Common common;
    SceneOptions scene;
    std::vector<int> sizes = {32, 64, 128, 256};
    int width = 96;
    int paths = 4096;
    double clear_texels = 6;
    bool shading_normals = false;
};

// Differences over some of the points, relative to the truth's mean over them.
struct Difference {
    std::size_t points = 0;
    double mean = 0;   // gather - truth
    double rms = 0;    // without the truth's own noise
    double noise = 0;  // the truth's standard error of a point
};

struct Row {
    int size = 0;
    Difference all, clear;
};

// The same scene with the normals of its triangles alone. A texel shines about its shading normal with the flux that
// it caught; a path weighs what it catches by the shading normal, and what it sends by the triangle's. With bent normals
// the two are different models, however fine the map.
Scene flat_shaded(Scene scene) {
    for (Mesh& mesh : scene.meshes)
        for (Vertex& v : mesh.vertices) v.normal = glm::vec3(0);
    for (Material& m : scene.materials) m.normal_texture = -1;
    return scene;
}

// Points whose nearest texel that lights them, of the finest maps, is farther away than `texels` of its sides: there the
// sum over the map is a quadrature of something smooth, but for edges.
std::vector<bool> clear_points(const frame::Frame& f, double texels) {
    struct Emitter {
        glm::vec3 x, n;
        float reach2;
    };
    std::vector<Emitter> emitters;
    for (const auto& maps : f.rsms)
        for (const raster::Rsm& map : maps)
            for (std::size_t i = 0; i < map.position.size(); ++i) {
                if (map.normal.texels[i].w == 0 || glm::vec3(map.flux.texels[i]) == glm::vec3(0)) continue;
                const double depth = map.view.orthographic ? 1 : map.position.texels[i].w;
                const double reach = texels * map.texel_scale * depth;
                emitters.push_back({glm::vec3(map.position.texels[i]), glm::vec3(map.normal.texels[i]),
                                    float(reach * reach)});
            }
    std::vector<bool> clear;
    for (std::size_t i = 0; i < f.gbuffer.position.size(); ++i) {
        const glm::vec3 x(f.gbuffer.position.texels[i]), n(f.gbuffer.normal.texels[i]);
        clear.push_back(f.gbuffer.normal.texels[i].w != 0 &&
                        std::none_of(emitters.begin(), emitters.end(), [&](const Emitter& e) {
                            const glm::vec3 d = e.x - x;
                            return dot3(n, d) > 0 && dot3(e.n, d) < 0 && dot3(d, d) < e.reach2;
                        }));
    }
    return clear;
}

// Over the chosen points, or all.
Difference compare(const frame::Frame& f, const reference::Estimate& truth, const std::vector<bool>* chosen) {
    Difference d;
    double total = 0, squares = 0, noise = 0;
    for (std::size_t i = 0; i < truth.mean.size(); ++i) {
        if (f.gbuffer.normal.texels[i].w == 0 || (chosen && !(*chosen)[i])) continue;
        ++d.points;
        for (int c = 0; c < 3; ++c) {
            const double t = truth.mean.texels[i][c], e = truth.error.texels[i][c];
            const double difference = f.indirect.texels[i][c] - t;
            total += t, d.mean += difference, squares += difference * difference, noise += e * e;
        }
    }
    if (!(total > 0)) throw InputError("one-bounce: no light reaches any point that is compared");
    const double n = 3.0 * double(d.points), mean = total / n;
    d.mean = d.mean / n / mean;
    d.rms = std::sqrt(std::max(squares - noise, 0.0) / n) / mean;
    d.noise = std::sqrt(noise / n) / mean;
    return d;
}

std::vector<Row> measure(const OneBounceOptions& given) {
    const RunOptions options = given.common.run_options();
    Scene scene = frame::lamps_only(load(given.scene));
    if (!given.shading_normals) scene = flat_shaded(std::move(scene));
    scene.frame_size = {given.width, std::max(1, given.width * scene.frame_size.y / scene.frame_size.x)};
    frame::Settings settings = settings_of(scene, given.scene);
    settings.method = frame::Method::rsm;
    settings.rsm.gather = rsm::Gather::all_rays;
    settings.rsm.max_rays = 0;
    settings.rsm.min_distance = 0;  // a floor of the distance takes light away next to surfaces
    settings.rsm.rays = settings.reference.rays;
    settings.reference.samples = given.paths;

    // The finest maps know best what is lit.
    auto render = [&](int size) {
        for (Light& light : scene.lights) light.rsm_size = size;
        return frame::execute(scene, settings, frame::plan(scene, settings), options);
    };
    const int coarsest = given.sizes.front(), finest = given.sizes.back();
    std::vector<frame::Frame> frames;
    for (const int size : given.sizes) frames.push_back(render(size));
    const Geometry geometry = flatten(scene);
    frame::Tracer tracer(scene, settings, geometry, nullptr);
    const reference::Estimate truth = tracer.trace("truth.indirect", frames.back().gbuffer, options).estimate;
    const std::vector<bool> clear = clear_points(frames.back(), given.clear_texels * finest / coarsest);
    if (std::find(clear.begin(), clear.end(), true) == clear.end())
        throw InputError(fmt::format("--clear {}: no point is so far from what lights it", given.clear_texels));
    std::vector<Row> rows;
    for (std::size_t i = 0; i < frames.size(); ++i)
        rows.push_back({given.sizes[i], compare(frames[i], truth, nullptr), compare(frames[i], truth, &clear)});
    return rows;
}

// The power of the map's side with which a difference falls between two rows.
double slope(const Row& from, const Row& to, double a, double b) {
    return host::log(b / a) / host::log(double(to.size) / from.size);
}

Json one_bounce_json(const std::vector<Row>& rows) {
    auto json = [](const Difference& d) {
        return Json{{"points", d.points}, {"mean", d.mean}, {"rms", d.rms}, {"truth_noise", d.noise}};
    };
    Json list = Json::array();
    for (const Row& r : rows) list.push_back({{"rsm_size", r.size}, {"all", json(r.all)}, {"clear", json(r.clear)}});
    const Row &first = rows.front(), &last = rows.back();
    return {{"rows", list},
            {"slope_clear", slope(first, last, first.clear.rms, last.clear.rms)},
            {"slope_all", slope(first, last, first.all.rms, last.all.rms)}};
}

std::string one_bounce_text(const std::vector<Row>& rows) {
    std::vector<std::vector<std::string>> cells;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Row &r = rows[i], &before = rows[i > 0 ? i - 1 : 0];
        // A difference of 0 is less than the truth's noise shows.
        auto power = [&](double a, double b) {
            return i > 0 && a > 0 && b > 0 ? fmt::format("{:+.2f}", slope(before, r, a, b)) : "";
        };
        cells.push_back({std::to_string(r.size), fmt::format("{:+.3f}", 100 * r.clear.mean),
                         fmt::format("{:.3f}", 100 * r.clear.rms), power(before.clear.rms, r.clear.rms),
                         fmt::format("{:+.3f}", 100 * r.all.mean), fmt::format("{:.3f}", 100 * r.all.rms),
                         power(before.all.rms, r.all.rms), fmt::format("{:.3f}", 100 * r.all.noise)});
    }
    std::string text = format_table({{"texels", Align::right},
                                     {"clear: mean %", Align::right},
                                     {"rms %", Align::right},
                                     {"power", Align::right},
                                     {"all: mean %", Align::right},
                                     {"rms %", Align::right},
                                     {"power", Align::right},
                                     {"truth's noise %", Align::right}},
                                    cells);
    return text + fmt::format("\n{} points, {} of them clear of what lights them; power: of the map's side, with which the "
                              "rms falls; an rms of 0 is hidden by the truth's noise\n",
                              rows.front().all.points, rows.front().clear.points);
}

int run_one_bounce(const OneBounceOptions& given) {
    const std::vector<int>& sizes = given.sizes;
    if (sizes.size() < 2 || std::adjacent_find(sizes.begin(), sizes.end(), std::greater_equal<>()) != sizes.end())
        throw InputError("--sizes: expected at least two, each larger than the one before");
    // Of one core: 25 ns a ray to a texel, 100 ns a path. The frame is as wide as high here.
    double texels = 0;
    for (const int side : sizes) texels += double(side) * side;
    const double points = double(given.width) * given.width;
    announce(fmt::format("experiment one-bounce: {:.0f} points", points), points * (2.5e-8 * texels + 1e-7 * given.paths), given.common.run_options());
    const std::vector<Row> rows = measure(given);
    std::fputs((given.common.json ? json_text(one_bounce_json(rows)) : one_bounce_text(rows)).c_str(), stdout);
    return success;
}

}  // namespace

void add_one_bounce(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<OneBounceOptions>();
    CLI::App* command = experiment.add_subcommand(
        "one-bounce", "one bounce by path tracing against rsm.all_rays, as the maps grow");
    add_scene_options(*command, given->scene);
    command->add_option("--sizes", given->sizes, "sides of the maps, texels; 32,64,128,256 otherwise")
        ->delimiter(',')
        ->check(CLI::Range(2, 4096).description(""))
        ->type_name("N,N");
    command->add_option("--width", given->width, "of the frame whose points are compared; 96 otherwise")
        ->check(CLI::Range(1, 4096).description(""))
        ->type_name("N");
    command->add_option("--paths", given->paths, "paths a point of the truth; 4096 otherwise")
        ->check(CLI::Range(16, 1 << 24).description(""))
        ->type_name("N");
    command->add_option("--clear", given->clear_texels,
                        "a point is clear if what lights it is farther than N texels of the first map; 6 otherwise")
        ->check(number_within(0, 1000))
        ->type_name("N");
    command->add_flag("--shading-normals", given->shading_normals,
                      "keep bent normals, which mean different things to maps and paths; flat otherwise");
    add_common(*command, given->common);
    command->footer(
        "Clear points see the map's texels as a quadrature: its error comes from the edges of what is lit and of what\n"
        "hides it, where N texels across cut N of them at random, so it falls as N^-1.5, and as N^-2 where there are\n"
        "none. Next to a surface that lights them the nearest texels are too coarse: a band of points as wide as a\n"
        "texel is wrong by as much as its light, and the rms over all points falls as N^-0.5 at least.");
    command->callback([given, &action] { action = [=] { return run_one_bounce(*given); }; });
}

}  // namespace plumb::cli
