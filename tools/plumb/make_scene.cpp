// plumb make-scene: procedural scenes, the same everywhere.
#include "io/make_scene.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/shared/outputs.h"
#include "tools/shared/reports.h"

namespace plumb::cli {
namespace {

struct Given {
    Common common;
    std::string name, folder = "out";
    std::int64_t triangles = 0;
    std::uint32_t seed = 1;
    bool list = false;
};

int list_scenes(bool json) {
    const std::vector<io::SceneSummary> scenes = io::scene_summaries();
    if (json) {
        Json list = Json::array();
        for (const io::SceneSummary& s : scenes)
            list.push_back({{"name", s.name},
                            {"summary", s.summary},
                            {"triangles", s.triangles},
                            {"adjustable", s.adjustable}});
        std::fputs(json_text({{"scenes", list}}).c_str(), stdout);
        return success;
    }
    for (const io::SceneSummary& s : scenes)
        std::printf("%-14s%11lld triangles%s  %s\n", s.name.c_str(), static_cast<long long>(s.triangles),
                    s.adjustable ? "*" : " ", s.summary.c_str());
    std::printf("* about as many as --triangles asks for\n");
    return success;
}

int write_scene(const Given& given) {
    Outputs outputs(given.folder);
    io::MadeScene made;
    outputs.write("", [&](const std::string& folder) {
        made = io::make_scene(given.name, folder, {given.triangles, given.seed});
    });
    outputs.commit();
    const std::vector<std::string>& files = outputs.files();
    if (given.common.json) {
        const auto scene = std::find_if(files.begin(), files.end(),
                                        [](const std::string& file) { return io::extension_of(file) == "toml"; });
        // The file that render takes, all that were written, and what is in them.
        std::fputs(json_text({{"scene", scene == files.end() ? Json(nullptr) : Json(*scene)},
                              {"files", files},
                              {"meshes", made.meshes},
                              {"triangles", made.triangles},
                              {"vertices", made.vertices},
                              {"materials", made.materials},
                              {"textures", made.textures},
                              {"lights", made.lights}})
                       .c_str(),
                   stdout);
        return success;
    }
    const auto n = [](std::int64_t count) { return std::to_string(count); };
    std::printf("%s: %s triangles, %s vertices, %s meshes, %s materials, %s textures, %s lights\n", given.name.c_str(),
                n(made.triangles).c_str(), n(made.vertices).c_str(), n(made.meshes).c_str(), n(made.materials).c_str(),
                n(made.textures).c_str(), n(made.lights).c_str());
    for (const std::string& file : files) std::printf("wrote %s\n", file.c_str());
    return success;
}

}  // namespace

void add_make_scene(CLI::App& program, Action& action) {
    auto given = std::make_shared<Given>();
    CLI::App* command = program.add_subcommand("make-scene", "write a procedural scene, or list all of them");
    command->add_option("name", given->name, "the scene's name; without one, all are listed")->type_name("NAME");
    command->add_option("-o,--output", given->folder, "folder for what is written; \"out\" otherwise")
        ->type_name("DIR");
    CLI::Option* triangles =
        command->add_option("--triangles", given->triangles, "about how many, for scenes that can have more or fewer")
            ->check(CLI::Range(1, 1 << 30).description(""))
            ->type_name("N");
    CLI::Option* seed = command->add_option("--seed", given->seed, "another variant, for scenes that have some")
                            ->check(CLI::Range(0u, 2147483647u).description(""))
                            ->type_name("S");
    command->add_flag("--list", given->list, "list the scenes with their numbers of triangles");
    add_common(*command, given->common);
    command->callback([given, triangles, seed, &action] {
        action = [=] {
            given->common.run_options();
            if (given->list || given->name.empty()) return list_scenes(given->common.json);
            if (given->name == "cornell" && (triangles->count() > 0 || seed->count() > 0))
                throw InputError(std::string(triangles->count() > 0 ? "--triangles" : "--seed") +
                                 ": the scene 'cornell' has no adjustable count and no variants");
            return write_scene(*given);
        };
    });
}

}  // namespace plumb::cli
