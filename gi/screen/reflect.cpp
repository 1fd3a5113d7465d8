#include <algorithm>

#include "core/host_math.h"
#include "gi/run_two.h"
#include "gi/screen/screen.h"

namespace plumb::screen {

StageData data_of(const ReflectParams& params, const LobeInputs& in) {
    validate(params);
    const glm::ivec2 picture = size_of(bound("screen.lobe", "position", in.position));
    const glm::ivec2 size = sheet_of(picture, 1 + params.rays);
    LobeUniforms u{};
    for (int c = 0; c < 3; ++c) u.eye[c] = float(in.eye[c]);
    u.columns = picture.x, u.rows = picture.y, u.across = sheet_across(1 + params.rays), u.rays = params.rays;
    u.seed = std::int32_t(in.seed), u.width = size.x, u.height = size.y;
    StageData d = begin_data<LobeKernel>(size, u);
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"mirror", in.mirror}, {"lobe", in.lobe}});
    return d;
}

StageData data_of(const ReflectParams& params, const ReflectInputs& in) {
    validate(params);
    const glm::ivec2 picture = size_of(bound("screen.reflect", "position", in.position));
    const glm::ivec2 size = in.rays ? size_of(*in.rays) : picture;
    const bool published = params.variant == ReflectVariant::published;
    ReflectUniforms u{};
    u.view = seen_from(in.view, size_of(bound("screen.reflect", "map_position", in.seen)));
    for (int c = 0; c < 3; ++c) u.eye[c] = float(in.eye[c]);
    u.step = params.step, u.bias = params.bias, u.steps = params.steps, u.bisections = params.bisections;
    u.thickness = published ? params.thickness : float(double(params.thickness) * double(params.step));
    u.number = in.number, u.published = published, u.width = size.x, u.height = size.y;
    if (in.rays) u.columns = picture.x, u.rows = picture.y;
    StageData d = begin_data<ReflectKernel>(size, u);
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"mirror", in.mirror}, {"map_position", in.seen},
             {"map_normal", in.seen_normal}});
    if (in.before) lend(d, {{"before", in.before}});
    if (in.rays) lend(d, {{"rays", in.rays}});
    lend_tiles(d, in.tiles);
    return d;
}

int levels_of(glm::ivec2 size) {
    int levels = 1;
    while (levels < most_levels && (1 << levels) < std::max(size.x, size.y)) ++levels;
    return levels;
}

int padded_height(glm::ivec2 size) {
    const int side = 1 << levels_of(size);
    return (size.y + side - 1) / side * side;
}

glm::ivec2 blocks_of(glm::ivec2 size) {
    const int padded = padded_height(size);
    return {(size.x + 1) / 2, padded - (padded >> levels_of(size))};
}

StageData data_of(const ReflectParams& params, const NearestInputs& in) {
    validate(params);
    const glm::ivec2 view = size_of(bound("screen.nearest", "map_position", in.seen)), blocks = blocks_of(view);
    StageData d = begin_data<NearestKernel>(blocks, NearestUniforms{blocks.x, blocks.y, view.x, view.y, levels_of(view),
                                                                    padded_height(view), {}});
    lend(d, {{"map_position", in.seen}});
    return d;
}

StageData data_of(const ReflectParams& params, const CellsInputs& in) {
    validate(params);
    const ReflectInputs& ray = in.ray;
    const glm::ivec2 picture = size_of(bound("screen.cells", "position", ray.position));
    const glm::ivec2 size = ray.rays ? size_of(*ray.rays) : picture;
    const glm::ivec2 view = size_of(bound("screen.cells", "map_position", ray.seen));
    CellsUniforms u{};
    u.view = seen_from(ray.view, view);
    for (int c = 0; c < 3; ++c) u.eye[c] = float(ray.eye[c]);
    u.reach = float(double(params.step) * params.steps), u.thickness = float(double(params.thickness) * double(params.step));
    u.bias = params.bias, u.cells = params.cells, u.levels = levels_of(view), u.number = ray.number;
    u.padded = padded_height(view), u.width = size.x, u.height = size.y;
    if (ray.rays) u.columns = picture.x, u.rows = picture.y;
    StageData d = begin_data<CellsKernel>(size, u);
    lend(d, {{"position", ray.position}, {"normal", ray.normal}, {"mirror", ray.mirror}, {"map_position", ray.seen},
             {"map_normal", ray.seen_normal}, {"nearest", in.nearest}});
    if (ray.before) lend(d, {{"before", ray.before}});
    if (ray.rays) lend(d, {{"rays", ray.rays}});
    lend_tiles(d, in.tiles);
    return d;
}

StageData data_of(const ReflectParams& params, const MirrorInputs& in) {
    validate(params);
    const glm::ivec2 size = size_of(bound("screen.mirror", "composed", in.composed));
    MirrorUniforms u{};
    u.inv_pi = float(1 / host::pi);
    u.fade = float(double(params.fade) * std::min(size.x, size.y));
    u.attenuation = params.attenuation > 0 ? float(1 / double(params.attenuation)) : 0;
    u.width = size.x, u.height = size.y;
    u.rays = in.rays ? params.rays : 0, u.share = in.rays ? float(1.0 / params.rays) : 0, u.across = sheet_across(1 + u.rays);
    u.others = in.albedo ? 1 : 0;
    StageData d = begin_data<MirrorKernel>(size, u);
    lend(d, {{"hit", in.hit}, {"mirror", in.mirror}, {"composed", in.composed}});
    static const Image4 nothing(1, 1);  // of what is not read
    const auto or_nothing = [&](const Image4* image) { return image ? image : &nothing; };
    lend(d, {{"albedo", or_nothing(in.albedo)}, {"emission", or_nothing(in.emission)}, {"direct", or_nothing(in.direct)},
             {"drawn", or_nothing(in.rays)}});
    if (in.rays) lend(d, {{"lobe", in.lobe}});
    return d;
}

void run(const ReflectParams& params, const MirrorInputs& in, const RunOptions& options, Image4& reflection, Image4& radiance) {
    run_two(stage<MirrorKernel>(), data_of(params, in), options, reflection, radiance);
}

}  // namespace plumb::screen
