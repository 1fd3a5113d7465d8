// plumb experiment hemicube: plates C.1 to C.10 of HEM again.
#include <fmt/format.h>

#include <algorithm>

#include "gi/frame/frame.h"
#include "io/scenes/generate.h"
#include "tools/experiments/hemicube_world.h"
#include "tools/experiments/ipr_pictures.h"
#include "tools/experiments/ipr_truth.h"

namespace plumb::cli {

namespace {

constexpr const char* place = "experiment hemicube";

void set(Scene& scene, const char* table, const char* key, const FieldValue& value) { scene.settings.push_back({table, key, value, place}); }

frame::Frame frame_of(const Scene& scene, const RunOptions& options) {
    const frame::Settings settings = frame::settings_of(scene);
    return frame::execute(scene, settings, frame::plan(scene, settings), options);
}
double milliseconds(const frame::Frame& frame) {
    double ms = 0;
    for (const frame::StageRun& s : frame.stages) ms += s.ms;
    return ms;
}
double milliseconds(const frame::Frame& frame, const std::string& stage) {
    double ms = 0;
    for (const frame::StageRun& s : frame.stages)
        if (s.label == stage) ms += s.ms;
    return ms;
}

// ---- C.1 to C.8: local illumination -------------------------------------------------------------------------------------

// The models that appendix B loads (box, sphere, torus), lit by one directional lamp, without anything that emits.
Scene local_scene(const HemicubeRequest& request) {
    Scene scene = io::generate_scene("hemicube_shapes", {4980, 1}, place);
    for (Material& m : scene.materials) {
        m.emission = glm::vec3(0);
        m.specular = glm::vec3(0.25f), m.exponent = m.name == "white" ? 60.f : 15.f;
        m.reflectance = glm::min(m.reflectance, glm::vec3(0.75f));
    }
    Light sun;
    sun.name = "sun", sun.type = LightType::directional;
    sun.direction = {0.1f, -0.55f, 0.9f}, sun.intensity = glm::vec3(3.1f);
    scene.lights = {sun};
    scene.frame_size = request.size;
    scene.method = "zbuffer";
    set(scene, "zbuffer", "ambient", glm::vec3(0.25f));
    set(scene, "tonemap", "operator", std::string("clamp"));
    return scene;
}

IprSheet measure_local(const HemicubeRequest& request, const RunOptions& options) {
    IprSheet sheet{"plates C.1 to C.8", "local illumination (HEM 5.3, 5.4)", "a frame, all of its stages; the thesis' run in real time at more than 30 frames a second", {}, {}, {}, {}};
    sheet.heads = {{"ms", 2}, {"thesis: ms, less than", 1}};
    const Scene scene = local_scene(request);
    const auto add = [&](const std::string& plate, const std::string& what, const Scene& s) {
        std::vector<double> ms;
        frame::Frame f;
        for (int k = 0; k < request.repeats; ++k) f = frame_of(s, options), ms.push_back(milliseconds(f));
        std::sort(ms.begin(), ms.end());
        const bool lines = !f.zbuffer.vertex_normals.empty();
        sheet.rows.push_back({plate, what, {ms[ms.size() / 2], 1000.0 / 30}, {{"", lines ? f.zbuffer.vertex_normals : f.display}}});
    };
    const char* techniques[] = {"C", "CA", "CAD", "CAS", "CADS", "CAS(P)", "CADS(P)"};
    for (int k = 0; k < 7; ++k) {
        Scene s = scene;
        set(s, "zbuffer", "technique", std::string(techniques[k]));
        add(fmt::format("C.{}", k + 1), techniques[k], s);
    }
    Scene normals = scene;
    std::erase_if(normals.meshes, [](const Mesh& m) { return m.name == "sphere" || m.name == "torus"; });
    normals.camera.position = {-0.2, 0.55, 0.1}, normals.camera.look_at = {-1, 0.25, -0.9}, normals.camera.fov_y_deg = 60;
    set(normals, "zbuffer", "technique", std::string("CAD"));
    set(normals, "zbuffer", "normals", true);
    add("C.8", "CAD, normals of the box", normals);
    return sheet;
}

// ---- C.9 and C.10: radiosity --------------------------------------------------------------------------------------------

struct PixelTruth {
    Image4 irradiance;
    compare::Plane mean, error;
    Image<std::uint8_t> compared;
};

PixelTruth trace_pixels(const Scene& scene, const raster::GBuffer& g, const HemicubeRequest& request, const RunOptions& options) {
    PixelTruth t;
    Image4 error;
    trace_points(scene, {&g.position, &g.normal}, request.pixel_samples, Rays::exact, options, t.irradiance, error);
    t.mean = compare::luminances(t.irradiance), t.error = compare::luminance_errors(error);
    t.compared = Image<std::uint8_t>(g.id.width, g.id.height);
    for (std::size_t i = 0; i < g.id.size(); ++i) t.compared.texels[i] = g.id.texels[i].x >= 0;
    return t;
}

struct Plate {
    const char *id, *title, *scene;
    double triangles_of_one;   // with n x n quads a wall: that times n^2
    double thesis_seconds, goal_same, goal_fine;
    bool curved;               // its surface differs with the mesh, and so does the truth
};
struct Setting {
    int n, size;           // quads along a wall; hemicube
    bool outlined = true;  // the lamp's light by its outline and rays (emitters.h), in place of texels that see it
};

class PlateMaker {
  public:
    PlateMaker(const Plate& plate, const HemicubeRequest& request, const RunOptions& options, const Tell& tell)
        : plate_(plate), request_(request), options_(options), tell_(tell) {}

    IprSheet run(const std::vector<Setting>& settings) {
        IprSheet sheet{plate_.id, plate_.title, "elements split at creases, linear between them, solved to 1e-4; s: elements, visibility, light and solution", {}, {}, {}, {}};
        sheet.heads = {{"elements"}, {"triangles"}, {"s", 3}, {"visibility s", 3}, {"solution s", 4}, {"goal s", 2}, {"thesis: s", 0}};
        add_error_heads(sheet.heads, "pixels");
        for (const Setting& s : settings) sheet.rows.push_back(row_of(s, sheet.rows.empty()));
        add_lines(sheet);
        return sheet;
    }

  private:
    Scene scene_of(const Setting& s) const {
        Scene scene = io::generate_scene(plate_.scene, {std::int64_t(plate_.triangles_of_one * s.n * s.n), 1}, place);
        scene.frame_size = request_.size, scene.method = "radiosity";
        // No mesh but the scene's own.
        set(scene, "radiosity", "edge", 1e6), set(scene, "radiosity", "refine", 0.0), set(scene, "radiosity", "cut", false);
        if (!s.outlined) set(scene, "radiosity", "small_emitters", 0.0);
        set(scene, "radiosity", "size", double(s.size));
        return scene;
    }
    IprSheetRow row_of(const Setting& s, bool first) {
        tell_(fmt::format("{}: {} quads a wall, hemicubes of {}", plate_.id, s.n * s.n, s.size));
        const Scene scene = scene_of(s);
        frame::Frame f;
        std::vector<double> seconds;
        do {
            f = frame_of(scene, options_);
            seconds.push_back(seconds_of(f));
        } while (int(seconds.size()) < request_.repeats && seconds.front() < 2);
        std::sort(seconds.begin(), seconds.end());
        if (truth_.irradiance.empty() || (plate_.curved && s.n != truth_n_)) truth_ = trace_pixels(scene, f.gbuffer, request_, options_), truth_n_ = s.n;
        const compare::Plane own = compare::luminances(f.indirect);
        const IprErrors errors = ipr_errors(own, truth_.mean, truth_.error, truth_.compared);
        IprSheetRow row{fmt::format("{} x {} quads a wall, hemicube {}{}", s.n, s.n, s.size, s.outlined ? ", lamp by its outline" : ""), first ? "the plate's mesh, a guess" : "", {}, {}};
        row.values = {double(f.radiosity.elements.count()), double(f.radiosity.triangles.of.size()), seconds[seconds.size() / 2],
                      1e-3 * milliseconds(f, "radiosity.rows"), 1e-3 * milliseconds(f, "radiosity.solve"), first ? plate_.goal_same : plate_.goal_fine};
        row.values.push_back(first ? std::optional(plate_.thesis_seconds) : std::nullopt);
        add_error_values(row.values, errors);
        reached_.push_back({seconds[seconds.size() / 2], errors});
        const double white = white_of(truth_.irradiance);
        row.pictures = {{"", f.display}, {"irradiance", displayed(f.indirect, white)}};
        if (first) row.pictures.push_back({"irradiance by path tracing", displayed(truth_.irradiance, white)});
        row.pictures.push_back({fmt::format("error of irradiance: blue too dark, red too bright, full at {:g} %, three standard errors of the truth taken off", 100 * ipr_swing),
                                error_picture(own, truth_.mean, truth_.error, truth_.compared, 0.05 * errors.truth)});
        return row;
    }
    static double seconds_of(const frame::Frame& f) {
        double ms = 0;
        for (const char* stage : {"radiosity.elements", "radiosity.rows", "radiosity.light", "radiosity.solve", "radiosity.gather"}) ms += milliseconds(f, stage);
        return 1e-3 * ms;
    }
    void add_lines(IprSheet& sheet) const {
        sheet.lines.push_back(fmt::format("The plate's mesh: {:.3g} s, thesis {:g} s, goal {:g} s: {}.", reached_[0].first, plate_.thesis_seconds, plate_.goal_same,
                                          reached_[0].first <= plate_.goal_same ? "reached" : "missed"));
        std::string fine = "none of these has an error of 1 % or less";
        double best = 1e300;
        for (std::size_t i = 0; i < reached_.size(); ++i)
            if (reached_[i].second.rms <= 0.01 && reached_[i].first < best)
                best = reached_[i].first, fine = fmt::format("{}: {:.3g} s, goal {:g} s: {}", sheet.rows[i].name, best, plate_.goal_fine, best <= plate_.goal_fine ? "reached" : "missed");
        sheet.lines.push_back("Fine enough for an rms error of 1 % of the mean irradiance: " + fine + ".");
    }

    const Plate& plate_;
    const HemicubeRequest& request_;
    const RunOptions& options_;
    const Tell& tell_;
    PixelTruth truth_;
    int truth_n_ = 0;
    std::vector<std::pair<double, IprErrors>> reached_;  // s
};

}  // namespace

std::vector<IprSheet> measure_plates(const HemicubeRequest& request, const RunOptions& options, const Tell& tell) {
    tell("plates C.1 to C.8");
    std::vector<IprSheet> sheets = {measure_local(request, options)};
    const Plate empty{"plate C.9", "an empty box", "hemicube_box", 12, thesis_c9_seconds, 0.15, 1, false};
    const Plate shapes{"plate C.10", "a box with a sphere and a torus, its lamp (100.4, 96.8, 90.0)", "hemicube_shapes", 49.8, thesis_c10_seconds, 0.6, 4, true};
    std::vector<Setting> of_empty = {{10, 64, false}, {10, 64}, {20, 64}, {30, 64}, {40, 64}, {10, 256, false}}, of_shapes = {{10, 64, false}, {10, 64}, {20, 64}, {30, 64}, {10, 256, false}};
    if (request.quick) of_empty = {{5, 16, false}, {10, 16}}, of_shapes = {{5, 16, false}};
    sheets.push_back(PlateMaker(empty, request, options, tell).run(of_empty));
    sheets.push_back(PlateMaker(shapes, request, options, tell).run(of_shapes));
    return sheets;
}

}  // namespace plumb::cli
