#include "gi/direct/direct.h"

#include "raster/light_view.h"

namespace plumb::direct {

std::vector<Field> fields(DirectParams& p) {
    return {
        {"variant", as_int(p.variant), "",
         "corrected, or VRSM 4.3 as printed: pi times the shadow density, without intensity and cosine", 0, 1,
         {"corrected", "published"}, false},
    };
}

StageData data_of(const DirectParams& params, const DirectInputs& in) {
    DirectParams copy = params;
    validate_fields("direct", fields(copy));
    const Image4& position = bound("direct", "position", in.position);
    const glm::ivec2 size = size_of(position);
    const std::size_t lights = in.lights->size();
    if (!in.visibility || in.visibility->size() != lights * position.size())
        throw InputError(fmt::format("direct: visibility has {} values: expected {} lights of {} pixels",
                                     in.visibility ? in.visibility->size() : 0, lights, position.size()));
    const bool printed = params.variant == DirectVariant::published;
    StageData d = begin_data<DirectKernel>(size, DirectUniforms{int(lights), size.x, size.y, printed ? 2 : in.density ? 1 : 0});
    lend(d, {{"position", in.position}, {"normal", in.normal}});

    // A device binds no empty buffer: without a light there is one that is not read.
    std::vector<raster::LightArgs> args;
    for (const Light& light : *in.lights) args.push_back(raster::light_args(light));
    args.resize(std::max(lights, std::size_t(1)));
    add(d.inputs, "lights", {std::int64_t(args.size()) * 4, 4}, args[0].position);
    const Shape layers{std::int64_t(args.size()), size.y, size.x};
    if (lights > 0)
        lend(d.inputs, "visibility", layers, in.visibility->data());
    else
        add(d.inputs, "visibility", DType::f32, layers);
    lend_tiles(d, in.tiles);
    return d;
}

}  // namespace plumb::direct
