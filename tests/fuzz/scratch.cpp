#include <unistd.h>

#include <filesystem>
#include <system_error>

#include "io/image_file.h"
#include "targets.h"

namespace plumb::fuzz {
namespace {

namespace fs = std::filesystem;

struct Folder {
    std::string path;
    Folder() {
        const fs::path shared = "/dev/shm";
        const fs::path below = ::access(shared.c_str(), W_OK) == 0 ? shared : fs::temp_directory_path();
        path = (below / ("plumb_fuzz_" + std::to_string(::getpid()))).string();
        fs::create_directories(path);
        const std::uint8_t rgb[12] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 128, 128, 128};
        io::write_png(path + "/a.png", 2, 2, rgb);
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
};

}  // namespace

const std::string& scratch_folder() {
    static const Folder folder;
    return folder.path;
}

std::span<const Format> formats() {
    constexpr std::size_t mib = std::size_t(1) << 20;
    static constexpr Format list[] = {
        {"obj", fuzz_obj, mib},
        {"mtl", fuzz_mtl, mib},
        {"gltf", fuzz_gltf, 8 * mib},  // nodes may repeat a mesh: what is refused at the last may have had many before
        {"glb", fuzz_glb, 8 * mib},
        {"png", fuzz_png, mib},
        {"exr", fuzz_exr, 48 * mib},  // OpenEXR packs up to 256 lines at once, of a picture of one line, too
        {"picture", fuzz_picture, 4 * mib},
        {"toml", fuzz_toml, mib},
        {"array", fuzz_array, mib},
    };
    return list;
}

}  // namespace plumb::fuzz
