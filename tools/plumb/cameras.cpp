// plumb cameras: the command. cameras.h says how views are drawn.
#include "tools/plumb/cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "core/animation.h"
#include "core/error.h"
#include "gi/frame/settings.h"
#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/shared/options.h"
#include "tools/shared/outputs.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

namespace {

struct Given {
    Common common;
    std::vector<std::string> scenes;
    std::string frames, output;
    RandomViews random;
    bool is_random = false;
};

// A list's word for a scene that the command line names from the working directory.
std::string word_in_list(const std::string& scene, const std::string& list) {
    if (!io::is_scene_file(scene)) return scene;
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path file = fs::absolute(scene, error), folder = fs::absolute(list, error).parent_path();
    const fs::path relative = file.lexically_normal().lexically_relative(folder.lexically_normal());
    return relative.empty() ? file.string() : relative.generic_string();
}

std::string prefix_of(const std::string& scene) {
    std::string name = io::is_scene_file(scene) ? io::stem_of(scene) : scene;
    for (char& c : name)
        if (c == ':') c = '_';
    return file_name(name).substr(0, 56);
}

struct FrameRange {
    int first = 0, last = 0, step = 1;
};
// "A:B" or "A:B:STEP"; "A" alone is one frame.
FrameRange parse_frames(const std::string& text) {
    FrameRange range;
    char rest = 0;
    const int read = std::sscanf(text.c_str(), "%d:%d:%d%c", &range.first, &range.last, &range.step, &rest);
    if (read == 1) range.last = range.first;
    const bool colons = std::count(text.begin(), text.end(), ':') == std::max(read - 1, 0);
    if (read < 1 || read > 3 || !colons || range.first < 0 || range.last < range.first || range.step < 1 ||
        range.last > 1'000'000 || (range.last - range.first) / range.step >= int(io::max_listed_cameras))
        throw InputError("--frames " + io::printable(text) + ": expected A:B or A:B:STEP, 0 <= A <= B <= 1000000");
    return range;
}

std::vector<io::ListedCamera> recorded_views(const Scene& scene, const std::string& word, const std::string& prefix,
                                             const FrameRange& range) {
    const bool animated = is_animated(scene);
    std::vector<io::ListedCamera> views;
    for (int f = range.first; f <= range.last; f += range.step) {
        const Camera camera = animated ? scene_at(scene, f).camera : scene.camera;
        io::ListedCamera listed;
        listed.scene = word, listed.name = fmt::format("{}_{:04}", prefix, f);
        listed.position = camera.position, listed.look_at = camera.look_at, listed.up = camera.up;
        listed.fov_y_deg = camera.fov_y_deg;
        if (animated) listed.frame = f;
        views.push_back(listed);
        // What stands still is recorded once.
        if (!animated) break;
    }
    return views;
}

int run_cameras(const Given& given) {
    if (given.is_random == !given.frames.empty())
        throw InputError("cameras: expected either --random N or --frames A:B");
    given.common.run_options();
    const FrameRange range = given.is_random ? FrameRange{} : parse_frames(given.frames);
    io::CameraList list{given.output, "", {}};
    list.comment = given.is_random
                       ? fmt::format("plumb cameras {} --random {} --seed {}", fmt::join(given.scenes, " "),
                                     given.random.count, given.random.seed)
                       : fmt::format("plumb cameras {} --frames {}", fmt::join(given.scenes, " "), given.frames);
    std::set<std::string> names;
    for (const std::string& word : given.scenes) {
        const Scene scene = io::load_listed_scene("", word, frame::method_tables());
        const std::string in_list = word_in_list(word, given.output), prefix = prefix_of(word);
        if (!names.insert(prefix).second)
            throw InputError(fmt::format("cameras: scene {}: another scene's views have its name", word));
        const auto views = given.is_random ? random_views(scene, in_list, prefix, given.random)
                                           : recorded_views(scene, in_list, prefix, range);
        list.cameras.insert(list.cameras.end(), views.begin(), views.end());
    }
    if (list.cameras.size() > io::max_listed_cameras)
        throw InputError(
            fmt::format("cameras: {} views: expected at most {}", list.cameras.size(), io::max_listed_cameras));
    const std::filesystem::path path(given.output);
    Outputs outputs(path.parent_path().string());
    outputs.write(path.filename().string(),
                  [&](const std::string& at) { io::write_text(at, io::camera_list_text(list)); });
    outputs.commit();
    if (given.common.json)
        std::fputs(json_text({{"cameras", list.cameras.size()}, {"file", given.output}}).c_str(), stdout);
    else
        std::printf("%zu cameras\nwrote %s\n", list.cameras.size(), given.output.c_str());
    return success;
}

}  // namespace

void add_cameras(CLI::App& program, Action& action) {
    auto given = std::make_shared<Given>();
    CLI::App* command = program.add_subcommand("cameras", "write a list of views, drawn at random or recorded");
    command->add_option("scene", given->scenes, "scene files, or generated scenes: NAME[:TRIANGLES[:SEED]]")
        ->required()
        ->check(some_word())
        ->type_name("SCENE");
    CLI::Option* random = command->add_option("--random", given->random.count, "so many random views of each scene")
                              ->check(CLI::Range(1, int(io::max_listed_cameras)).description(""))
                              ->type_name("N");
    command->add_option("--seed", given->random.seed, "of the random views; 1 otherwise")
        ->check(CLI::Range(0u, 2147483647u).description(""))
        ->type_name("S");
    command->add_option("--frames", given->frames, "record each scene's own camera at these frames")
        ->check(some_word())
        ->type_name("A:B:STEP");
    command->add_option("-o,--output", given->output, "the list")->required()->check(some_word())->type_name("FILE");
    add_common(*command, given->common);
    command->footer(
        "A random view stands outside of solids and not near a surface, sees surface in 60 % of its pixels at least\n"
        "and lamplight in 5 %. plumb batch and plumb experiment isr take the list.");
    command->callback([given, random, &action] {
        given->is_random = random->count() > 0;
        action = [=] { return run_cameras(*given); };
    });
}

}  // namespace plumb::cli
