#include "tools/shared/batch_pov.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>

#include "core/error.h"
#include "io/file.h"
#include "io/image_file.h"

extern char** environ;

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

// A folder that goes with its holder.
struct Scratch {
    std::string path;
    Scratch() {
        path = (fs::temp_directory_path() / "plumb-pov-XXXXXX").string();
        if (!mkdtemp(path.data()))
            throw InputError(path, "", std::string("cannot make this folder: ") + strerror(errno));
    }
    ~Scratch() {
        std::error_code error;
        fs::remove_all(path, error);
    }
};

std::string last_line(const std::string& log) {
    std::error_code error;
    if (!fs::exists(log, error)) return "";
    std::string text = io::read_text(log), line;
    for (std::size_t from = 0; from < text.size();) {
        const std::size_t end = std::min(text.find('\n', from), text.size());
        if (end > from && text.find_first_not_of(" \r", from) < end) line = text.substr(from, end - from);
        // povray names the error before it says goodbye.
        if (line.find("rror:") != std::string::npos) break;
        from = end + 1;
    }
    return io::printable(line, 200);
}

}  // namespace

double run_povray(const std::string& script, const std::string& picture, glm::ivec2 size, const std::string& log) {
    std::vector<std::string> words = io::povray_command(script, picture, size);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    const auto start = std::chrono::steady_clock::now();
    pid_t pid = 0;
    const int failed = posix_spawnp(&pid, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed) throw InputError(fmt::format("cannot run {}: {}", words[0], std::strerror(failed)));
    int status = 0;
    while (waitpid(pid, &status, 0) < 0)
        if (errno != EINTR) throw InputError(fmt::format("{}: lost: {}", words[0], std::strerror(errno)));
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw InputError(fmt::format("{} failed on {}: {}", words[0], io::shown(script), last_line(log)));
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

PovPicture pov_picture(const Scene& scene, glm::ivec2 size, io::PovPreset preset) {
    const Scratch scratch;
    const std::string script = scratch.path + "/view.pov", picture = scratch.path + "/view.exr";
    io::PovOptions options;
    options.preset = preset, options.size = size;
    io::write_pov(script, scene, options);
    PovPicture made;
    made.seconds = run_povray(script, picture, size, scratch.path + "/log");
    made.radiance = read_radiance(picture, size);
    return made;
}

Image4 read_radiance(const std::string& path, glm::ivec2 size) {
    const io::FloatPicture picture = io::read_picture(path);
    const auto rgb = compare::linear_rgb(picture, compare::Encoding::hdr);
    if (!rgb) throw InputError(io::shown(path), "", "expected a picture with red, green and blue");
    if (picture.width != size.x || picture.height != size.y)
        throw InputError(
            io::shown(path), "",
            fmt::format("{} x {} pixels: expected {} x {}", picture.width, picture.height, size.x, size.y));
    Image4 image(size.x, size.y);
    for (std::size_t i = 0; i < image.size(); ++i) image.texels[i] = glm::vec4(glm::vec3(rgb->texels[i]), 1);
    return image;
}

}  // namespace plumb::cli
