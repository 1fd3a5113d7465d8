#include "gi/rsm/gather.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/tile.h"
#include "gi/rsm/all_rays.h"

namespace plumb::rsm {

std::vector<Field> fields(GatherParams& p) {
    // `plumb sweep` draws a curve for each gather, and further ones of the disc for what changes its bias.
    using enum SweepRange::Role;
    auto disc = [](SweepRange::Role role, std::vector<double> values) {
        return SweepRange{role, std::move(values), "gather", "disc"};
    };
    auto all_rays = [](std::vector<double> values) {
        return SweepRange{along, std::move(values), "gather", "all_rays"};
    };
    auto paths = [](SweepRange::Role role, std::vector<double> values) {
        return SweepRange{role, std::move(values), "gather", "paths"};
    };
    return {
        {"gather", as_int(p.gather), "", "which texels of the map are gathered; all_rays: each with a shadow ray",
         0, 3, {"disc", "all", "all_rays", "paths"}, false, {curves, {0, 1, 2, 3}, "", ""}},
        {"variant", as_int(p.variant), "",
         "corrected, or the weights and constants as printed: xi1^2, rho^2 and no 1/pi (LRA 4.3.3, VRSM 3.2)", 0, 1,
         {"corrected", "published"}, false, disc(curves, {0, 1})},
        {"samples", &p.samples, "", "samples of the disc: VRSM names 400, LRA 200", 1, 65536, {}, true,
         disc(along, {25, 50, 100, 200, 400, 800})},
        {"radius", &p.radius, "map sides", "radius of the disc, length of a path; 0.3 is ours", 1e-6, 16, {}, false,
         disc(curves, {0.15, 0.3, 0.6})},
        {"rotations", &p.rotations, "", "rotations of the pattern, of which a pixel has one (turn); a power of two, 1 = none", 1,
         4096, {}, true, disc(curves, {1, 64})},
        {"sequence", as_int(p.sequence), "", "where xi1 and xi2 come from", 0, 2, {"hammersley", "r2", "random"}, false,
         disc(curves, {})},
        {"projection", as_int(p.projection), "",
         "plain, or clamped to the map, so that points outside it gather from its border (ours)", 0, 1,
         {"plain", "clamped"}, false},
        {"min_distance", &p.min_distance, "m", "floor of |x - x_p|; 0 is off", 0, unbounded, {}, true},
        {"rays", as_int(p.rays), "",
         "all_rays: exact, the same bits on every processor, or native, the ray tracer's own test", 0, 1,
         {"exact", "native"}, false, all_rays({})},
        {"max_rays", &p.max_rays, "rays",
         "all_rays: above it a light asks a subset of its texels, at least 16 a pixel; 0 is no limit (ours)", 0,
         unbounded, {}, false, all_rays({1e6, 4e6, 1.6e7, 6.4e7})},
        {"directions", &p.directions, "", "paths: how many; VRSM 4.4 has 15", 1, 1024, {}, true,
         paths(along, {5, 10, 15, 30, 60})},
        {"steps", &p.steps, "", "paths: samples along each; VRSM 4.4 has 10", 1, 1024, {}, true, paths(curves, {})},
        {"spacing", as_int(p.spacing), "",
         "paths: steps of one length, or growing with the root of the distance, or with the distance", 0, 2,
         {"uniform", "quadratic", "geometric"}, false, paths(curves, {})},
        {"growth", &p.growth, "", "paths: of geometric spacing, the last step over the first, where steps are many", 1, 1e6,
         {}, false, paths(curves, {})},
        {"jitter", &p.jitter, "steps", "paths: how far a sample strays along its path, of a step's length", 0, 1, {}, false,
         paths(curves, {})},
        {"turn_jitter", &p.turn_jitter, "sectors", "paths: how far a sample strays across its path, of a path's sector", 0, 1,
         {}, false, paths(curves, {})},
        {"visibility", as_int(p.visibility), "",
         "paths: none, or by VRSM's algorithm of that number; 3 and 6 are the same function", 0, 3,
         {"none", "algorithm_2", "algorithm_3", "algorithm_6"}, false, paths(curves, {0, 1, 3})},
        {"slots", &p.slots, "", "paths: slots of the micro linear buffer; VRSM 3.3 has 5", 2, 32, {}, true,
         paths(curves, {5, 9})},
        {"slot_edges", as_int(p.slot_edges), "", "paths: slots of equal angle (VRSM 3.3) or of equal solid angle (ours)", 0,
         1, {"angle", "solid_angle"}, false, paths(curves, {})},
        {"fade", &p.fade, "map sides",
         "paths, projection = clamped: how far within the map's border samples begin to hide less, to nothing at the border (ours)", 0,
         1, {}, false, paths(curves, {})},
        {"thickness", &p.thickness, "m",
         "paths: how far a sample's surface is taken to reach down, away from the light, to hide what lies in lower slots "
         "(ours); 0: it hides what is in its own slot alone (VRSM 3.3)", 0, unbounded, {}, false, paths(curves, {})},
        {"turn", as_int(p.turn), "",
         "disc, paths: how a pixel gets its rotation: by hash, or dealt out over square tiles of as many pixels, in Bayer's order "
         "(ours); automatic: over tiles of up to 8 x 8, by a hash where there are more or no square has as many", 0, 2,
         {"automatic", "hash", "tile"}, false, paths(curves, {0, 1})},
        {"texels", as_int(p.texels), "",
         "disc, paths: whole texels from the one rounded projection, or each sample's position rounded (the theses)", 0,
         1, {"whole", "continuous"}, false, disc(curves, {})},
        {"sample_area", as_int(p.sample_area), "",
         "disc, paths: a sample is a point (VRSM 3.1, and always where variant = published), or a disc as large as the texels "
         "that it stands for, whose light has a bound (ours)", 0, 1, {"none", "texels"}, false, disc(curves, {0, 1})},
        {"pattern", &p.pattern, "",
         "disc, paths: samples of one's own: .npy, [N, 3]: dx, dy, and the number that it stands for, in texels", 0, 0,
         {}, false},
    };
}

int sample_count(const GatherParams& params) {
    if (params.gather == Gather::disc && params.own) return int(params.own->rows.size());
    return params.gather == Gather::paths ? params.directions * params.steps : params.samples;
}

std::string stage_name(Gather gather, Texels texels) {
    return gather == Gather::all_rays ? "rsm.all_rays" : stage_of(gather, texels).info.name;
}

// A blur of 17 pixels evens out tiles of 8 x 8; of 16 x 16 their pattern stays.
constexpr int widest_tile = 8;

Turn turn_of(const GatherParams& params) {
    if (params.turn != Turn::automatic) return params.turn;
    const int tile = tile_of(params.rotations);
    return tile > 1 && tile <= widest_tile ? Turn::tile : Turn::hash;
}

std::string stage_name(const GatherParams& params) { return stage_name(params.gather, params.texels); }

namespace {

// Offsets or weights of a pattern: 256 MiB of them.
constexpr std::int64_t most_entries = 0x1p26;

bool reads_pattern(const GatherParams& params) {
    return params.gather == Gather::disc || params.gather == Gather::paths;
}

}  // namespace

void validate(const GatherParams& params) {
    GatherParams copy = params;
    const std::string stage = stage_name(params);
    validate_fields(stage, fields(copy));
    auto require = [&](bool good, const std::string& cause) {
        if (!good) throw InputError(stage + ": " + cause);
    };
    require((params.rotations & (params.rotations - 1)) == 0,
            fmt::format("rotations = {}: expected a power of two", params.rotations));
    if (!reads_pattern(params)) return;
    const int samples = sample_count(params);
    require(samples <= most_samples, fmt::format("directions = {} x steps = {}: expected at most {} samples",
                                                 params.directions, params.steps, most_samples));
    require(samples * std::int64_t(params.rotations) <= most_entries,
            fmt::format("{} samples x rotations = {}: expected at most {}", samples, params.rotations, most_entries));
    require(params.turn != Turn::tile || tile_of(params.rotations) > 1,
            fmt::format("rotations = {}: turn = \"tile\" deals out 4, 16, 64, 256, 1024 or 4096, over a square", params.rotations));
}

void validate(const GatherParams& params, const GatherInputs& in) {
    validate(params);
    const std::string stage = stage_name(params);
    auto require = [&](bool good, const std::string& cause) {
        if (!good) throw InputError(stage + ": " + cause);
    };
    require(in.position && in.normal && in.rsm, "position, normal and rsm must be bound");
    require(in.position->width == in.normal->width && in.position->height == in.normal->height,
            fmt::format("normal is {} x {}, position is {} x {}: expected equal sizes", in.normal->width,
                        in.normal->height, in.position->width, in.position->height));
    require(in.rsm->size >= 1 && in.rsm->size <= most_side,
            fmt::format("the map's side is {} texels: expected 1 to {}", in.rsm->size, most_side));
    const bool depth_alone = in.rsm->flux.empty() && in.rsm->records.empty() && in.rsm->half_records.empty();
    require(!depth_alone, "the map was drawn for its depth alone: it holds no flux");
    require(!in.tiles || in.tiles->fits({in.position->width, in.position->height}), "tiles are of another size");
    require(params.gather != Gather::all_rays || in.rays, "rays must be bound");
    if (!reads_pattern(params)) return;
    const int samples = sample_count(params);
    require(in.pattern != nullptr, "pattern must be bound");
    const std::size_t offsets = std::size_t(samples) * std::size_t(params.rotations);
    const bool whole = params.texels == Texels::whole;
    const std::size_t bound = whole ? in.pattern->offsets.size() : in.pattern->positions.size() / 2;
    require(bound == offsets, fmt::format("pattern has {} {}: texels = \"{}\" reads {}", bound,
                                          whole ? "offsets" : "positions", whole ? "whole" : "continuous", offsets));
    require(in.pattern->samples == samples && in.pattern->rotations == params.rotations,
            fmt::format("pattern has {} samples by {} rotations: expected {} by {}", in.pattern->samples,
                        in.pattern->rotations, samples, params.rotations));
    const std::size_t weights = params.gather == Gather::paths ? offsets : std::size_t(samples);
    require(in.pattern->weights.size() >= weights,
            fmt::format("pattern has {} weights: expected {}", in.pattern->weights.size(), weights));
    require(params.own || double(params.radius) * in.rsm->size < 32767,
            fmt::format("radius = {} of {} texels: whole-texel offsets end at 32767", params.radius, in.rsm->size));
}

void run(const GatherParams& params, const GatherInputs& in, const RunOptions& options, Image4& irradiance) {
    if (params.gather == Gather::all_rays) return run_all_rays(params, in, {in.rsm, 1}, options, irradiance, nullptr);
    plumb::run(stage_of(params), data_of(params, in), options, irradiance);
}

void run_maps(const GatherParams& params, const GatherInputs& given, std::span<const raster::Rsm> maps,
              const RunOptions& options, Image4& irradiance, RaysReport* report) {
    if (params.gather == Gather::all_rays) return run_all_rays(params, given, maps, options, irradiance, report);
    GatherInputs in = given;
    if (maps.size() == 1) {
        in.rsm = maps.data();
        return run(params, in, options, irradiance);
    }
    irradiance = Image4(in.position->width, in.position->height);
    for (std::size_t m = 0; m < maps.size(); ++m) {
        if (maps[m].size == 0) continue;
        RunOptions part = options;
        if (options.progress)
            part.progress = [&, m](double done) { options.progress((double(m) + done) / double(maps.size())); };
        in.rsm = &maps[m];
        Image4 share;
        run(params, in, part, share);
        for (std::size_t i = 0; i < share.size(); ++i) irradiance.texels[i] += share.texels[i];
    }
}

std::vector<TapValue> explain(const GatherParams& params, const GatherInputs& in, glm::ivec2 pixel) {
    if (params.gather == Gather::all_rays) return explain_all_rays(params, in, {in.rsm, 1}, pixel);
    return plumb::explain(stage_of(params), data_of(params, in), pixel);
}

std::vector<TapValue> explain_maps(const GatherParams& params, const GatherInputs& given,
                                   std::span<const raster::Rsm> maps, glm::ivec2 pixel) {
    if (params.gather == Gather::all_rays) return explain_all_rays(params, given, maps, pixel);
    GatherInputs in = given;
    if (maps.size() == 1) {
        in.rsm = maps.data();
        return explain(params, in, pixel);
    }
    FpEnvironment environment;
    Recorder recorder;
    glm::vec3 sum(0);
    for (std::size_t m = 0; m < maps.size(); ++m) {
        if (maps[m].size == 0) continue;
        in.rsm = &maps[m];
        recorder("face", std::int32_t(m), "of the point light: +x -x +y -y +z -z");
        const std::vector<TapValue> values = explain(params, in, pixel);
        recorder.values.insert(recorder.values.end(), values.begin(), values.end());
        for (int c = 0; c < 3; ++c) sum[c] += float(values.back().value[std::size_t(c)]);
    }
    recorder("irradiance", sum, "sum over the faces, W/m2");
    return recorder.values;
}

StageInfo info_all_rays() {
    GatherParams defaults;
    defaults.gather = Gather::all_rays;
    StageInfo s;
    s.name = stage_name(defaults);
    s.source = "VRSM fig. 5.1 d: (3.2) over every texel, a shadow ray each; a reference on the CPU, so without a twin: "
               "no device binds its inputs, they are what the function is given";
    s.inputs = {
        {"position", "image rgba32f", "m", "world-space position of the shading points"},
        {"normal", "image rgba32f", "", "unit normal of the shading points"},
        {"rsm", "records rsm", "", "reflective shadow map: position m, normal, flux W; of a point light a map a face"},
        {"rays", "ray query", "", "the scene's triangles"},
    };
    s.outputs = {{"irradiance", "image rgba32f", "W/m2", "indirect irradiance, one bounce"},
                 {"standard_error", "image rgba32f", "W/m2",
                  "of the irradiance, by channel, where a subset of the texels was asked; else 0"}};
    s.params = describe(fields(defaults));
    return s;
}

}  // namespace plumb::rsm
