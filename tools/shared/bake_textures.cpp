#include "tools/shared/bake_textures.h"

#include <fmt/format.h>

#include "gi/probes/textures.h"
#include "io/file.h"
#include "io/npy.h"

namespace plumb::cli {

namespace {

probes::BakeArrays arrays_of(const probes::Bake& b) {
    probes::BakeArrays a;
    a.rays = b.relight.rays, a.coefficients = b.coefficients(), a.singular_values = b.clusters.singular_values;
    for (int i = 0; i < b.receivers.count(); ++i)
        a.receivers.push_back({glm::vec3(b.receivers.position[std::size_t(i)]), b.receivers.texel[std::size_t(i)],
                               b.receivers.material[std::size_t(i)], b.receivers.border[std::size_t(i)],
                               b.clusters.cluster_of[std::size_t(i)]});
    a.u.assign(b.clusters.u.begin(), b.clusters.u.end());
    for (const glm::vec4& p : b.placement.probes) a.probes.push_back(glm::vec3(p));
    for (std::size_t i = 0; i < b.relight.material.size(); ++i)
        a.relight.push_back({b.relight.material[i], b.relight.uv[i], glm::vec3(b.relight.position[i])});
    a.sh.assign(b.harmonics.begin(), b.harmonics.end());
    for (const probes::Cluster& c : b.clusters.clusters)
        a.clusters.push_back({c.probes, c.rank, c.sigma_vt, c.low, c.high});
    return a;
}

}  // namespace

void write_textures(const probes::Bake& bake, Outputs& outputs) {
    const Bundle all = probes::all_textures(arrays_of(bake));
    std::string legend;
    for (const probes::TextureInfo& info : probes::textures()) {
        const Array& texture = at(all, info.name);
        const std::string name = info.name;
        outputs.write(name + ".bin", [&](const std::string& path) {
            io::write_file(path, {{reinterpret_cast<const char*>(texture.bytes.data()), texture.bytes.size()}});
        });
        outputs.write(name + ".npy", [&](const std::string& path) { io::write_npy(path, texture); });
        legend += fmt::format("{}: {} x {}, {}, {}{}: {}\n", name, texture.shape[1], texture.shape[0], info.vk_format, info.source,
                              *info.unit ? fmt::format(", {}", info.unit) : "", info.meaning);
    }
    outputs.write("README.txt", [&](const std::string& path) { io::write_text(path, legend); });
}

}  // namespace plumb::cli
