// plumb experiment ipr: level of detail of one scene (IPR 5.2.2): which setups, lights and cameras make which of the thesis' tables.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "tools/experiments/bake_sizes.h"
#include "tools/experiments/ipr_parts.h"
#include "tools/experiments/ipr_truth.h"

namespace plumb::cli {

namespace {

// The thesis' bakes, by how a scene's name begins; the last is for all others.
struct Size {
    const char* scene;
    int receivers, probes;
    bool cameras;                  // tables 5.5 to 5.7, of one camera each
    const char *levels, *degrees;  // its tables of one level, and of one degree, for all
};
const Size sizes[] = {{"hall", 512026, 44, true, "", ""}, {"cornell_large", 342009, 13, false, "", "5.9"}, {"", 67682, 7, false, "5.8", ""}};

const Size& size_of(const std::string& scene) {
    return *std::find_if(std::begin(sizes), std::end(sizes), [&](const Size& s) { return scene.rfind(s.scene, 0) == 0; });
}

// The light of a table's rows: all, what lamps and sky send, or what static surfaces emit.
struct Lighting {
    std::string name;
    Scene scene;
};
std::vector<Lighting> lightings(const Scene& scene) {
    const bool emits = std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.emission != glm::vec3(0); });
    const bool lamps = std::any_of(scene.lights.begin(), scene.lights.end(), [](const Light& l) { return l.on; });
    if (!emits || !lamps) return {{lamps ? "dynamic light" : "static light", scene}};
    Lighting dynamic{"dynamic light", scene}, fixed{"static area light", scene};
    for (Material& m : dynamic.scene.materials) m.emission = glm::vec3(0);
    fixed.scene.lights.clear(), fixed.scene.environment = {};
    return {dynamic, fixed};
}

// The thesis' distances are of a hall; of a smaller scene they count by its size.
constexpr double thesis_diagonal = 66;  // m, of data/scenes/hall
double scale_of(const probes::Bake& bake) {
    glm::vec3 low(0), high(0);
    bounds(bake.atlas.geometry, low, high);
    return std::min(1.0, double(glm::length(high - low)) / thesis_diagonal);
}

class Lod {
  public:
    Lod(const IprPart& part, const probes::Bake& bake)
        : part_(part), bake_(bake), size_(size_of(part.result.scene)), scale_(scale_of(bake)), bench_(part.scene, bake, part.options) {
        truth_ = trace_receivers(still_scene(part.scene), bake.receivers, part.request, bake.params.rays, part.options);
    }
    void run();

  private:
    LodView view_of(const std::string& name, const Camera& camera, bool levels = false) const {
        LodView view{name, camera, part_.request.size};
        view.samples = ipr_pixel_samples(part_.request), view.receivers = &truth_, view.levels = levels;
        return view;
    }
    void add(const LodBench& bench, const LodView& view, const std::string& title, const std::string& number, const std::vector<std::string>& setups,
             const std::string& reference = "NO LOD") {
        part_.tell(title);
        std::string scaled = fmt::format("lightmap of {} texels a side, {} clusters", bake_.atlas.size.x, bake_.flat.count());
        if (scale_ < 1) scaled += fmt::format(", the thesis' distances times {:.3g}", scale_);
        try {
            part_.result.lod.push_back({title, number, scaled, bench.measure(view, lod_setups(setups, scale_), part_.request.updates, reference)});
        } catch (const InputError& e) {
            part_.result.left_out.push_back(title + ": " + e.what());
        }
    }
    void open_hall();

    const IprPart& part_;
    const probes::Bake& bake_;
    const Size& size_;
    double scale_;
    LodBench bench_;
    IprTruth truth_;
};

// Tables 5.5 to 5.7: cameras of one scene under two lights, setups of table 5.4.
void Lod::open_hall() {
    std::vector<LodView> cameras = part_.request.cameras;
    if (cameras.empty()) cameras = {{"camera", part_.scene.camera, {}}};
    for (const Lighting& light : lightings(part_.scene)) {
        const LodBench bench(light.scene, bake_, part_.options);
        const IprTruth truth = trace_receivers(still_scene(light.scene), bake_.receivers, part_.request, bake_.params.rays, part_.options);
        for (std::size_t i = 0; i < cameras.size(); ++i) {
            LodView view = view_of(cameras[i].name, cameras[i].camera);
            view.receivers = &truth;
            const std::string number = size_.cameras && i < 3 ? fmt::format("5.{}", 5 + i) : "";
            add(bench, view, fmt::format("{}: {}, {}", number.empty() ? "setups of table 5.4" : "table " + number, cameras[i].name, light.name), number,
                {"S0", "S1", "S2"});
        }
    }
}

void Lod::run() {
    const LodView view = view_of("camera", part_.scene.camera), levels = view_of("camera", part_.scene.camera, true);
    open_hall();
    add(bench_, view, "table 5.8: one level for all", size_.levels, {"LOD 0", "LOD 1", "LOD 2", "LOD 3"});
    if (!part_.request.quick)
        add(bench_, view, "table 5.9: one degree for all", size_.degrees, {"SH 0", "SH 1", "SH 2", "SH 3", "SH 4", "SH 5", "SH 6", "SH 7"}, "SH 7");
    add(bench_, levels, "table 5.10, figure 5.29: distances", "", {"D0", "D1", "D2"});
    add(bench_, view, "table 5.11, figure 5.30: degrees", "", {"SD0", "SD1", "SD2"});
    add(bench_, view, "figure 5.31: relight rays", "", {"R 512", "R 256", "R 128", "R 64", "R adaptive"}, "R adaptive");
    add(bench_, levels, "figure 5.32: view zones", "figure 5.32", {"no zones", "zones"}, "no zones");
    add(bench_, view, "figure 5.33: light beyond borders", "", {"borders: all", "borders: level 0", "borders: none"}, "borders: all");
    part_.tell("seams between degrees");
    part_.result.seams = bench_.seams();
}

}  // namespace

void measure_lod(const IprPart& part) {
    const Size& size = size_of(part.result.scene);
    probes::BakeParams params = as_published(part);
    params.gap = 24;  // texels: four levels between charts
    const bool moves = std::any_of(part.scene.meshes.begin(), part.scene.meshes.end(), [](const Mesh& m) { return m.dynamic && !m.triangles.empty(); });
    if (moves && params.spatial_receivers == 0) params.spatial_receivers = part.request.quick ? 200 : 1440;  // VG3 of table 5.3
    params.placement.count = part.request.quick ? (size.probes + 1) / 2 : size.probes;
    const int wanted = part.request.quick ? 700 : size.receivers;
    // Not by size_for(): gaps of its own.
    params.lightmap_size = lightmap_for(part.scene, params, wanted, part.request.quick ? 128 : 1024, part.options);
    part.tell(fmt::format("level of detail: {} receivers, {} probes", wanted, params.placement.count));
    try {
        Lod(part, part.bench.bake(params)).run();
    } catch (const InputError& e) {
        part.result.left_out.push_back(std::string("level of detail: ") + e.what());
    }
}

}  // namespace plumb::cli
