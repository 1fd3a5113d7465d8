// plumb experiment ipr: spatial receivers (IPR 5.2.1.1, 5.2.1.2): which are computed, and how densely they stand.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/run_stages.h"
#include "gi/probes/spatial.h"
#include "tools/experiments/ipr_parts.h"
#include "tools/experiments/ipr_pictures.h"
#include "tools/experiments/ipr_truth.h"

namespace plumb::cli {

namespace {

using Clock = std::chrono::steady_clock;
double ms_since(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }
double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

struct Printed {
    const char* name;
    int places, active;
    double ms;
};
const Printed grids[] = {{"VG0", 8, 8, 4.15}, {"VG1", 180, 168, 4.19}, {"VG2", 800, 562, 4.33}, {"VG3", 1440, 871, 4.44}, {"VG4", 59976, 13396, 15.70}};
const Printed all_of_them = {"all", 14976, 14976, 14.42}, near_objects = {"active", 14976, 404, 7.8};
constexpr int quick_places = 800;  // at most

// What moves, under one bake: its light from the grid, and the picture of it.
class Volume {
  public:
    Volume(const Volume&) = delete;  // holds places of its own frame
    Volume& operator=(const Volume&) = delete;
    Volume(const IprPart& part, frame::Frame frame, const probes::Bake& bake)
        : part_(part), f_(std::move(frame)), bake_(bake), update_(update_buffers(f_.probes, f_.views[1].direct, probes::RunParams{})) {
        every_.assign(f_.probes.spatial_active.size(), 0), every_cluster_.assign(f_.probes.spatial_levels.size(), 0);
        active_ = probes::active_places(bake_.spatial.grid, probes::dynamic_boxes(part_.scene));
        if (f_.probes.volume.irradiance.empty()) throw InputError("nothing that moves is lit by spatial receivers");
    }
    int places() const { return bake_.spatial.grid.places(); }
    glm::ivec3 counts() const { return bake_.spatial.grid.count; }
    int active() const { return int(std::count(active_.begin(), active_.end(), 1)); }
    const frame::Frame& frame() const { return f_; }

    // Of the places that are active, or of all: median of an update with the lightmap's, and of the part in the air.
    struct Lit {
        double ms = 0, air_ms = 0;
        Image4 indirect, radiance;
    };
    Lit light(bool all);
    // Pixels of what moves.
    Image<std::uint8_t> moving() const {
        const Image4& light = f_.probes.volume.irradiance;
        Image<std::uint8_t> pixels(light.width, light.height);
        for (std::size_t i = 0; i < pixels.size(); ++i) pixels.texels[i] = light.texels[i].w > 0 ? 1 : 0;
        return pixels;
    }
    Image4 places_picture(const Image4& display, bool all) const;

  private:
    void update_air(bool all, Buffer<glm::vec4>& grid);

    const IprPart& part_;
    frame::Frame f_;
    const probes::Bake& bake_;
    probes::UpdateBuffers update_;
    std::vector<std::uint8_t> active_;
    std::vector<std::int32_t> every_, every_cluster_;  // levels with which all are computed
    Buffer<glm::vec4> basis_, irradiance_;
};

void Volume::update_air(bool all, Buffer<glm::vec4>& grid) {
    frame::ProbeBuffers& p = f_.probes;
    const std::vector<std::int32_t>& levels = all ? every_ : p.spatial_active;
    const std::vector<std::int32_t>& clusters = all ? every_cluster_ : p.spatial_levels;
    probes::BasisInputs basis = probes::basis_inputs(update_);
    basis.clusters = &p.spatial, basis.cluster_level = clusters.data();
    probes::run(basis, part_.options, basis_);
    probes::IrradianceInputs in;
    in.clusters = &p.spatial, in.cluster_level = clusters.data(), in.receiver_level = levels.data(), in.basis = basis_.data();
    probes::run(in, part_.options, irradiance_);
    probes::gather_grid(bake_.spatial.grid, p.spatial.receiver, irradiance_, grid);
}

Volume::Lit Volume::light(bool all) {
    Lit lit;
    std::vector<double> whole, air;
    Buffer<glm::vec4> grid;
    for (int i = 0; i <= part_.request.updates; ++i) {
        const Clock::time_point start = Clock::now();
        probes::update(update_, part_.options);
        const Clock::time_point middle = Clock::now();
        update_air(all, grid);
        if (i > 0) whole.push_back(ms_since(start)), air.push_back(ms_since(middle));  // the first one warms caches
    }
    lit.ms = median(whole), lit.air_ms = median(air);
    probes::VolumeInputs in;
    in.grid = bake_.spatial.grid, in.position = &f_.gbuffer.position, in.normal = &f_.gbuffer.normal, in.lightmap_uv = &f_.probes.uv, in.irradiance = &grid;
    probes::VolumeLight volume;
    probes::run(in, part_.options, volume);
    lit.indirect = f_.indirect, lit.radiance = f_.radiance;
    for (std::size_t i = 0; i < lit.indirect.size(); ++i) {
        if (!(volume.irradiance.texels[i].w > 0)) continue;
        for (int c = 0; c < 3; ++c) {
            const double more = double(volume.irradiance.texels[i][c]) - double(f_.indirect.texels[i][c]);
            lit.indirect.texels[i][c] = volume.irradiance.texels[i][c];
            lit.radiance.texels[i][c] += float(double(f_.gbuffer.albedo.texels[i][c]) / host::pi * more);
        }
    }
    return lit;
}

Image4 Volume::places_picture(const Image4& display, bool all) const {
    const probes::SpatialGrid& grid = bake_.spatial.grid;
    const glm::ivec2 size(display.width, display.height);
    const View view = make_view(part_.scene.camera, double(size.x) / size.y, part_.scene.convention, size);
    std::vector<glm::dvec3> centres;
    for (int i = 0; i < grid.places(); ++i)
        if (all || active_[std::size_t(i)]) {
            const glm::ivec3 at(i % grid.count.x, i / grid.count.x % grid.count.y, i / grid.count.x / grid.count.y);
            centres.emplace_back(grid.origin + glm::vec3(at) * grid.spacing);
        }
    Image4 picture = display;
    const double radius = 0.06 * double(std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z}));
    draw_balls(picture, f_.gbuffer.position, view, centres, radius, {0.2f, 1, 0.3f});
    return picture;
}

class Spatial {
  public:
    explicit Spatial(const IprPart& part) : part_(part) {
        base_ = as_published(part);
        base_.placement.count = 11;
        base_.lightmap_size = part.size_for(base_, part.request.quick ? 700 : 15608, 256);
    }

    // Figures 5.16, 5.17: all places, and those near what moves.
    void measure_active() {
        const std::unique_ptr<Volume> made = volume_of(part_.request.quick ? 200 : all_of_them.places);
        Volume& volume = *made;
        IprSheet sheet = begin("figures 5.16, 5.17", "all spatial receivers, and those near what moves");
        const Volume::Lit all = volume.light(true), near = volume.light(false);
        const Image4 reference = displayed(all.radiance, white_);
        for (const bool every : {true, false}) {
            const Volume::Lit& lit = every ? all : near;
            IprSheetRow row = row_of(volume, lit, every, every ? all_of_them : near_objects, reference);
            row.values.push_back(all.ms / lit.ms), row.values.push_back(all_of_them.ms / (every ? all_of_them : near_objects).ms);
            sheet.rows.push_back(std::move(row));
        }
        sheet.heads.push_back({"speed-up", 2}), sheet.heads.push_back({"thesis: speed-up", 2});
        const bool same = all.indirect.texels == near.indirect.texels;
        sheet.lines.push_back(same ? "both pictures have the same bits: what is left out is not read" : "the pictures differ: what is left out is read somewhere");
        part_.result.sheets.push_back(std::move(sheet));
    }

    // Table 5.3, figures 5.18, 5.19.
    void measure_density() {
        IprSheet sheet = begin("table 5.3, figures 5.18, 5.19", "density of spatial receivers");
        std::vector<Image4> displays;
        for (const Printed& g : grids) {
            if (part_.request.quick && g.places > quick_places) continue;
            const std::unique_ptr<Volume> volume = volume_of(g.places);
            const Volume::Lit lit = volume->light(false);
            displays.push_back(displayed(lit.radiance, white_));
            sheet.rows.push_back(row_of(*volume, lit, false, g, displays.back()));
        }
        for (std::size_t i = 0; i < sheet.rows.size(); ++i) {
            sheet.rows[i].values[ssim_column] = ssim_of(displays[i], displays.back());
            sheet.rows[i].pictures.push_back({"SSIM beside the densest", ssim_map(displays[i], displays.back())});
        }
        part_.result.sheets.push_back(std::move(sheet));
    }

  private:
    static constexpr std::size_t ssim_column = 5;

    IprSheet begin(const std::string& id, const std::string& title) const {
        IprSheet sheet{id, title, "", {{"places"}, {"computed"}, {"clusters"}, {"ms", 3}, {"in the air: ms", 3}, {"SSIM", 4}}, {}, {}, {}};
        add_error_heads(sheet.heads, "what moves");
        sheet.heads.insert(sheet.heads.end(), {{"thesis: places"}, {"thesis: computed"}, {"thesis: ms", 2}});
        sheet.notes = "six receivers a place; ms: an update of lightmap and places; errors: of the indirect irradiance of pixels of what moves";
        return sheet;
    }

    std::unique_ptr<Volume> volume_of(int places) {
        IprVariant v;
        v.bake = base_, v.bake.spatial_receivers = places;
        v.run.relief = probes::ReliefOf::off, v.run.indirect_shadow = probes::IndirectShadow::off;  // places alone
        part_.tell(fmt::format("spatial receivers: {} places", places));
        const probes::Bake& bake = part_.bench.bake(v.bake);
        Scene scene = part_.scene;
        scene.frame_size = part_.request.size;
        auto volume = std::make_unique<Volume>(part_, part_.bench.frame_of(scene, v), bake);
        if (truth_.empty()) trace(*volume);
        return volume;
    }

    // Of the pixels of what moves alone.
    void trace(const Volume& volume) {
        moving_ = volume.moving();
        if (std::count(moving_.texels.begin(), moving_.texels.end(), 1) == 0) throw InputError("nothing that moves is in view");
        Image4 normal = volume.frame().gbuffer.normal, mean, error;
        for (std::size_t i = 0; i < normal.size(); ++i)
            if (!moving_.texels[i]) normal.texels[i] = glm::vec4(0);
        trace_points(part_.scene, {&volume.frame().gbuffer.position, &normal}, std::max(part_.request.samples / 4, 32), base_.rays, part_.options, mean, error);
        truth_ = compare::luminances(mean), error_ = compare::luminance_errors(error);
        white_ = white_of(volume.frame().radiance);
    }

    IprSheetRow row_of(const Volume& volume, const Volume::Lit& lit, bool all, const Printed& thesis, const Image4& reference) const {
        const Image4 display = displayed(lit.radiance, white_);
        const compare::Plane own = compare::luminances(lit.indirect);
        const IprErrors errors = ipr_errors(own, truth_, error_, moving_);
        IprSheetRow row;
        row.name = thesis.name, row.settings = fmt::format("{} x {} x {}", volume.counts().x, volume.counts().y, volume.counts().z);
        row.values = {volume.places(), all ? volume.places() : volume.active(), double(volume.frame().probes.spatial.clusters.size()), lit.ms, lit.air_ms,
                      ssim_of(display, reference)};
        add_error_values(row.values, errors);
        row.values.insert(row.values.end(), {thesis.places, thesis.active, thesis.ms});
        row.pictures = {{"", display},
                        {"places that are computed", volume.places_picture(display, all)},
                        {"error of the indirect light", error_picture(own, truth_, error_, moving_, 0.1 * errors.truth)}};
        return row;
    }

    const IprPart& part_;
    probes::BakeParams base_;
    Image<std::uint8_t> moving_;
    compare::Plane truth_, error_;
    double white_ = 1;
};

}  // namespace

void measure_spatial(const IprPart& part) {
    const auto moves = [](const Mesh& m) { return m.dynamic && !m.triangles.empty(); };
    if (std::none_of(part.scene.meshes.begin(), part.scene.meshes.end(), moves)) {
        part.result.left_out.push_back("table 5.3, figures 5.16 to 5.19: nothing moves in this scene");
        return;
    }
    try {
        Spatial spatial(part);
        spatial.measure_active();
        spatial.measure_density();
    } catch (const InputError& e) {
        part.result.left_out.push_back(std::string("table 5.3, figures 5.16 to 5.19: ") + e.what());
    }
}

}  // namespace plumb::cli
