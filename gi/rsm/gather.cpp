#include "gi/rsm/gather.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <type_traits>

#include "core/error.h"
#include "core/host_math.h"
#include "core/fp_environment.h"
#include "core/parallel.h"
#include "gi/rsm/all_rays.h"
#include "gi/rsm/bindings.h"
#include "gi/rsm/gather_rows.h"
#include "gi/rsm/paths.h"
#include "raster/light_view.h"

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
        {"rotations", &p.rotations, "", "rotations of the pattern, chosen per pixel by hash; a power of two, 1 = none", 1,
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
        {"turn", as_int(p.turn), "",
         "how a pixel gets its rotation: by hash, or dealt out over tiles of 4 x 4 pixels (paths; ours)", 0, 1,
         {"hash", "tile"}, false, paths(curves, {0, 1})},
        {"texels", as_int(p.texels), "",
         "disc, paths: whole texels from the one rounded projection, or each sample's position rounded (the theses)", 0,
         1, {"whole", "continuous"}, false, disc(curves, {})},
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
    const bool continuous = texels == Texels::continuous;
    switch (gather) {
        case Gather::disc: return continuous ? "rsm.disc_continuous" : "rsm.disc";
        case Gather::paths: return continuous ? "rsm.paths_continuous" : "rsm.paths";
        case Gather::all: return "rsm.all";
        case Gather::all_rays: break;
    }
    return "rsm.all_rays";
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
    require(params.turn == Turn::hash || params.rotations >= 16,
            fmt::format("rotations = {}: turn = \"tile\" deals out at least 16", params.rotations));
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
    require(in.rsm->size >= 1 && in.rsm->size <= 32767,
            fmt::format("the map's side is {} texels: expected 1 to 32767", in.rsm->size));
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
    require(params.own || double(params.radius) * in.rsm->size < 32767,
            fmt::format("radius = {} of {} texels: whole-texel offsets end at 32767", params.radius, in.rsm->size));
}

float least_distance2(const GatherParams& params) {
    // Below 1e-37 m2 the inverse would overflow.
    return std::max(params.min_distance * params.min_distance, 1e-37f);
}

float irradiance_scale(const GatherParams& params) {
    return params.variant == Variant::published ? 1.0f : float(1 / host::pi);
}

Buffer<float> widened(const Buffer<Half>& halves) {
    Buffer<float> floats(halves.size());
    for (std::size_t i = 0; i < halves.size(); ++i) floats[i] = half_to_float(halves[i]);
    return floats;
}

int reach_of(const Pattern& pattern) {
    int reach = 0;
    for (const std::int32_t offset : pattern.offsets)
        reach = std::max({reach, std::abs(std::int32_t(std::int16_t(offset))), std::abs(offset >> 16)});
    float farthest = 0;
    for (const float d : pattern.positions) farthest = std::max(farthest, std::abs(d));
    return pattern.positions.empty() ? reach : int(farthest) + 2;
}

GatherUniforms gather_uniforms(const GatherParams& params, const GatherInputs& in) {
    GatherUniforms u{};
    u.map = raster::projection_args(in.rsm->view, in.rsm->size, params.projection == Projection::clamped);
    u.least_distance2 = least_distance2(params);
    u.scale = irradiance_scale(params);
    u.samples = sample_count(params);
    u.rotations = params.rotations;
    u.width = in.position->width;
    u.height = in.position->height;
    u.seed = in.seed;
    if (in.pattern) u.reach = reach_of(*in.pattern);
    return u;
}

namespace {

// Fills the kernel's view of the inputs.
template <class Component>
GatherInputsView<Component> view_of(const GatherParams& params, const GatherInputs& in, const Component* records) {
    GatherInputsView<Component> v{};
    v.u = gather_uniforms(params, in);
    v.position = &in.position->data()->x;
    v.normal = &in.normal->data()->x;
    v.records = records;
    if (!in.pattern) return v;
    v.weights = in.pattern->weights.data();
    if (params.texels == Texels::whole)
        v.offsets = in.pattern->offsets.data();
    else
        v.positions = in.pattern->positions.data();
    return v;
}

// One lane over the whole image: F is double (the truth of a stability report).
template <class F, class Component>
vec3<F> one_pixel(const GatherParams& params, const GatherInputsView<Component>& in, int x, int y) {
    NoTap tap;
    if constexpr (std::is_same_v<Component, float>)
        if (params.gather == Gather::all) return gather_all<F>(in, x, y, tap);
    return in.positions ? gather_disc<F, true>(in, x, y, tap) : gather_disc<F>(in, x, y, tap);
}

}  // namespace

void run(const GatherParams& params, const GatherInputs& in, const RunOptions& options, Image4& irradiance) {
    validate(params, in);
    if (params.gather == Gather::all_rays)
        return run_all_rays(params, in, {in.rsm, 1}, options, irradiance, nullptr);
    if (params.gather == Gather::paths) return run_paths(params, in, options, irradiance);
    irradiance = Image4(in.position->width, in.position->height);
    const int band = params.gather == Gather::all ? 1 : 16;
    auto shade = [&](auto view, auto rows) {
        view.irradiance = &irradiance.data()->x;
        parallel_bands(irradiance.height, band, options, [&](int first, int last) {
            rows(view, first, last, in.tiles ? in.tiles->row(first) : nullptr);
        });
    };
    dispatch(options.isa, [&](auto isa) {
        if (params.gather == Gather::all) {
            const Buffer<float> floats = in.rsm->half ? widened(in.rsm->half_records) : Buffer<float>();
            const float* records = in.rsm->half ? floats.data() : in.rsm->records.data();
            shade(view_of(params, in, records), GatherRows<isa(), float>::all);
        } else if (in.rsm->half) {
            shade(view_of(params, in, in.rsm->half_records.data()), GatherRows<isa(), Half>::disc);
        } else {
            shade(view_of(params, in, in.rsm->records.data()), GatherRows<isa(), float>::disc);
        }
    });
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

void run_double(const GatherParams& params, const GatherInputs& in, const RunOptions& options,
                Image<glm::dvec4>& irradiance) {
    validate(params, in);
    if (params.gather == Gather::paths) return run_paths_double(params, in, options, irradiance);
    irradiance = Image<glm::dvec4>(in.position->width, in.position->height);
    const Buffer<float> floats = in.rsm->half ? widened(in.rsm->half_records) : in.rsm->records;
    const auto view = view_of(params, in, floats.data());
    parallel_bands(irradiance.height, 1, options, [&](int first, int last) {
        for (int y = first; y < last; ++y)
            for (int x = 0; x < irradiance.width; ++x)
                irradiance(x, y) = glm::dvec4(one_pixel<double>(params, view, x, y), 0);
    });
}

std::vector<TapValue> explain(const GatherParams& params, const GatherInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    if (params.gather == Gather::all_rays) return explain_all_rays(params, in, {in.rsm, 1}, pixel);
    if (params.gather == Gather::paths) return explain_paths(params, in, pixel);
    const Buffer<float> floats = in.rsm->half ? widened(in.rsm->half_records) : in.rsm->records;
    const auto view = view_of(params, in, floats.data());
    FpEnvironment environment;
    Recorder recorder;
    if (params.gather == Gather::all)
        gather_all<float>(view, pixel.x, pixel.y, recorder);
    else if (view.positions)
        gather_disc<float, true>(view, pixel.x, pixel.y, recorder);
    else
        gather_disc<float>(view, pixel.x, pixel.y, recorder);
    return recorder.values;
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

namespace {

// The table that says where the samples are.
Port samples_info(Texels texels, const std::string& shape) {
    if (texels == Texels::whole)
        return {"offsets", "buffer i32", "texels", shape + " whole-texel offsets, 16 bits each"};
    return {"positions", "buffer f32 x 2", "texels", shape + " offsets from the projection"};
}

StageInfo info(Gather gather, Texels texels = Texels::whole) {
    GatherParams defaults;
    defaults.gather = gather, defaults.texels = texels;
    const std::string continuous = texels == Texels::continuous ? "_continuous" : "";
    StageInfo s;
    s.inputs = {
        {"position", "image rgba32f", "m", "world-space position of the shading points"},
        {"normal", "image rgba32f", "", "unit normal of the shading points"},
        {"rsm", "records rsm", "", "reflective shadow map: position m, normal, flux W; of a point light a map a face"},
    };
    s.outputs = {{"irradiance", "image rgba32f", "W/m2", "indirect irradiance, one bounce"}};
    s.params = describe(fields(defaults));
    s.name = stage_name(defaults);
    if (gather == Gather::all) {
        s.source = "VRSM (3.2), summed over every texel";
        s.twin = "gi/rsm/gather_all.comp";
        return s;
    }
    if (gather == Gather::all_rays) {
        s.source = "VRSM fig. 5.1 d: (3.2) over every texel, a shadow ray each; a reference on the CPU, so without a twin";
        s.inputs.push_back({"rays", "ray query", "", "the scene's triangles"});
        s.outputs.push_back({"standard_error", "image rgba32f", "W/m2",
                             "of the irradiance, by channel, where a subset of the texels was asked; else 0"});
        return s;
    }
    if (gather == Gather::paths) {
        s.source = "VRSM 3.2, 3.3, Algorithms 2, 3, 5 and 6";
        s.inputs.push_back(samples_info(texels, "[directions][steps][rotations]"));
        s.inputs.push_back({"weights", "buffer f32", "texels",
                            "[directions][steps][rotations] texels that a sample stands for"});
        s.inputs.push_back({"edges", "buffer f32", "", "[slots - 1] where slots meet: s |s|, s the elevation's sine"});
        s.twin = "gi/rsm/paths" + continuous + ".comp";
        return s;
    }
    s.source = "Dachsbacher and Stamminger 2005; LRA 4.3.3; VRSM (3.2)";
    s.inputs.push_back(samples_info(texels, "[samples][rotations]"));
    s.inputs.push_back({"weights", "buffer f32", "texels", "[samples] texels that a sample stands for"});
    s.twin = "gi/rsm/gather" + continuous + ".comp";
    return s;
}

}  // namespace

StageInfo info_disc(Texels texels) { return info(Gather::disc, texels); }
StageInfo info_paths(Texels texels) { return info(Gather::paths, texels); }
StageInfo info_all() { return info(Gather::all); }
StageInfo info_all_rays() { return info(Gather::all_rays); }

}  // namespace plumb::rsm
