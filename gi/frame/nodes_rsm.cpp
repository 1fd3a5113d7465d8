// Indirect light by gathers from reflective shadow maps: one of each light, and their sum.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/hash.h"
#include "core/parallel.h"
#include "gi/frame/filters.h"
#include "gi/frame/frame_graph.h"
#include "gi/reference/ray_query.h"
#include "gi/rsm/all_rays.h"

namespace plumb::frame {

namespace {

// Milliseconds for a million shadow rays (nodes_raster.cpp).
constexpr double ms_exact_rays = 100, ms_native_rays = 25;

void add(Image4& sum, const Image4& term) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum.texels[i] += term.texels[i];
}

// The sum of those images, in their order, each read once.
void add_all(const std::vector<const Image4*>& terms, Image4& sum, int threads) {
    parallel_bands(sum.height, 16, threads, [&](int first, int last) {
        for (int y = first; y < last; ++y) {
            glm::vec4* row = &sum(0, y);
            std::fill_n(row, sum.width, glm::vec4(0));
            for (const Image4* term : terms) {
                const glm::vec4* from = &(*term)(0, y);
                for (int x = 0; x < sum.width; ++x) row[x] += from[x];
            }
        }
    });
}

// Adds a light's standard error to those of others: independent errors add by their squares.
void add_errors(Image4& sum, const Image4& term) {
    if (sum.empty()) sum = Image4(term.width, term.height);
    for (std::size_t i = 0; i < sum.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double a = sum.texels[i][c], b = term.texels[i][c];
            sum.texels[i][c] = float(std::sqrt(a * a + b * b));
        }
}

// Where the sum of the gathers lies.
Image4& sum_of(Context& c) { return filters_indirect(c.settings) ? c.frame.gathered : c.frame.indirect; }

void add_to_sum(Context& c, const Image4& irradiance, const Image4& error) {
    add(sum_of(c), irradiance);
    if (!error.empty()) add_errors(c.frame.indirect_error, error);
}

// VRSM fig. 4.4: each gather has a target of its own. No bound of what may be gathered at a point is of use, since points
// may touch texels: what does not fit is refused when it is found.
void store_irradiance(const Context& c, const std::string& stage, int light, Image4& irradiance, int threads) {
    const raster::Layout& layout = c.settings.layout;
    const std::optional<raster::Overflow> overflow = raster::quantise(layout.indirect, irradiance, threads);
    if (!overflow) return;
    throw InputError(
        fmt::format("{}: light \"{}\": pixel {},{}: indirect irradiance of {:.4g} W/m2 does not fit {} ({:g}), which "
                    "layout \"{}\" stores it in: use fp32, a larger min_distance or a weaker light",
                    stage, c.scene.lights[std::size_t(light)].name, overflow->pixel.x, overflow->pixel.y,
                    overflow->value, info(layout.indirect).name, raster::range_of(layout.indirect).largest.x,
                    layout.name));
}

// How often the inner loop of a light's gather runs, and what it takes.
PlannedNode begin_gather(Context& c, int l) {
    const rsm::GatherParams& params = c.settings.rsm;
    const Light& light = c.lights[std::size_t(l)];
    const int maps = raster::map_count(light);
    const double side = light.rsm_size, texels = maps * side * side;
    const glm::ivec2 size = gather_size(c.settings, c.size);
    const double pixels = double(size.x) * size.y;
    const std::string why = "indirect light of this light";
    if (params.gather == rsm::Gather::all) return begin_node(c, rsm::stage_of(params), "gather", why, pixels * texels, l);
    if (params.gather != rsm::Gather::all_rays)
        return begin_node(c, rsm::stage_of(params), "gather", why, pixels * maps * rsm::sample_count(params), l);
    // How many texels are lit and how many pixels see a surface, only the run knows.
    const double asked = double(rsm::texels_asked(params, std::uint64_t(pixels), std::uint64_t(texels)));
    const std::string subset =
        asked < texels ? fmt::format("; subset of at least {} of {} texels a pixel", asked, texels) : "";
    const double ms = params.rays == Rays::exact ? ms_exact_rays : ms_native_rays;
    return begin_node(c, rsm::stage_name(params), "gather", why + subset, pixels * asked, {ms, "shadow rays at most"}, l);
}

// What a gather by rays reads beside the points and the maps.
void add_offsets(Context& c, int light, rsm::GatherInputs& in) {
    const World& world = c.world();
    const View view = c.camera_view();
    in.offsets = rsm::ray_offsets(c.settings.layout, world.low, world.high, view, c.size);
    // Each light chooses for itself: their errors are independent.
    in.seed = std::uint32_t(pcg(std::int32_t(c.settings.seed) + pcg(std::int32_t(light))));
}

}  // namespace

void begin_sum(Context& c) {
    const glm::ivec2 size = gather_size(c.settings, c.size);
    sum_of(c) = Image4(size.x, size.y);
    if (c.frame.indirect.empty()) c.frame.indirect = Image4(c.size.x, c.size.y);
    c.frame.indirect_error = {};
}

void add_gather(Context& c, int l, Nodes& nodes) {
    const rsm::GatherParams& params = c.settings.rsm;
    const bool traces = params.gather == rsm::Gather::all_rays, half = halves_indirect(c.settings);
    PlannedNode node = begin_gather(c, l);
    node.size = [&c] { return gather_size(c.settings, c.size); };
    node.adds = true;
    node.results = {{"irradiance", "irradiance", "irradiance", 0, 3, true}};

    // Found or made for the first that asks.
    auto pattern = [&c, l, made = std::make_shared<std::shared_ptr<const rsm::Pattern>>()]() -> const rsm::Pattern& {
        const Light& light = c.lights[std::size_t(l)];
        rsm::KeptPatterns none;
        if (*made) return **made;
        const rsm::GatherParams& params = c.settings.rsm;
        *made = (c.memory ? c.memory->patterns : none).of(params, light.rsm_size, c.settings.seed);
        if (const int turn = pattern_turn(c, params.rotations)) *made = std::make_shared<const rsm::Pattern>(rsm::turned(**made, turn));
        return **made;
    };
    auto inputs = [=, &c] {
        const raster::GBuffer& g = c.frame.gbuffer;
        rsm::GatherInputs in{half ? &c.frame.half_position : &g.position, half ? &c.frame.half_normal : &g.normal,
                             nullptr, &pattern(), c.settings.seed};
        if (traces) add_offsets(c, l, in);
        return in;
    };
    auto rays = [traces, &c]() -> const RayQuery* {
        World& world = c.world();
        if (traces && !world.rays)
            world.rays = reference::build_ray_query(world.geometry, world.surfaces, c.settings.rsm.rays);
        return world.rays.get();
    };
    // rsm.all reads what rays are asked for.
    rsm::GatherParams bound = params;
    if (traces) bound.gather = rsm::Gather::all;
    auto each_dispatch = [=, &c](auto one) {
        rsm::GatherInputs in = inputs();
        each_map(c.maps(l), [&](const raster::Rsm& map, int, const std::string& face) {
            in.rsm = &map;
            StageData data = rsm::data_of(bound, in);
            data.id = face;
            one(std::move(data));
        });
    };
    (traces ? node.like : node.dispatches) = [=] {
        std::vector<StageData> all;
        each_dispatch([&](StageData data) { all.push_back(std::move(data)); });
        return all;
    };
    node.reads = [=, &c, &params](graph::Reads& r) {
        r.value(c.settings.layout.indirect);
        if (!traces) return each_dispatch([&](const StageData& data) { r.dispatch(rsm::stage_of(params), data); });
        rsm::GatherParams copy = params;
        r.fields(rsm::fields(copy));
        r.source("geometry", c.keys.geometry), r.source("surfaces", c.keys.surfaces);
        const rsm::GatherInputs in = inputs();
        r.value(in.seed, in.offsets.receiver, in.offsets.texel);
        if (params.rays == Rays::native) r.value(c.isa);
        r.image(*in.position), r.image(*in.normal);
        for (const raster::Rsm& map : c.maps(l)) r.list(map.records), r.list(map.half_records);
    };
    if (traces)
        node.inputs = [=, &c] {
            Bundle b;
            const rsm::GatherInputs in = inputs();
            lend(b, "position", *in.position), lend(b, "normal", *in.normal);
            each_map(c.maps(l), [&](const raster::Rsm& map, int, const std::string& face) {
                const Shape shape{map.size, map.size, 16};
                const std::string name = (face.empty() ? "" : face + ".") + "rsm";
                if (map.half)
                    lend(b, name, shape, map.half_records.data());
                else
                    lend(b, name, shape, map.records.data());
            });
            return b;
        };
    // Where nothing is kept it has gone into the sum.
    node.outputs = [=, &c] {
        Bundle b;
        if (c.memory && !c.keeps) return b;
        if (!c.memory && c.term(l).empty()) return lent("irradiance", sum_of(c));
        lend(b, "irradiance", c.term(l));
        if (traces) lend(b, "standard_error", c.term_error(l));
        return b;
    };
    node.run = [=, &c, &params, name = node.plan.name, label = node.plan.label, work = node.tile_work()](
                   const RunOptions& options, graph::NodeRun& run) {
        raster::Covered tiles;
        if (!traces)
            tiles = c.tiles_to_shade(work, half ? covered_by(c.frame.half_normal) : c.frame.gbuffer.covered, run);
        Image4 irradiance;
        rsm::RaysReport report;
        rsm::GatherInputs in = inputs();
        in.tiles = or_all(tiles), in.rays = rays();
        rsm::run_maps(params, in, c.maps(l), options, irradiance, &report);
        store_irradiance(c, name, l, irradiance, options.threads);
        run.bytes = bytes_of(irradiance) + bytes_of(report.standard_error);
        // What was asked takes the place of what the plan could tell.
        if (traces) run.reason = run.reason.substr(0, run.reason.find("; subset of ")) + "; " + rsm::summary(report);
        if (c.memory && !c.keeps) {
            c.summed.push_back(label);
            return add_to_sum(c, irradiance, report.standard_error);
        }
        c.term(l) = std::move(irradiance), c.term_error(l) = std::move(report.standard_error);
    };
    node.leave_out = [=, &c] {
        if (c.keeps) c.term(l) = c.term_error(l) = {};
    };
    node.fill = [&c] {
        if (sum_of(c).empty()) begin_sum(c);
    };
    node.explain = [=, &c, &params](glm::ivec2 pixel) {
        rsm::GatherInputs in = inputs();
        in.rays = rays();
        return with_stored(rsm::explain_maps(params, in, c.maps(l), pixel), "irradiance", c.settings.layout.indirect,
                           c.settings.layout);
    };
    nodes.push_back(std::move(node));
}

// Where nothing is kept, gathers add to the sum themselves: a thousand lights hold no thousand images.
void add_sum(Context& c, Nodes& nodes) {
    if (!sums_gathers(c.settings)) return;
    PlannedNode node = begin_node(c, filters_indirect(c.settings) ? "gathered" : "indirect", "", "", 0, {});
    node.listed = false;
    const bool filtered = filters_indirect(c.settings);
    auto position = [&c]() -> const Image4& {
        return halves_indirect(c.settings) ? c.frame.half_position : c.frame.gbuffer.position;
    };
    node.size = [&c] { return gather_size(c.settings, c.size); };
    node.reads = [=, &c](graph::Reads& r) {
        for (int l = 0; l < int(c.lights.size()); ++l) r.image(c.term(l)), r.image(c.term_error(l));
        for (const std::string& gather : c.summed) r.edge(gather);
        if (filtered) r.image(position());
    };
    node.outputs = [=, &c] {
        Bundle b = lent("irradiance", sum_of(c));
        lend(b, "standard_error", c.frame.indirect_error);
        return b;
    };
    node.run = [=, &c](const RunOptions& options, graph::NodeRun&) {
        if (c.keeps) {
            const glm::ivec2 size = gather_size(c.settings, c.size);
            Image4& sum = sum_of(c);
            if (sum.width != size.x || sum.height != size.y || c.frame.indirect.empty()) begin_sum(c);
            c.frame.indirect_error = {};
            std::vector<const Image4*> terms;
            for (int l = 0; l < int(c.lights.size()); ++l) {
                if (c.term(l).empty()) continue;
                terms.push_back(&c.term(l));
                if (!c.term_error(l).empty()) add_errors(c.frame.indirect_error, c.term_error(l));
            }
            add_all(terms, sum, options.threads);
        }
        if (!filtered) return;
        // Filters read the depth of its points beside it (VRSM fig. 4.4).
        Image4& sum = sum_of(c);
        for (std::size_t i = 0; i < sum.size(); ++i) sum.texels[i].w = position().texels[i].w;
    };
    node.leave_out = [&c] { begin_sum(c); };
    nodes.push_back(std::move(node));
}

}  // namespace plumb::frame
