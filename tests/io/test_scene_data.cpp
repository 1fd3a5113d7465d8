// The scenes of data/scenes: each file is read; one that is generated is the scene that its comment promises.
#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>
#include <set>

#include "files.h"
#include "io/scene_file.h"
#include "io/scenes/generate.h"

using namespace plumb;
using namespace plumb::io;

namespace {

std::string text_of(const std::filesystem::path& path) {
    const auto bytes = read_bytes(path.string());
    return std::string(bytes.begin(), bytes.end());
}

}  // namespace

TEST_CASE("data/scenes: every generated scene has a file that is read", "[io][scenes]") {
    const Folder folder;
    std::set<std::string> seen;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(PLUMB_SOURCE_DIR "/data/scenes")) {
        if (entry.path().extension() != ".toml") continue;
        std::string text = text_of(entry.path());
        std::smatch name, triangles;
        if (!std::regex_search(text, name, std::regex("generate = \"(\\w+)\""))) continue;
        INFO(entry.path());
        REQUIRE(std::regex_search(text, triangles, std::regex("triangles = (\\d+)")));
        for (const GeneratedScene& scene : generated_scenes()) {
            if (name[1] != scene.name) continue;
            CHECK(std::stoll(triangles[1]) == scene.triangles);
            // As few triangles as it can be built from: the rest of the file is what is read here.
            text.replace(std::size_t(triangles.position(1)), std::size_t(triangles.length(1)),
                         std::to_string(scene.least_triangles));
        }
        // What it names beside what is generated lies beside it.
        for (const auto& beside : std::filesystem::directory_iterator(entry.path().parent_path()))
            if (beside.path().extension() == ".obj" || beside.path().extension() == ".mtl")
                folder.put(beside.path().filename().string(), text_of(beside.path()));
        const Scene s = load_scene(folder.put(entry.path().filename().string(), text),
                                   {"rsm", "ao", "reflect", "reuse", "shadow", "tonemap", "layout", "probes", "radiosity", "zbuffer"});
        CHECK(!s.meshes.empty());
        CHECK(s.frame_size.x >= 512);
        seen.insert(name[1]);
    }
    CHECK(seen.size() == generated_scenes().size());
}

TEST_CASE("data/scenes: every scene whose mesh is a file is read, and leaves nothing open but its lights", "[io]") {
    int count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(PLUMB_SOURCE_DIR "/data/scenes")) {
        if (entry.path().extension() != ".toml") continue;
        if (text_of(entry.path()).find("generate") != std::string::npos) continue;
        INFO(entry.path());
        const Scene s = load_scene(entry.path().string(), {"rsm", "ao", "reflect", "reuse", "shadow", "tonemap", "layout", "probes", "radiosity", "zbuffer"});
        CHECK(!s.meshes.empty());
        // What it is lit by: lights, what emits, or the sky.
        bool lit = !s.lights.empty() || s.environment.radiance != glm::vec3(0);
        for (const Material& m : s.materials) lit |= m.emission != glm::vec3(0);
        CHECK(lit);
        for (const std::string& note : s.notes) CHECK_THAT(note, Catch::StartsWith("no light in the file"));
        ++count;
    }
    CHECK(count >= 5);
}
