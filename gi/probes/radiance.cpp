#include "gi/probes/radiance.h"

#include "gi/lend.h"

namespace plumb::probes {

namespace {

bool is_flag(float w) { return w == 0 || w == 1; }
bool is_level(float z, int levels) {
    return (z == 0) | ((z == 1) & (levels > 1)) | ((z == 2) & (levels > 2)) | ((z == 3) & (levels > 3));
}

const Buffer<glm::vec4>& listed(const char* name, const Buffer<glm::vec4>* list, std::int64_t count) {
    if (!list || std::int64_t(list->size()) != count)
        throw InputError(fmt::format("probes.radiance: {} of {} rays: expected {}", name, list ? list->size() : 0, count));
    return *list;
}

}  // namespace

void check_radiance(RadianceView& v, Buffer<float>&) {
    const std::ptrdiff_t rays = std::ptrdiff_t(v.u.width) * v.u.height;
    int wrong = 0;
    for (std::ptrdiff_t i = 0; i < rays; ++i)
        wrong |= int(!is_flag(v.surface[4 * i + 3])) | int(!is_level(v.place[4 * i + 2], v.u.levels));
    for (std::ptrdiff_t i = 0; wrong != 0 && i < rays; ++i) {
        if (const float w = v.surface[4 * i + 3]; !is_flag(w))
            throw InputError(fmt::format("probes.radiance: surface: w of ray {} is {:g}: expected 0 or 1", i, w));
        if (const float z = v.place[4 * i + 2]; !is_level(z, v.u.levels))
            throw InputError(fmt::format("probes.radiance: place: z of ray {} is {:g}: expected a level, 0 to {}", i, z, v.u.levels - 1));
    }
}

StageData data_of(const RadianceInputs& in) {
    const std::int64_t rays = std::int64_t(in.probes) * in.rays;
    if (in.probes < 1 || in.rays < 1)
        throw InputError(fmt::format("probes.radiance: {} rays of {} probes: expected 1 or more", in.rays, in.probes));
    const RadianceUniforms u{in.rays, in.probes, in.side, in.levels, int(in.feedback), in.constant, {}};
    StageData d = begin_data<RadianceKernel>({in.rays, in.probes}, u);
    lend(d.inputs, "surface", {rays, 4}, &listed("surface", in.surface, rays)[0].x);
    lend(d.inputs, "emitted", {rays, 4}, &listed("emitted", in.emitted, rays)[0].x);
    lend(d.inputs, "direct", {rays, 4}, &listed("direct", in.direct, rays)[0].x);
    lend(d.inputs, "place", {rays, 4}, &listed("place", in.place, rays)[0].x);
    lend(d, {{"lightmap", in.lightmap}});
    return d;
}

void run(const RadianceInputs& in, const RunOptions& options, Buffer<glm::vec4>& radiance) {
    const StageData data = data_of(in);
    radiance.resize(std::size_t(in.probes) * std::size_t(in.rays));
    run(stage<RadianceKernel>(), data, options, &radiance[0].x);
}

}  // namespace plumb::probes
