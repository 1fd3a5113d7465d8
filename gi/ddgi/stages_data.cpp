#include "gi/ddgi/blend.h"
#include "gi/ddgi/sample.h"
#include "gi/lend.h"

namespace plumb::ddgi {

StageData data_of(const BlendInputs& in) {
    const Image4 &hits = bound("ddgi.blend", "hits", in.hits), &previous = bound("ddgi.blend", "previous", in.previous);
    if (!in.directions || in.directions->empty()) throw InputError("ddgi.blend: no directions");
    if (hits.empty() || hits.width != int(in.directions->size()))
        throw InputError(fmt::format("ddgi.blend: hits of {} rays for {} directions", hits.width, in.directions->size()));
    if (in.side < 1 || in.columns < 1) throw InputError("ddgi.blend: side and columns: expected 1 or more");
    const BlendUniforms u{previous.width, previous.height, in.side, in.columns, hits.height, hits.width, in.moments ? 1 : 0,
                          in.sharpness, in.hysteresis, in.scale, in.farthest, in.least_weight};
    StageData d = begin_data<BlendKernel>(size_of(previous), u);
    lend(d.inputs, "directions", {hits.width, 4}, &(*in.directions)[0].x);
    lend(d.inputs, "hits", {std::int64_t(hits.width) * hits.height, 4}, &hits.data()->x);
    lend(d, {{"previous", in.previous}});
    return d;
}

StageData data_of(const BorderInputs& in) {
    const Image4& atlas = bound("ddgi.border", "atlas", in.atlas);
    StageData d = begin_data<BorderKernel>(size_of(atlas), BorderUniforms{atlas.width, atlas.height, in.side, 0});
    lend(d, {{"atlas", in.atlas}});
    return d;
}

StageData data_of(const SampleInputs& in) {
    static const Image4 nothing(1, 1);
    const Image4& position = bound("ddgi.sample", "position", in.position);
    const Weighing& w = in.weighing;
    const Grid& g = in.grid;
    const SampleUniforms u{position.width, position.height, in.side, in.depth_side, g.count.x, g.count.y, g.count.z,
                           w.visibility ? 1 : 0, w.wrapped ? 1 : 0, w.root ? 1 : 0, in.view ? 0 : 1, w.scale,
                           w.normal_bias, w.view_bias, w.crush, w.least_weight,
                           {g.origin.x, g.origin.y, g.origin.z, 0}, {g.spacing.x, g.spacing.y, g.spacing.z, 0},
                           {in.eye.x, in.eye.y, in.eye.z, 0}};
    StageData d = begin_data<SampleKernel>(size_of(position), u);
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"view", in.view ? in.view : &nothing},
             {"irradiance", in.irradiance}, {"moments", w.visibility ? in.moments : &nothing}});
    return d;
}

}  // namespace plumb::ddgi
