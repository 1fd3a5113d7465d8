#include "io/scene_keyframes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/animation.h"
#include "core/error.h"
#include "core/nearest_known.h"
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
        poses_.push_back({frame, keyframe.place(), "keyframe"});
        if (const toml::table* camera = keyframe.table("camera")) read_camera(*camera);
        if (const toml::table* lights = keyframe.table("light")) read_lights(*lights);
        if (const toml::table* meshes = keyframe.table("mesh")) read_meshes(*meshes);
        keyframe.finish();
    }

    // One a thing, after all keyframes.
    void read_motion(const toml::table& table) {
        TomlReader reader(table, path_, "[[motion]]");
        const int things = reader.has("mesh") + reader.has("light") + reader.has("camera");
        if (things != 1) reader.fail("mesh", "expected one of mesh, light and camera");
        const Motion motion = read_rates(reader);
        if (reader.has("mesh")) {
            move_mesh(reader, motion);
        } else if (reader.has("light")) {
            move_light(reader, motion);
        } else {
            if (!reader.flag("camera", true)) reader.fail("camera", "expected true, or no camera here");
            move_camera(reader, motion);
        }
        reader.finish();
        poses_.push_back({motion.start + 1, reader.place()});
    }

    // A pose that cannot be is found here where it is one of the file's own.
    void finish() {
        for (const Pose& pose : poses_) {
            try {
                scene_ = scene_at(std::move(scene_), pose.frame);
            } catch (const InputError& e) {
                throw InputError(fmt::format("{}: [[{}]] {}", pose.place, pose.of, e.what()));
            }
        }
        scene_ = scene_at(std::move(scene_), 0);
    }

  private:
    struct Pose {
        double frame;
        std::string place;
        const char* of = "motion";
    };

    // Where a name of a thing stands, for messages.
    struct Named {
        std::string place, table;
    };

    static Motion read_rates(TomlReader& reader) {
        Motion motion;
        motion.start = reader.number("start", 0, 0, last_frame);
        if (reader.has("bezier")) {
            motion.bezier = reader.vectors("bezier", 2, 64);
            for (const glm::dvec3& p : motion.bezier)
                for (int c = 0; c < 3; ++c)
                    if (std::fabs(p[c]) > 1e30) reader.fail("bezier", "expected coordinates of -1e30 to 1e30");
            if (!reader.has("speed")) reader.fail("speed", "is missing: the part of the curve that a frame takes");
            motion.speed = reader.number("speed", 0, 0, 1);
            motion.end = PathEnd(reader.choice("end", 0, {"hold", "repeat", "swing"}));
        } else {
            for (const char* key : {"speed", "end"})
                if (reader.has(key)) reader.fail(key, "stands without a bezier");
        }
        motion.translate = reader.vector("translate", glm::dvec3(0), -1e20, 1e20);
        if (const auto turn = read_turn(reader, "turn_deg")) motion.turn_deg = turn->angle_deg, motion.axis = turn->axis;
        if (motion.empty()) reader.fail("bezier", "expected bezier, translate or turn_deg that moves something");
        return motion;
    }

    // The tracks that a rate starts from: a thing without keys starts where it is.
    static void begin(Track& track, const glm::dvec3& own) {
        if (track.empty()) track.push_back({0, own});
    }
    void require_alone(TomlReader& reader, const Motion& before, const Motion& motion, const Track& track, const char* key) {
        if (!before.empty()) reader.fail("bezier", "another [[motion]] moves the same");
        if (!motion.bezier.empty() && !track.empty())
            reader.fail("bezier", fmt::format("keyframes give \"{}\"; expected one or the other", key));
    }

    void move_mesh(TomlReader& reader, const Motion& motion) {
        MeshTracks& tracks = tracks_of(reader.word("mesh", ""), {reader.place("mesh"), "[[motion]]"});
        require_alone(reader, tracks.motion, motion, tracks.translate, "translate");
        if (reader.has("pivot")) {
            const glm::dvec3 pivot = reader.vector("pivot", {});
            if (has_keys(tracks) && pivot != tracks.pivot) reader.fail("pivot", "is another one than the keyframes'");
            tracks.pivot = pivot;
        }
        tracks.motion = motion;
    }

    void move_light(TomlReader& reader, const Motion& motion) {
        std::vector<std::string> names;
        for (const Light& light : scene_.lights) names.push_back(light.name);
        const std::string name = reader.word("light", "");
        const auto at = std::find(names.begin(), names.end(), name);
        if (at == names.end()) fail_unknown("light", name, {reader.place("light"), "[[motion]]"}, names);
        const Light& light = scene_.lights[std::size_t(at - names.begin())];
        LightTracks& tracks = tracks_of(int(at - names.begin()));
        require_alone(reader, tracks.motion, motion, tracks.position, "position");
        if (motion.bezier.empty()) begin(tracks.position, glm::dvec3(light.position));
        if (motion.turn_deg != 0) begin(tracks.direction, glm::dvec3(light.direction));
        tracks.motion = motion;
    }

    void move_camera(TomlReader& reader, const Motion& motion) {
        CameraTracks& tracks = scene_.animation.camera;
        if (motion.turn_deg != 0) reader.fail("turn_deg", "a camera turns by keyframes of what it looks at");
        require_alone(reader, tracks.motion, motion, tracks.position, "position");
        if (motion.bezier.empty()) begin(tracks.position, scene_.camera.position);
        begin(tracks.look_at, scene_.camera.look_at);
        tracks.motion = motion;
    }

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
            if (at == names.end()) fail_unknown("light", name, named_at(key, "[keyframe.light]"), names);
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
            MeshTracks& tracks = tracks_of(name, named_at(key, "[keyframe.mesh]"));
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
    MeshTracks& tracks_of(const std::string& name, const Named& at) {
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
                        throw InputError(fmt::format("{}: {} \"{}\" has mesh \"{}\", which \"{}\" moves already", at.place,
                                                     at.table, printable(name), printable(mesh.name), printable(other.name)));
            mesh.dynamic = true;
            tracks.meshes.push_back({int(m), mesh.transform});
        }
        if (tracks.meshes.empty()) {
            std::vector<std::string> names;
            for (const NamedMesh& known : named_) names.push_back(known.name);
            for (const Mesh& mesh : scene_.meshes) names.push_back(mesh.name);
            fail_unknown("mesh", name, at, names);
        }
        tracks.pivot = glm::dvec3(tracks.meshes[0].own[3]);
        for (const NamedMesh& known : named_)
            if (known.name == name) tracks.pivot = known.origin;
        return scene_.animation.meshes.emplace_back(std::move(tracks));
    }

    Named named_at(const toml::key& key, const char* table) const {
        return {fmt::format("{}: line {}", shown(path_), key.source().begin.line), table};
    }
    [[noreturn]] static void fail_unknown(const char* what, const std::string& name, const Named& at,
                                          const std::vector<std::string>& names) {
        const std::string unknown = fmt::format("{}: {} unknown {} '{}'", at.place, at.table, what, printable(name));
        if (names.empty()) throw InputError(unknown + "; the scene has none");
        throw InputError(unknown + shown(nearest_known(name, names)));
    }

    const std::string& path_;
    const std::vector<NamedMesh>& named_;
    Scene& scene_;
    std::vector<Pose> poses_;
};

}  // namespace

void read_keyframes(TomlReader& top, const std::string& path, const std::vector<NamedMesh>& named, Scene& scene) {
    const std::vector<const toml::table*> keyframes = top.tables("keyframe");
    const std::vector<const toml::table*> motions = top.tables("motion");
    if (keyframes.empty() && motions.empty()) return;
    KeyframeReader reader(path, named, scene);
    for (const toml::table* keyframe : keyframes) reader.read(*keyframe);
    for (const toml::table* motion : motions) reader.read_motion(*motion);
    reader.finish();
}

}  // namespace plumb::io
