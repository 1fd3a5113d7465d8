// plumb pov: a scene as a script of POV-Ray, and how to render it.
#include "io/pov.h"

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gi/frame/isr.h"
#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/shared/outputs.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"

namespace plumb::cli {
namespace {

struct Given {
    SceneOptions scene;
    Common common;
    std::string file, preset = "physical";
    bool shadowless = false;
    io::PovOptions options;
};

io::PovPreset parse_preset(const std::string& text) {
    constexpr const char* names[] = {"published", "physical", "direct"};
    for (int i = 0; i < 3; ++i)
        if (text == names[i]) return io::PovPreset(i);
    throw InputError("--preset " + io::printable(text) + ": expected published, physical or direct");
}

int write_script(Given given) {
    given.common.run_options();
    given.options.preset = parse_preset(given.preset);
    const Scene scene = load(given.scene);
    given.options.size = scene.frame_size;
    given.options.shadowless = given.shadowless || !frame::casts_shadows(settings_of(scene, given.scene));
    const std::filesystem::path path(given.file.empty() ? io::stem_of(given.scene.file) + ".pov" : given.file);
    const std::filesystem::path folder = path.parent_path();
    Outputs outputs(folder.empty() ? "." : folder.string());
    outputs.write(path.filename().string(),
                  [&](const std::string& at) { io::write_pov(at, scene, given.options); });
    outputs.commit();
    std::filesystem::path picture = path;
    picture.replace_extension(".exr");
    const std::string line = io::povray_command_line(path.string(), picture.string(), given.options.size);
    const std::vector<std::string> notes = io::pov_notes(scene, given.options);
    if (given.common.json) {
        std::fputs(json_text({{"script", path.string()},
                              {"picture", picture.string()},
                              {"command", io::povray_command(path.string(), picture.string(), given.options.size)},
                              {"notes", notes}})
                       .c_str(),
                   stdout);
        return success;
    }
    print_notes(scene);
    for (const std::string& note : notes) std::printf("note: %s\n", note.c_str());
    std::printf("wrote %s\nradiance, W/(m2 sr), by\n    %s\n", path.string().c_str(), line.c_str());
    return success;
}

}  // namespace

void add_pov(CLI::App& program, Action& action) {
    auto given = std::make_shared<Given>();
    CLI::App* command =
        program.add_subcommand("pov", "write a scene as a script of POV-Ray, and say how to render it to radiance");
    command->add_option("scene", given->scene.file, "the scene: .toml, or a bare .obj, .gltf or .glb")
        ->required()
        ->type_name("SCENE");
    command->add_option("-o,--output", given->file, "the script; the scene's name with .pov otherwise")
        ->check(some_word())
        ->type_name("FILE");
    add_size_option(*command, given->scene);
    command->add_option("--preset", given->preset,
                        "published (ISR table 1), physical (otherwise), or direct (no light between surfaces)")
        ->check(some_word())
        ->type_name("P");
    command->add_option("--bounces", given->options.bounces, "of preset physical, 1 to 20; 8 otherwise")
        ->check(number_within(1, 20))
        ->type_name("N");
    command->add_option("--samples", given->options.samples, "rays a gather of preset physical, 1 to 1600; 400 otherwise")
        ->check(number_within(1, 1600))
        ->type_name("N");
    command->add_flag("--shadowless", given->shadowless,
                      "no lamp casts a shadow, as where the scene's settings have none (isr.mode F3, F5)");
    add_common(*command, given->common);
    command->callback([given, &action] { action = [=] { return write_script(*given); }; });
}

}  // namespace plumb::cli
