#include "tools/shared/bake_textures.h"

#include <fmt/format.h>

#include "gi/probes/textures.h"
#include "io/file.h"
#include "io/npy.h"

namespace plumb::cli {

void write_textures(const probes::Bake& bake, Outputs& outputs) {
    const Bundle all = probes::all_textures(probes::arrays_of(bake));
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
