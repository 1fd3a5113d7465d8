#include "gi/probes/relief.h"

#include "gi/lend.h"

namespace plumb::probes {

StageData data_of(const ReliefInputs& in) {
    const Image4& position = bound("probes.relief", "position", in.position);
    const ReliefUniforms u{position.width, position.height, in.maps ? 1 : 0, in.highlights ? 1 : 0, in.most, {}, {in.eye.x, in.eye.y, in.eye.z, 0}};
    StageData d = begin_data<ReliefKernel>(size_of(position), u);
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"irradiance", in.irradiance}, {"mapped", in.mapped}, {"plain", in.plain},
             {"light", in.light}, {"from_light", in.from_light}, {"specular", in.specular}});
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
