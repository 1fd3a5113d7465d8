// Lists of camera views, which experiments render one after the other: TOML, one [[camera]] a view. See io/README.md.
//
//     [[camera]]
//     scene = "rooms:20000:1"    # a scene file beside the list, or NAME[:TRIANGLES[:SEED]] of a generated scene
//     name = "rooms_01"
//     position = [1, 1.6, 2]     # m
//     look_at = [0, 1.2, 0]
//     up = [0, 1, 0]
//     fov_y_deg = 60
//     exposure = 1.5             # of the tone curve; whoever renders chooses it otherwise
//     frame = 12                 # of an animated scene: the pose of all but its camera
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/scene.h"

namespace plumb::io {

struct ListedCamera {
    std::string scene;
    std::string name;        // 1 to 64 letters, digits, _ or -: files are named after it
    glm::dvec3 position{0};  // m, world
    glm::dvec3 look_at{0};
    glm::dvec3 up{0, 1, 0};
    double fov_y_deg = 45;
    std::optional<double> exposure;
    std::optional<int> frame;
};

struct CameraList {
    std::string path;     // of its file: scenes are found beside it
    std::string comment;  // lines that the file opens with: how it was made
    std::vector<ListedCamera> cameras;
};

inline constexpr std::size_t max_listed_cameras = 10'000;

// Throws InputError with file, line and cause. The scenes themselves are not opened.
CameraList read_camera_list(const std::string& path);

// What read_camera_list() reads again to the last bit.
std::string camera_list_text(const CameraList& list);

// Whether a list's (or a command line's) word for a scene is a file, not the name of a generated one.
bool is_scene_file(const std::string& scene);

// The scene by the list's word for it. Throws InputError.
Scene load_listed_scene(const std::string& list_path, const std::string& scene,
                        const std::vector<std::string>& method_tables);

// The scene as the view shows it: its camera, with the scene's own near, far and reversed_z, and its frame's pose.
// Throws InputError that names list and view for a camera without a direction.
Scene scene_of(const CameraList& list, const ListedCamera& listed, const Scene& loaded);

}  // namespace plumb::io
