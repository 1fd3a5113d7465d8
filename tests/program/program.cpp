#include "tests/program/program.h"

#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "io/image_file.h"
#include "tests/program/run_until.h"

namespace plumb::program {

namespace fs = std::filesystem;

namespace {

std::string cache = PLUMB_BINARY_DIR "/program_tests/cache";

[[noreturn]] void execute(const std::vector<std::string>& arguments) {
    std::vector<char*> argv;
    std::string program = PLUMB_PROGRAM;
    argv.push_back(program.data());
    std::vector<std::string> copies = arguments;
    for (std::string& argument : copies) argv.push_back(argument.data());
    argv.push_back(nullptr);
    setenv("PLUMB_CACHE", cache.c_str(), 1);
    // Who runs the tests in the background may have Ctrl-C ignored.
    signal(SIGINT, SIG_DFL);
    signal(SIGTERM, SIG_DFL);
    execv(PLUMB_PROGRAM, argv.data());
    _exit(127);
}

int exit_code(pid_t child) {
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

struct Streams {
    std::string out = PLUMB_BINARY_DIR "/test_program.out." + std::to_string(getpid());
    std::string err = out + ".err";

    // There before the child is: it may be killed before it opens them.
    Streams() {
        for (const std::string& name : {out, err}) std::ofstream file(name);
    }
    void attach() const {
        dup2(open("/dev/null", O_RDONLY), 0);
        dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644), 1);
        dup2(open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644), 2);
    }
    Result result(int code) const {
        Result r{code, read(out), read(err)};
        fs::remove(out);
        fs::remove(err);
        return r;
    }
};

}  // namespace

void set_cache(const std::string& folder) { cache = folder; }

Result run(const std::vector<std::string>& arguments, const std::string& folder) {
    const Streams streams;
    const pid_t child = fork();
    if (child == 0) {
        streams.attach();
        if (chdir(folder.c_str()) != 0) _exit(127);
        execute(arguments);
    }
    return streams.result(exit_code(child));
}

Result render(const std::string& scene, const std::string& out, Words more) {
    more.insert(more.begin(), {"render", scene, "-o", out});
    const Result r = run(more);
    INFO(r.out << r.err);
    REQUIRE(r.exit == 0);
    CHECK(r.err.empty());
    return r;
}

Result run_on_terminal(const std::vector<std::string>& arguments) {
    winsize size{24, 80, 0, 0};
    int terminal = -1;
    const pid_t child = forkpty(&terminal, nullptr, nullptr, &size);
    if (child == 0) execute(arguments);
    Result r;
    if (child < 0) {
        r.exit = no_terminal;
        return r;
    }
    char buffer[4096];
    for (ssize_t n; (n = ::read(terminal, buffer, sizeof buffer)) > 0;) r.out.append(buffer, std::size_t(n));
    close(terminal);
    r.exit = exit_code(child);
    return r;
}

Result run_and_signal(const std::vector<std::string>& arguments, int signal, const std::string& folder,
                      const std::string& prefix) {
    const Streams streams;
    const pid_t child = fork();
    if (child == 0) {
        streams.attach();
        execute(arguments);
    }
    bool seen = false;
    for (int i = 0; i < 20000 && !seen; ++i) {
        std::error_code error;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
            seen |= entry.path().filename().string().rfind(prefix, 0) == 0;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    REQUIRE(seen);
    REQUIRE(kill(child, signal) == 0);
    return streams.result(exit_code(child));
}

Result run_and_kill(const std::vector<std::string>& arguments, double seconds) {
    return run_and_kill(arguments, seconds, [] { return true; });
}

Result run_and_kill(const std::vector<std::string>& arguments, double seconds, const std::function<bool()>& reached) {
    const Streams streams;
    const pid_t child = fork();
    if (child == 0) {
        streams.attach();
        execute(arguments);
    }
    siginfo_t ended = {};
    while (!reached() && ended.si_pid == 0) {
        REQUIRE(waitid(P_PID, id_t(child), &ended, WEXITED | WNOHANG | WNOWAIT) == 0);
        std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    kill(child, SIGKILL);
    return streams.result(exit_code(child));
}

Result run_on_full_disk(const std::vector<std::string>& arguments, std::uint64_t bytes) {
    const Streams streams;
    const pid_t child = fork();
    if (child == 0) {
        streams.attach();
        // A write beyond the limit is an error then, as it is on a full disk.
        signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{bytes, bytes};
        if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(127);
        execute(arguments);
    }
    return streams.result(exit_code(child));
}

Result run_within(const std::vector<std::string>& arguments, std::uint64_t bytes) {
    const Streams streams;
    const pid_t child = fork();
    if (child == 0) {
        streams.attach();
        const rlimit limit{bytes, bytes};
        if (setrlimit(RLIMIT_AS, &limit) != 0) _exit(127);
        execute(arguments);
    }
    return streams.result(exit_code(child));
}

std::string fresh_folder(const std::string& name) {
    const std::string folder = PLUMB_BINARY_DIR "/program_tests/" + name;
    fs::remove_all(folder);
    fs::create_directories(folder);
    return folder;
}

void write(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

std::string read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    INFO(path);
    REQUIRE(file.good());
    return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> files_in(const std::string& folder) {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(folder).string());
    std::sort(names.begin(), names.end());
    return names;
}

std::string small_scene(const std::string& folder, const std::string& frame_size) {
    REQUIRE(run({"make-scene", "cornell", "-o", folder}).exit == 0);
    const std::string scene = folder + "/small.toml";
    write(scene, "seed = 3\n[frame]\nsize = " + frame_size + R"(
[camera]
position = [0, 0.995, 3.934]
look_at = [0, 0.995, 0]
fov_y_deg = 39.3077
[[mesh]]
file = "cornell.obj"
[[light]]
name = "key"
type = "spot"
position = [0, 1.97, 0]
direction = [0, -1, 0]
cone_deg = [55, 60]
intensity = [10, 10, 10]
rsm_size = 48
[[light]]
name = "sun"
type = "directional"
direction = [0.1, -0.3, -1]
intensity = [1, 0.5, 0.25]
rsm_size = 32
[[light]]
name = "lamp"
type = "spot"
position = [0, 1, 1]
direction = [0, 0, -1]
cone_deg = [20, 30]
intensity = [5, 5, 5]
rsm_size = 16
on = false
[indirect]
blur = "none"
[shadow]
mode = "hard"
test = "depth"
[rsm]
gather = "disc"
samples = 37
)");
    return scene;
}

void write_exr(const std::string& path, const compare::Picture& picture) {
    io::write_exr(path, picture.width, picture.height,
                  {{"color", picture.channels, picture.data.data(), int(picture.channels.size())}});
}

Words keys(const Json& object) {
    Words names;
    for (const auto& item : object.items()) names.push_back(item.key());
    return names;
}

}  // namespace plumb::program
