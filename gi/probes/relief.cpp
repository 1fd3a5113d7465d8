#include "gi/probes/relief.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "gi/lend.h"
#include "raster/light_view.h"

namespace plumb::probes {

StageData data_of(const ReliefInputs& in) {
    const Image4& position = bound("probes.relief", "position", in.position);
    const std::size_t lights = in.lights ? in.lights->size() : 0, seen = in.visibility ? in.visibility->size() : 0;
    if (lights > 0 && seen != lights * position.size())
        throw InputError(fmt::format("probes.relief: visibility has {} values: expected {} lights of {} pixels", seen, lights, position.size()));
    const ReliefUniforms u{position.width, position.height, in.maps ? 1 : 0, in.highlights ? 1 : 0, in.most, int(lights), {},
                           {in.eye.x, in.eye.y, in.eye.z, 0}};
    StageData d = begin_data<ReliefKernel>(size_of(position), u);
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"irradiance", in.irradiance}, {"mapped", in.mapped}, {"plain", in.plain},
             {"light", in.light}, {"from_light", in.from_light}, {"specular", in.specular}});
    // A device binds no empty buffer: without a light there is one that is not read.
    std::vector<raster::LightArgs> args;
    for (std::size_t i = 0; i < lights; ++i) args.push_back(raster::light_args((*in.lights)[i]));
    args.resize(std::max(lights, std::size_t(1)));
    add(d.inputs, "lights", {std::int64_t(args.size()) * 4, 4}, args[0].position);
    const Shape layers{std::int64_t(args.size()), position.height, position.width};
    if (lights > 0)
        lend(d.inputs, "visibility", layers, in.visibility->data());
    else
        add(d.inputs, "visibility", DType::f32, layers);
    return d;
}

void run(const ReliefInputs& in, const RunOptions& options, ReliefLight& out) {
    const StageData data = data_of(in);
    Bundle outputs;
    for (const auto& [name, image] : {std::pair("relieved", &out.relieved), std::pair("glossy", &out.glossy)}) {
        if (size_of(*image) != data.size) *image = Image4(data.size.x, data.size.y);
        lend(outputs, name, {data.size.y, data.size.x, 4}, &image->data()->x);
    }
    stage<ReliefKernel>().bind(data)->run(options, {}, outputs);
}

}  // namespace plumb::probes
