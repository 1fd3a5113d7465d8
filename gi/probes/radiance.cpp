#include "gi/probes/radiance.h"

#include "gi/lend.h"

namespace plumb::probes {

namespace {

// Without a branch: they are asked of every ray of every frame. False for what is no number.
bool is_flag(float w) { return w * (w - 1) == 0; }
bool is_level(float z, int levels) {
    const std::int32_t k = number<float>::truncate_to_index(z);
    return in_range(k, levels) & (float(k) == z);
}

const Buffer<glm::vec4>& listed(const char* name, const Buffer<glm::vec4>* list, std::int64_t count) {
    if (!list || std::int64_t(list->size()) != count)
        throw InputError(fmt::format("probes.radiance: {} of {} rays: expected {}", name, list ? list->size() : 0, count));
    return *list;
}

}  // namespace

void check_radiance(RadianceView& v, Buffer<float>&) {
    const std::ptrdiff_t rays = std::ptrdiff_t(v.u.width) * v.u.height;
    bool all = true;
    for (std::ptrdiff_t i = 0; i < rays; ++i) all &= is_flag(v.surface[4 * i + 3]) & is_level(v.place[4 * i + 2], v.u.levels);
    for (std::ptrdiff_t i = 0; !all && i < rays; ++i) {
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
