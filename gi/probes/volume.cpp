#include "gi/probes/volume.h"

#include "gi/lend.h"

namespace plumb::probes {

StageData data_of(const VolumeInputs& in) {
    const Image4& position = bound("probes.volume", "position", in.position);
    const SpatialGrid& g = in.grid;
    if (!in.irradiance || g.places() < 1 || in.irradiance->size() != std::size_t(g.places()) * spatial_directions)
        throw InputError(fmt::format("probes.volume: {} irradiances of a grid of {} x {} x {} places: expected six of each",
                                     in.irradiance ? in.irradiance->size() : 0, g.count.x, g.count.y, g.count.z));
    const VolumeUniforms u{position.width, position.height, g.count.x, g.count.y, g.count.z, int(in.form), in.everywhere ? 1 : 0, in.least,
                           {g.origin.x, g.origin.y, g.origin.z, 0}, {g.spacing.x, g.spacing.y, g.spacing.z, 0}};
    StageData d = begin_data<VolumeKernel>(size_of(position), u);
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"lightmap_uv", in.lightmap_uv}});
    lend(d.inputs, "grid", {std::int64_t(in.irradiance->size()), 4}, &(*in.irradiance)[0].x);
    return d;
}

void run(const VolumeInputs& in, const RunOptions& options, VolumeLight& out) {
    const StageData data = data_of(in);
    Bundle outputs;
    for (const auto& [name, image] : {std::pair("irradiance", &out.irradiance), std::pair("light", &out.light),
                                      std::pair("from_light", &out.from_light)}) {
        if (size_of(*image) != data.size) *image = Image4(data.size.x, data.size.y);
        lend(outputs, name, {data.size.y, data.size.x, 4}, &image->data()->x);
    }
    stage<VolumeKernel>().bind(data)->run(options, {}, outputs);
}

}  // namespace plumb::probes
