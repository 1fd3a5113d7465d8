#include "io/make_scene.h"

#include "core/error.h"
#include "core/fields.h"
#include "io/cornell.h"
#include "io/file.h"

namespace plumb::io {

std::vector<std::string> scene_names() { return {"cornell"}; }

std::string make_scene(const std::string& name, const std::string& folder) {
    if (name != "cornell")
        throw InputError("make-scene: unknown scene \"" + printable(name) + "\"; the nearest known one is \"" +
                         nearest_name(name, scene_names()) + "\"");
    make_folder(folder);
    const std::string scene = beside(folder + "/", "cornell.toml");
    write_text(beside(scene, "cornell.obj"), cornell_obj());
    write_text(beside(scene, "cornell.mtl"), cornell_mtl());
    write_text(scene, cornell_toml());
    return scene;
}

}  // namespace plumb::io
