#include "gi/rsm/paths.h"

#include "core/fp_environment.h"
#include "core/parallel.h"
#include "gi/rsm/bindings.h"
#include "gi/rsm/paths_rows.h"
#include "raster/light_view.h"

namespace plumb::rsm {

PathsUniforms paths_uniforms(const GatherParams& params, const GatherInputs& in) {
    PathsUniforms u{};
    u.map = raster::projection_args(in.rsm->view, in.rsm->size, params.projection == Projection::clamped);
    for (int c = 0; c < 3; ++c) u.axis[c] = float(-in.rsm->view.forward[c]);
    u.least_distance2 = least_distance2(params);
    u.scale = irradiance_scale(params);
    u.directions = params.directions;
    u.steps = params.steps;
    u.rotations = params.rotations;
    u.tiled = params.turn == Turn::tile;
    u.width = in.position->width;
    u.height = in.position->height;
    u.seed = in.seed;
    if (in.pattern) u.reach = reach_of(*in.pattern);
    u.slots = params.visibility == Visibility::none ? 0 : params.slots;
    u.propagates = params.visibility == Visibility::algorithm_2 ? 0 : -1;
    return u;
}

namespace {

template <class Component>
PathsInputsView<Component> view_of(const GatherParams& params, const GatherInputs& in, const Component* records,
                                   const Buffer<float>& edges) {
    PathsInputsView<Component> v{};
    v.u = paths_uniforms(params, in);
    v.position = &in.position->data()->x;
    v.normal = &in.normal->data()->x;
    v.records = records;
    if (params.texels == Texels::whole)
        v.offsets = in.pattern->offsets.data();
    else
        v.positions = in.pattern->positions.data();
    v.weights = in.pattern->weights.data();
    v.edges = edges.data();
    return v;
}

}  // namespace

void run_paths(const GatherParams& params, const GatherInputs& in, const RunOptions& options, Image4& irradiance) {
    irradiance = Image4(in.position->width, in.position->height);
    const Buffer<float> edges = slot_edges(params);
    auto shade = [&](auto view, auto rows) {
        view.irradiance = &irradiance.data()->x;
        parallel_bands(irradiance.height, 16, options, [&](int first, int last) {
            rows(view, first, last, in.tiles ? in.tiles->row(first) : nullptr);
        });
    };
    dispatch(options.isa, [&](auto isa) {
        if (in.rsm->half)
            shade(view_of(params, in, in.rsm->half_records.data(), edges), PathsRows<isa(), Half>::paths);
        else
            shade(view_of(params, in, in.rsm->records.data(), edges), PathsRows<isa(), float>::paths);
    });
}

void run_paths_double(const GatherParams& params, const GatherInputs& in, const RunOptions& options,
                      Image<glm::dvec4>& irradiance) {
    irradiance = Image<glm::dvec4>(in.position->width, in.position->height);
    const Buffer<float> edges = slot_edges(params);
    const Buffer<float> floats = in.rsm->half ? widened(in.rsm->half_records) : in.rsm->records;
    const auto view = view_of(params, in, floats.data(), edges);
    parallel_bands(irradiance.height, 1, options, [&](int first, int last) {
        NoTap tap;
        for (int y = first; y < last; ++y)
            for (int x = 0; x < irradiance.width; ++x)
                irradiance(x, y) = glm::dvec4(view.positions ? gather_paths<double, true>(view, x, y, tap)
                                                             : gather_paths<double>(view, x, y, tap), 0);
    });
}

std::vector<TapValue> explain_paths(const GatherParams& params, const GatherInputs& in, glm::ivec2 pixel) {
    const Buffer<float> edges = slot_edges(params);
    const Buffer<float> floats = in.rsm->half ? widened(in.rsm->half_records) : in.rsm->records;
    const auto view = view_of(params, in, floats.data(), edges);
    FpEnvironment environment;
    Recorder recorder;
    if (view.positions)
        gather_paths<float, true>(view, pixel.x, pixel.y, recorder);
    else
        gather_paths<float>(view, pixel.x, pixel.y, recorder);
    return recorder.values;
}

}  // namespace plumb::rsm
