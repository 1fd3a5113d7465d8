#include "io/scene_keyframes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/animation.h"
#include "core/error.h"
#include "io/file.h"
#include "io/scene_parts.h"

namespace plumb::io {
namespace {

constexpr double last_frame = 1e6;

class KeyframeReader {
  public:
    KeyframeReader(const std::string& path, const std::vector<NamedMesh>& named, Scene& scene)
        : path_(path), named_(named), scene_(scene) {}

    void read(const toml::table& table) {
        TomlReader keyframe(table, path_, "[[keyframe]]");
        if (!keyframe.has("frame")) keyframe.fail("frame", "is missing");
        const double frame = keyframe.number("frame", 0, 0, last_frame);
        if (!poses_.empty() && !(frame > poses_.back().frame))
            keyframe.fail("frame", fmt::format("expected above that of the keyframe before, {}", poses_.back().frame));
        poses_.push_back({frame, keyframe.place()});
        if (const toml::table* camera = keyframe.table("camera")) read_camera(*camera);
        if (const toml::table* lights = keyframe.table("light")) read_lights(*lights);
        if (const toml::table* meshes = keyframe.table("mesh")) read_meshes(*meshes);
        keyframe.finish();
    }

    // A pose that cannot be is found here where it is one of the file's own.
    void finish() {
        for (const Pose& pose : poses_) {
            try {
                scene_ = scene_at(std::move(scene_), pose.frame);
            } catch (const InputError& e) {
                throw InputError(pose.place + ": [[keyframe]] " + e.what());
            }
        }
        scene_ = scene_at(std::move(scene_), 0);
    }

  private:
    struct Pose {
        double frame;
        std::string place;
    };

    void add(Track& track, const glm::dvec3& value) { track.push_back({poses_.back().frame, value}); }

    void read_camera(const toml::table& table) {
        TomlReader camera(table, path_, "[keyframe.camera]");
        CameraTracks& tracks = scene_.animation.camera;
        const auto vector = [&](const char* key, Track& track) {
            if (camera.has(key)) add(track, camera.vector(key, {}));
        };
        vector("position", tracks.position), vector("look_at", tracks.look_at), vector("up", tracks.up);
        if (camera.has("fov_y_deg")) add(tracks.fov_y_deg, glm::dvec3(camera.number("fov_y_deg", 0), 0, 0));
        camera.finish();
    }

    void read_lights(const toml::table& table) {
        std::vector<std::string> names;
        for (const Light& light : scene_.lights) names.push_back(light.name);
        TomlReader lights(table, path_, "[keyframe.light]");
        for (const auto& [key, value] : table) {
            const std::string name(key.str());
            const auto at = std::find(names.begin(), names.end(), name);
            if (at == names.end()) fail_unknown("light", key, names);
            const toml::table* its = lights.table(name);
            TomlReader reader(*its, path_, "[keyframe.light." + name + "]");
            read_light(reader, tracks_of(int(at - names.begin())));
            reader.finish();
        }
    }

    void read_light(TomlReader& reader, LightTracks& tracks) {
        if (reader.has("position")) add(tracks.position, reader.vector("position", {}, -1e30, 1e30));
        if (reader.has("direction")) {
            const glm::dvec3 d = reader.vector("direction", {}, -1e30, 1e30);
            const double length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
            if (!(length > 0)) reader.fail("direction", "has no length");
            add(tracks.direction, d / length);
        }
        if (const auto cone = read_cone(reader)) add(tracks.cone_deg, glm::dvec3(*cone, 0));
        if (reader.has("intensity")) add(tracks.intensity, reader.vector("intensity", {}, 0, 3e38));
        if (reader.has("on")) add(tracks.on, glm::dvec3(reader.flag("on", true), 0, 0));
    }

    LightTracks& tracks_of(int light) {
        for (LightTracks& tracks : scene_.animation.lights)
            if (tracks.light == light) return tracks;
        LightTracks& tracks = scene_.animation.lights.emplace_back();
        tracks.light = light;
        return tracks;
    }

    void read_meshes(const toml::table& table) {
        TomlReader meshes(table, path_, "[keyframe.mesh]");
        for (const auto& [key, value] : table) {
            const std::string name(key.str()), shown = "[keyframe.mesh.\"" + printable(name) + "\"]";
            MeshTracks& tracks = tracks_of(name, key);
            const toml::table* its = meshes.table(name);
            TomlReader reader(*its, path_, shown);
            if (reader.has("pivot")) {
                // One point for the whole motion: what turns about a moving point is moved by that as well.
                const glm::dvec3 pivot = reader.vector("pivot", {});
                if (has_keys(tracks) && pivot != tracks.pivot)
                    reader.fail("pivot", "expected in the first keyframe of this mesh, and the same in all");
                tracks.pivot = pivot;
            }
            if (reader.has("translate")) add(tracks.translate, reader.vector("translate", {}));
            if (reader.has("rotate_deg")) add(tracks.rotate_deg, reader.vector("rotate_deg", {}));
            if (reader.has("scale")) add(tracks.scale, read_scale(reader));
            reader.finish();
        }
    }

    static bool has_keys(const MeshTracks& tracks) {
        return !tracks.translate.empty() || !tracks.rotate_deg.empty() || !tracks.scale.empty();
    }

    // A name stands for the meshes of that name, and for those whose names go on with a slash.
    MeshTracks& tracks_of(const std::string& name, const toml::key& key) {
        for (MeshTracks& tracks : scene_.animation.meshes)
            if (tracks.name == name) return tracks;
        MeshTracks tracks;
        tracks.name = name;
        for (std::size_t m = 0; m < scene_.meshes.size(); ++m) {
            Mesh& mesh = scene_.meshes[m];
            if (mesh.name != name && mesh.name.compare(0, name.size() + 1, name + "/") != 0) continue;
            for (const MeshTracks& other : scene_.animation.meshes)
                for (const MovingMesh& moving : other.meshes)
                    if (moving.mesh == int(m))
                        fail(key, fmt::format("[keyframe.mesh] \"{}\" has mesh \"{}\", which \"{}\" moves already",
                                              printable(name), printable(mesh.name), printable(other.name)));
            mesh.dynamic = true;
            tracks.meshes.push_back({int(m), mesh.transform});
        }
        if (tracks.meshes.empty()) {
            std::vector<std::string> names;
            for (const NamedMesh& known : named_) names.push_back(known.name);
            for (const Mesh& mesh : scene_.meshes) names.push_back(mesh.name);
            fail_unknown("mesh", key, names);
        }
        tracks.pivot = glm::dvec3(tracks.meshes[0].own[3]);
        for (const NamedMesh& known : named_)
            if (known.name == name) tracks.pivot = known.origin;
        return scene_.animation.meshes.emplace_back(std::move(tracks));
    }

    [[noreturn]] void fail(const toml::key& key, const std::string& cause) const {
        throw InputError(fmt::format("{}: line {}: {}", shown(path_), key.source().begin.line, cause));
    }
    [[noreturn]] void fail_unknown(const char* what, const toml::key& key, const std::vector<std::string>& names) const {
        const std::string name(key.str()), place = fmt::format("[keyframe.{}] unknown {} '{}'", what, what, printable(name));
        if (names.empty()) fail(key, fmt::format("{}; the scene has none", place));
        fail(key, fmt::format("{}; the nearest known one is '{}'", place, printable(nearest_name(name, names))));
    }

    const std::string& path_;
    const std::vector<NamedMesh>& named_;
    Scene& scene_;
    std::vector<Pose> poses_;
};

}  // namespace

void read_keyframes(TomlReader& top, const std::string& path, const std::vector<NamedMesh>& named, Scene& scene) {
    const std::vector<const toml::table*> keyframes = top.tables("keyframe");
    if (keyframes.empty()) return;
    KeyframeReader reader(path, named, scene);
    for (const toml::table* keyframe : keyframes) reader.read(*keyframe);
    reader.finish();
}

}  // namespace plumb::io
