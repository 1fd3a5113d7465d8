#include "core/host_math.h"
#include "gi/isr/isr.h"

namespace plumb::isr {

namespace {

int radius_of(const IsrParams& params) { return params.blur == Blur::none ? 0 : params.blur_radius; }

BlurKind kind_of(const IsrParams& params) {
    if (params.blur == Blur::edge_aware) return BlurKind::edge_aware;
    return params.variant == Variant::published && params.blur == Blur::gaussian ? BlurKind::published
                                                                                 : BlurKind::gaussian;
}

}  // namespace

Buffer<float> blur_weights(const IsrParams& given) {
    const IsrParams params = resolved(given);
    const int radius = radius_of(params);
    const double sigma = params.blur_sigma;
    std::vector<double> g;
    double total = 0;
    for (int d = -radius; d <= radius; ++d) total += g.emplace_back(host::exp(-(d * d) / (2 * sigma * sigma)));
    Buffer<float> weights;
    for (double w : g) weights.push_back(float(w / total));
    return weights;
}

StageData data_of(const IsrParams& given, const BlurInputs& in) {
    validate(given);
    const IsrParams params = resolved(given);
    const glm::ivec2 size = size_of(bound("isr.blur", "lit", in.lit));
    bound("isr.blur", "surface", in.surface);
    const CoarseCamera& camera = in.camera;
    if (kind_of(params) == BlurKind::edge_aware && camera.footprint <= 0)
        throw InputError("isr.blur: camera must be bound: blur = edge_aware measures distances from planes");
    const auto vector = [](const glm::dvec3& v) { return glm::vec4(glm::vec3(v), 0); };
    StageData d = begin_data<BlurKernel>(
        size, BlurUniforms{vector(camera.f_u), vector(camera.f_v), vector(camera.f_o), size.x, size.y, radius_of(params),
                           in.direction == Direction::vertical, int(kind_of(params)), {}});
    lend(d, {{"lit", in.lit}, {"surface", in.surface}});
    const Buffer<float> spatial = blur_weights(params);
    add(d.inputs, "spatial", {int(spatial.size())}, spatial.data());
    lend_tiles(d, in.tiles);
    // What has no surface is nothing, and open; as printed it is blurred too.
    if (kind_of(params) == BlurKind::published) d.tiles = {};
    return d;
}

}  // namespace plumb::isr
