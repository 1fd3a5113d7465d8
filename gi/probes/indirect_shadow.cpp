#include "gi/probes/indirect_shadow.h"

#include "gi/lend.h"

namespace plumb::probes {

StageData data_of(const IndirectShadowInputs& in) {
    const char* stage = "probes.indirect_shadow";
    const Image4& position = bound(stage, "position", in.position);
    if (!in.id || !in.spheres) throw InputError(fmt::format("{}: id and spheres must be bound", stage));
    const std::size_t count = in.spheres->owner.size();
    if (count < 1 || count > std::size_t(most_shadow_spheres) || in.spheres->rows.size() != shadow_rows * count)
        throw InputError(fmt::format("{}: {} rows of {} spheres: expected seven of each, and 1 to {} spheres", stage,
                                     in.spheres->rows.size(), count, most_shadow_spheres));
    StageData d = begin_data<IndirectShadowKernel>(size_of(position), IndirectShadowUniforms{position.width, position.height,
                                                                                           int(count), in.directional ? 1 : 0});
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"irradiance", in.irradiance}});
    lend(d.inputs, "id", {std::int64_t(in.id->size()), 2}, &in.id->data()->x);
    lend(d.inputs, "owner", {std::int64_t(count), 2}, &in.spheres->owner[0].x);
    lend(d.inputs, "spheres", {std::int64_t(in.spheres->rows.size()), 4}, &in.spheres->rows[0].x);
    return d;
}

}  // namespace plumb::probes
