#include "core/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/rotation.h"

namespace plumb {
namespace {

glm::dvec3 value_or(const Track& track, double frame, const glm::dvec3& otherwise) {
    return track.empty() ? otherwise : value_at(track, frame);
}

// a to b, equal values as they are: what rests between the two rests to the bit.
glm::dvec3 mixed(const glm::dvec3& a, const glm::dvec3& b, double share) {
    glm::dvec3 value = a;
    for (int c = 0; c < 3; ++c)
        if (a[c] != b[c]) value[c] = a[c] * (1 - share) + b[c] * share;
    return value;
}

double frames_since(const Motion& motion, double frame) { return std::max(0.0, frame - motion.start); }

// Where the tracks or the curve place something, and how far it has been moved from there.
glm::dvec3 placed(const Track& track, const Motion& motion, double frame, const glm::dvec3& otherwise) {
    const glm::dvec3 at = motion.bezier.empty() ? value_or(track, frame, otherwise)
                                                : bezier_at(motion.bezier, path_parameter(motion, frame));
    return motion.translate == glm::dvec3(0) ? at : at + frames_since(motion, frame) * motion.translate;
}

glm::dmat3 turned(const Motion& motion, double frame) {
    return rotation_about(motion.axis, frames_since(motion, frame) * motion.turn_deg);
}

// The first key after `frame`.
Track::const_iterator after(const Track& track, double frame) {
    return std::upper_bound(track.begin(), track.end(), frame, [](double f, const Key& key) { return f < key.frame; });
}

void pose_camera(const CameraTracks& tracks, double frame, Camera& camera) {
    camera.position = placed(tracks.position, tracks.motion, frame, camera.position);
    camera.look_at = value_or(tracks.look_at, frame, camera.look_at) +
                     frames_since(tracks.motion, frame) * tracks.motion.translate;
    camera.up = value_or(tracks.up, frame, camera.up);
    camera.fov_y_deg = value_or(tracks.fov_y_deg, frame, glm::dvec3(camera.fov_y_deg)).x;
    try {
        validate(camera);
    } catch (const InputError& e) {
        throw InputError(fmt::format("frame {}: {}", frame, e.what()));
    }
}

void pose_light(const LightTracks& tracks, double frame, Light& light) {
    if (!tracks.position.empty() || !tracks.motion.bezier.empty())
        light.position = glm::vec3(placed(tracks.position, tracks.motion, frame, {}));
    if (!tracks.direction.empty()) {
        // Between unit vectors: only opposite ones meet in 0.
        const glm::dvec3 d = value_at(tracks.direction, frame);
        const double length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
        if (!(length > 1e-6))
            throw InputError(fmt::format("frame {}: light \"{}\": the keyframes around it point opposite ways: expected "
                                         "one between them that says which way it turns", frame, light.name));
        light.direction = glm::vec3(tracks.motion.turn_deg == 0 ? d / length : turned(tracks.motion, frame) * (d / length));
    }
    if (!tracks.cone_deg.empty()) {
        const glm::dvec3 cone = value_at(tracks.cone_deg, frame);
        light.cone_inner_deg = float(cone.x), light.cone_outer_deg = float(cone.y);
    }
    if (!tracks.intensity.empty()) light.intensity = glm::vec3(value_at(tracks.intensity, frame));
    if (!tracks.on.empty()) light.on = step_at(tracks.on, frame).x != 0;
}

void pose_meshes(const MeshTracks& tracks, double frame, std::vector<Mesh>& meshes) {
    const glm::dvec3 scale = value_or(tracks.scale, frame, glm::dvec3(1));
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::fabs(scale[axis]) >= 1e-30))
            throw InputError(fmt::format("frame {}: mesh \"{}\": scale = [{}, {}, {}]: expected none of them 0", frame,
                                         tracks.name, scale.x, scale.y, scale.z));
    glm::dmat4 turn = rotation_deg(value_or(tracks.rotate_deg, frame, glm::dvec3(0)));
    if (tracks.motion.turn_deg != 0) turn = glm::dmat4(turned(tracks.motion, frame)) * turn;
    for (int axis = 0; axis < 3; ++axis) turn[axis] *= scale[axis];
    const glm::dvec3 move = placed(tracks.translate, tracks.motion, frame, glm::dvec3(0));
    for (const MovingMesh& moving : tracks.meshes) {
        // What does not turn is not computed: its own transform comes back to the bit.
        glm::dmat4 m = moving.own;
        if (turn != glm::dmat4(1)) {
            m[3] -= glm::dvec4(tracks.pivot, 0);
            m = turn * m;
            m[3] += glm::dvec4(tracks.pivot, 0);
        }
        m[3] += glm::dvec4(move, 0);
        meshes.at(std::size_t(moving.mesh)).transform = m;
    }
}

}  // namespace

glm::dvec3 value_at(const Track& track, double frame) {
    const auto next = after(track, frame);
    if (next == track.begin()) return track.front().value;
    const Key& a = next[-1];
    if (next == track.end() || a.frame == frame) return a.value;
    const double share = (frame - a.frame) / (next->frame - a.frame);
    return mixed(a.value, next->value, share);
}

glm::dvec3 step_at(const Track& track, double frame) {
    const auto next = after(track, frame);
    return next == track.begin() ? track.front().value : next[-1].value;
}

glm::dvec3 bezier_at(const std::vector<glm::dvec3>& points, double t) {
    std::vector<glm::dvec3> p = points;
    for (std::size_t count = p.size() - 1; count > 0; --count)
        for (std::size_t i = 0; i < count; ++i) p[i] = mixed(p[i], p[i + 1], t);
    return p.front();
}

double path_parameter(const Motion& motion, double frame) {
    const double t = frames_since(motion, frame) * motion.speed, rest = t - std::floor(t);
    if (motion.end == PathEnd::repeat) return rest;
    if (motion.end == PathEnd::swing) return std::fmod(std::floor(t), 2.0) == 0 ? rest : 1 - rest;
    return std::min(t, 1.0);
}

Scene scene_at(Scene scene, double frame) {
    const Animation& animation = scene.animation;
    if (!animation.camera.empty()) pose_camera(animation.camera, frame, scene.camera);
    for (const LightTracks& tracks : animation.lights)
        pose_light(tracks, frame, scene.lights.at(std::size_t(tracks.light)));
    for (const MeshTracks& tracks : animation.meshes) pose_meshes(tracks, frame, scene.meshes);
    return scene;
}

bool is_animated(const Scene& scene) {
    const Animation& a = scene.animation;
    return !a.camera.empty() || !a.lights.empty() || !a.meshes.empty();
}

}  // namespace plumb
