// plumb make-scene: procedural scenes, the same everywhere.
#include "io/make_scene.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/outputs.h"
#include "tools/plumb/reports.h"

namespace plumb::cli {

namespace {

// The file that render takes, and all that were written.
Json written_json(const std::vector<std::string>& files) {
    const auto scene = std::find_if(files.begin(), files.end(),
                                    [](const std::string& file) { return io::extension_of(file) == "toml"; });
    return {{"scene", scene == files.end() ? Json(nullptr) : Json(*scene)}, {"files", files}};
}

}  // namespace

void add_make_scene(CLI::App& program, Action& action) {
    struct Given {
        Common common;
        std::string name, folder = "out";
        int triangles = 0;
    };
    auto given = std::make_shared<Given>();
    CLI::App* command = program.add_subcommand("make-scene", "write a procedural scene: cornell");
    command->add_option("name", given->name, "the scene's name")->required()->type_name("NAME");
    command->add_option("-o,--output", given->folder, "folder for what is written; \"out\" otherwise")
        ->type_name("DIR");
    CLI::Option* triangles =
        command->add_option("--triangles", given->triangles, "about how many, for scenes that can have more or fewer")
            ->check(CLI::Range(1, 1 << 30).description(""))
            ->type_name("N");
    add_common(*command, given->common);
    command->callback([given, triangles, &action] {
        action = [=] {
            given->common.run_options();
            if (triangles->count() > 0)
                throw InputError("--triangles: the scene '" + given->name + "' has no adjustable count");
            Outputs outputs(given->folder);
            outputs.write("", [&](const std::string& folder) { io::make_scene(given->name, folder); });
            outputs.commit();
            if (given->common.json) {
                std::fputs(json_text(written_json(outputs.files())).c_str(), stdout);
                return int(success);
            }
            for (const std::string& file : outputs.files()) std::printf("wrote %s\n", file.c_str());
            return int(success);
        };
    });
}

}  // namespace plumb::cli
