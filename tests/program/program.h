// Runs the program as its user does: arguments in; exit code, standard output and standard error out.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/compare.h"

namespace plumb::program {

using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

// The names of its members, in order.
Words keys(const Json& object);

struct Result {
    int exit = -1;  // 128 + signal if a signal ended it
    std::string out, err;
};

// $PLUMB_CACHE of every run: never the user's own. A test that looks into it sets a fresh one.
void set_cache(const std::string& folder);

// Neither stream is a terminal. `folder`: the working directory.
Result run(const std::vector<std::string>& arguments, const std::string& folder = ".");

// plumb render SCENE -o OUT and more, which has to succeed without a word on standard error.
Result render(const std::string& scene, const std::string& out, Words more = {});

// As run(), on a terminal of 80 columns; everything that it shows is in out. exit is no_terminal where the system gives no
// pseudo-terminal, as in a chroot without /dev/pts.
inline constexpr int no_terminal = -1;
Result run_on_terminal(const std::vector<std::string>& arguments);

// Sends `signal` once a file whose name starts with `prefix` is in `folder`. Fails if the program ends before.
Result run_and_signal(const std::vector<std::string>& arguments, int signal, const std::string& folder,
                      const std::string& prefix);

// Kills it (SIGKILL) after so many seconds, if it has not ended by itself: exit is 137 then.
Result run_and_kill(const std::vector<std::string>& arguments, double seconds);

// An empty folder of that name for a test to work in.
std::string fresh_folder(const std::string& name);

void write(const std::string& path, const std::string& bytes);
std::string read(const std::string& path);
std::vector<std::string> files_in(const std::string& folder);  // all levels, relative, sorted; hidden ones too

// A small Cornell box with three lights: a spot "key", a directional "sun" and a spot "lamp" that is off.
// Returns the path of its TOML file.
std::string small_scene(const std::string& folder, const std::string& frame_size = "[61, 43]");

void write_exr(const std::string& path, const compare::Picture& picture);

}  // namespace plumb::program
