// Reflections in a frame: against a mirrored camera's picture and against mirrored rays, in maps of lights, and what may
// not change.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/camera.h"
#include "core/error.h"
#include "gi/frame/reflect_classes.h"
#include "tests/gi/keys_of.h"
#include "tests/gi/open_room.h"

using namespace plumb;
using test::has;
using test::render;
using test::same;

namespace {

using frame::MirrorClass;
using screen::March;
using screen::ReflectViews;

constexpr double pi = 3.14159265358979;

// Its floor is a mirror.
Scene room(bool with_floor = true) {
    Scene s = test::open_room({with_floor ? 1 : -1, 0.1f, 0.6f, 0.7, {64, 52}});
    s.materials.resize(2);
    s.materials[1].reflectance = glm::vec3(0.125f), s.materials[1].mirror = {0.75f, 0.5f, 0.25f};
    return s;
}

frame::Settings mirroring(ReflectViews views = ReflectViews::camera) {
    frame::Settings settings;
    settings.method = frame::Method::direct;
    settings.reflect.march = March::steps, settings.reflect.views = views, settings.reflect.step = 0.05f;
    settings.reference.rays = Rays::exact;
    return settings;
}

double length(const glm::vec3& v) { return std::sqrt(double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z); }

frame::MirrorClasses classes_of(const Scene& scene, const frame::Settings& settings, const frame::Frame& f) {
    return frame::classify_mirrors(scene, settings, f, {});
}
std::int64_t count(const frame::MirrorClasses& c, MirrorClass of) { return c.count[std::size_t(of)]; }

}  // namespace

TEST_CASE("reflect: off, a frame has no stage of it; on, mirrors add what they show", "[frame][reflect]") {
    const Scene scene = room();
    frame::Settings settings = mirroring();
    settings.reflect.march = March::off;
    CHECK_FALSE(has(frame::plan(scene, settings), "screen.mirror"));
    const frame::Frame off = render(scene, settings);
    CHECK((off.reflect.hits.empty() && off.reflect.composed.empty() && off.reflect.reflection.empty()));

    const frame::Frame on = render(scene, mirroring());
    CHECK(same(off.radiance, on.reflect.composed));
    const Image4& hits = on.reflect.hits.back();
    int met = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const glm::vec4 hit = hits.texels[i], l_r = on.reflect.reflection.texels[i], l = on.radiance.texels[i], l_0 = off.radiance.texels[i];
        for (int c = 0; c < 3; ++c) CHECK(l[c] == l_0[c] + l_r[c]);
        CHECK(l_r.w == (hit.w > 0 ? 1.0f : 0.0f));
        if (hit.w == 0) continue;
        ++met;
        CHECK(on.gbuffer.position.texels[i].y < 1e-6f);  // of the floor
        const glm::vec4 shown = off.radiance(int(hit.x), int(hit.y));
        for (int c = 0; c < 3; ++c) CHECK(l_r[c] == scene.materials[1].mirror[c] * shown[c]);
    }
    CHECK(met > 300);
}

TEST_CASE("reflect: a planar mirror shows the mirrored camera's picture", "[frame][reflect][LRA 4.2.4][analytic]") {
    Scene scene = room(), below = room(false);
    scene.frame_size = below.frame_size = {160, 130};
    below.camera.position.y *= -1, below.camera.look_at.y *= -1, below.camera.up.y *= -1;
    const frame::Settings settings = mirroring();
    frame::Settings plain = settings;
    plain.reflect.march = March::off;
    const frame::Frame f = render(scene, settings), seen = render(below, plain);
    const glm::ivec2 size = scene.frame_size;
    const View view = make_view(scene.camera, double(size.x) / size.y, scene.convention, size);
    int asked = 0, missed = 0, off = 0;
    double farthest = -1, differs = 0;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            // The mirrored camera's right is the camera's left.
            const glm::ivec2 there(size.x - 1 - x, y);
            if (f.reflect.mirror(x, y).w == 0 || seen.gbuffer.normal(there.x, there.y).w == 0) continue;
            // Where the camera itself shows that point, and not at its border.
            const glm::vec3 q(seen.gbuffer.position(there.x, there.y));
            const glm::dvec4 clip = view.world_to_clip() * glm::dvec4(glm::dvec3(q), 1);
            const glm::dvec2 at((clip.x / clip.w + 1) * 0.5 * size.x, (clip.y / clip.w + 1) * 0.5 * size.y);
            if (!(clip.w > 0 && at.x > 1 && at.y > 1 && at.x < size.x - 1 && at.y < size.y - 1)) continue;
            const glm::vec4 shown = f.gbuffer.position(int(at.x), int(at.y));
            if (shown.w == 0 || length(glm::vec3(shown) - q) > 0.012 * shown.w) continue;
            // What is known of it are depths, a texel each: not where they differ by half the thickness of 6 cm from one to the
            // next, nor at contacts.
            double step_of_depth = 0;
            for (const glm::ivec2 by : {glm::ivec2(1, 0), glm::ivec2(-1, 0), glm::ivec2(0, 1), glm::ivec2(0, -1)})
                step_of_depth = std::max(step_of_depth, std::abs(double(f.gbuffer.position(int(at.x) + by.x, int(at.y) + by.y).w) - shown.w));
            if (step_of_depth > 0.03 || q.y < 0.04f) continue;
            ++asked;
            const glm::vec4 hit = f.reflect.hits.back()(x, y);
            if (hit.w != 1) {
                ++missed;
                continue;
            }
            if (std::abs(hit.x + 0.5 - at.x) > 1.5 || std::abs(hit.y + 0.5 - at.y) > 1.5) {
                ++off;
                continue;
            }
            // Within the last halved step and the step of depth, along the ray.
            const double t = length(q - glm::vec3(f.gbuffer.position(x, y)));
            const double along = std::abs(clip.w - double(f.gbuffer.position(x, y).w)) / t;  // of depth, a metre of the ray
            farthest = std::max(farthest, std::abs(double(hit.z) - t) - (step_of_depth / along + 0.05 / 256));
            const glm::vec4 l_r = f.reflect.reflection(x, y), l = seen.radiance(there.x, there.y);
            differs += std::abs(double(l_r.x) - 0.75 * double(l.x));
        }
    INFO(asked << " asked, " << missed << " missed, " << off << " off");
    CHECK(asked > 1000);
    CHECK(missed + off <= asked / 200);
    CHECK(farthest < 0);
    CHECK(differs / asked < 0.01);  // W/(m2 sr), of 1 to 2
}

TEST_CASE("reflect: the truth of mirrors is what mirrored paths find", "[frame][reflect][truth][analytic]") {
    // A floor before a wall that sends M / pi: the floor shows k M / pi of it, and black of what is beside it.
    Scene scene;
    scene.name = "wall";
    scene.materials.resize(2);
    scene.materials[0].reflectance = glm::vec3(0), scene.materials[0].emission = {3, 2, 1};
    scene.materials[1].reflectance = glm::vec3(0), scene.materials[1].mirror = {0.75f, 0.5f, 0.25f};
    Mesh& m = scene.meshes.emplace_back();
    moving::add_quad(m, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 1);
    moving::add_quad(m, {-1, 0, -1}, {2, 0, 0}, {0, 1, 0}, 0);
    scene.camera.position = {0.2, 1, 3}, scene.camera.look_at = {0, 0.4, -1}, scene.camera.up = {0, 1, 0};
    scene.camera.near = 0.1, scene.camera.far = 20, scene.frame_size = {96, 80};
    frame::Settings settings = mirroring();
    settings.truth = true, settings.reference.samples = 2, settings.reference.rounds = 2;
    const frame::Frame f = render(scene, settings);
    const frame::Traced* truth = frame::find_traced(f, "truth.reflection");
    REQUIRE(truth);
    int shown = 0, agree = 0;
    for (std::size_t i = 0; i < f.radiance.size(); ++i) {
        const glm::vec4 t = truth->estimate.mean.texels[i], l_r = f.reflect.reflection.texels[i];
        for (int c = 0; c < 3; ++c) {
            const double full = double(scene.materials[1].mirror[c]) * scene.materials[0].emission[c] / pi;
            CHECK((t[c] == 0 || t[c] == Approx(full).epsilon(1e-5)));
            CHECK((l_r[c] == 0 || l_r[c] == Approx(full).epsilon(1e-5)));
        }
        if (t.x == 0) continue;
        ++shown, agree += l_r.x > 0;
    }
    CHECK(shown > 600);
    CHECK(agree > 0.93 * shown);  // but at the wall's foot and its outline
    const frame::MirrorClasses c = classes_of(scene, settings, f);
    CHECK(count(c, MirrorClass::right) > 0.93 * shown);
    CHECK(count(c, MirrorClass::wrong) + count(c, MirrorClass::missed) < 0.07 * shown);
    CHECK(count(c, MirrorClass::open) > 200);
    CHECK(c.mirrors() + count(c, MirrorClass::none) == 96 * 80);
    // Its bits are the same everywhere.
    for (const Isa isa : supported_isas()) {
        RunOptions options;
        options.isa = isa, options.threads = isa == Isa::scalar ? 1 : 3;
        const frame::Frame other = render(scene, settings, options);
        CHECK(same(other.reflect.reflection, f.reflect.reflection));
        CHECK(same(frame::find_traced(other, "truth.reflection")->estimate.mean, truth->estimate.mean));
    }
}

// With contacts: the blocks' feet stand on the mirror, and a step that crosses beside them is halved back towards it.
TEST_CASE("reflect: what is met rises above the mirror, faces the ray and is never the pixel itself", "[frame][reflect][LRA 4.2.4]") {
    Scene scene = room();
    scene.frame_size = {160, 130};
    for (const March march : {March::steps, March::hierarchical}) {
        CAPTURE(int(march));
        frame::Settings settings = mirroring();
        settings.reflect.march = march, settings.reflect.step = 0.1f;
        const frame::Frame f = render(scene, settings);
        int met = 0, itself = 0, backs = 0, low = 0;
        for (int y = 0; y < scene.frame_size.y; ++y)
            for (int x = 0; x < scene.frame_size.x; ++x) {
                const glm::vec4 hit = f.reflect.hits.back()(x, y);
                if (hit.w == 0) continue;
                const glm::ivec2 at(int(hit.x), int(hit.y));
                const glm::vec3 p(f.gbuffer.position(x, y)), n(f.gbuffer.normal(x, y)), q(f.gbuffer.position(at.x, at.y)), n_q(f.gbuffer.normal(at.x, at.y));
                const glm::vec3 v = p - glm::vec3(scene.camera.position), r = v - n * (2 * (n.x * v.x + n.y * v.y + n.z * v.z)), d = q - p;
                ++met;
                itself += at == glm::ivec2(x, y);
                backs += n_q.x * r.x + n_q.y * r.y + n_q.z * r.z >= 0;
                low += n.x * d.x + n.y * d.y + n.z * d.z < (march == March::steps ? -1e-5f : 0.999f * settings.reflect.bias);
            }
        CHECK(met > 1000);
        CHECK(itself == 0);
        CHECK(backs == 0);
        CHECK(low == 0);
    }
}

// A step that meets a wall may be halved to behind a block that stands before it.
TEST_CASE("reflect: halved steps end no farther behind what is seen than the thickness", "[frame][reflect][LRA 4.2.4]") {
    Scene scene = room();
    scene.frame_size = {128, 104};
    int met = 0, behind = 0;
    for (const glm::dvec3& eye : {glm::dvec3(0.3, 1.2, 3.4), glm::dvec3(-0.7, 0.4, 2.2), glm::dvec3(0.8, 0.7, 1.6), glm::dvec3(0, 1.7, 1.2), glm::dvec3(0.5, 0.3, 3)})
        for (const float step : {0.1f, 0.25f, 0.5f}) {
            scene.camera.position = eye, scene.camera.look_at = {0.1, 0.3, -0.2};
            frame::Settings settings = mirroring();
            settings.reflect.step = step, settings.reflect.thickness = 0.8f;
            const frame::Frame f = render(scene, settings);
            const glm::dvec3 forward = axes(scene.camera).forward;
            for (int y = 0; y < scene.frame_size.y; ++y)
                for (int x = 0; x < scene.frame_size.x; ++x) {
                    const glm::vec4 hit = f.reflect.hits.back()(x, y);
                    if (hit.w == 0) continue;
                    const glm::dvec3 p(f.gbuffer.position(x, y)), n(f.gbuffer.normal(x, y)), w = p - scene.camera.position;
                    const glm::dvec3 v = w / length(w), at = w + (v - n * (2 * (n.x * v.x + n.y * v.y + n.z * v.z))) * double(hit.z);
                    const double depth = at.x * forward.x + at.y * forward.y + at.z * forward.z;
                    ++met;
                    behind += depth - double(f.gbuffer.position(int(hit.x), int(hit.y)).w) > double(step) * 0.8 + 1e-4;
                }
        }
    CHECK(met > 10000);
    CHECK(behind == 0);
}

TEST_CASE("reflect: rays that the camera loses are followed in every map, and lit by all lights", "[frame][reflect][LRA 4.3.1]") {
    Scene scene = room();
    scene.frame_size = {96, 78};
    scene.camera.look_at = {0, 0.1, 0.3}, scene.camera.fov_y_deg = 24;  // most of what the floor shows is not in the picture
    for (Light& light : scene.lights) light.rsm_size = 160;
    frame::Settings settings = mirroring(ReflectViews::lights);
    const frame::Plan plan = frame::plan(scene, settings);
    for (const char* label : {"screen.reflect", "screen.reflect (key)", "screen.reflect (bulb, px)", "screen.reflect (sun)",
                              "gbuffer (key, map)", "shadow (bulb, mirrored)", "direct (mirrored)", "screen.mirror"}) {
        CAPTURE(label);
        CHECK(has(plan, label));
    }
    const frame::Frame f = render(scene, settings), own = render(scene, mirroring());
    CHECK(f.reflect.hits.size() == 10);  // of the camera, of eight maps, and the nearest of them
    CHECK(same(f.reflect.hits.front(), own.reflect.hits.front()));
    int more = 0, in_two = 0;
    const frame::SourceView& met = f.views.back();
    for (std::size_t i = 0; i < f.radiance.size(); ++i) {
        const glm::vec4 hit = f.reflect.hits.back().texels[i], of_camera = own.reflect.hits.back().texels[i];
        if (of_camera.w == 1) {
            CHECK(hit == of_camera);
            continue;
        }
        CHECK(hit.w != 1);
        // Of the maps the nearest stands.
        for (std::size_t m = 1; m + 1 < f.reflect.hits.size(); ++m) {
            const glm::vec4 of_map = f.reflect.hits[m].texels[i];
            if (of_map.w == 0) continue;
            CHECK((hit.w > 0 && hit.z <= of_map.z));
            in_two += of_map.w != hit.w && of_map.z != hit.z;
        }
        if (hit.w == 0) continue;
        ++more;
        for (int c = 0; c < 3; ++c) {
            const double lit = (double(met.gbuffer.albedo.texels[i][c]) * met.direct.texels[i][c]) / pi;
            CHECK(double(f.reflect.reflection.texels[i][c]) == Approx(scene.materials[1].mirror[c] * lit).epsilon(1e-5));
        }
    }
    CHECK(more > 300);
    CHECK(in_two > 30);
    const frame::MirrorClasses alone = classes_of(scene, mirroring(), own), all = classes_of(scene, settings, f);
    std::string counts;
    for (int i = 1; i < frame::mirror_classes; ++i) counts += std::string(frame::name_of(MirrorClass(i))) + " " + std::to_string(all.count[std::size_t(i)]) + ", ";
    INFO(counts);
    CHECK(count(all, MirrorClass::right) == count(alone, MirrorClass::right));
    CHECK(count(all, MirrorClass::right_in_map) > 300);
    CHECK(count(all, MirrorClass::right_in_map) > 4 * count(all, MirrorClass::wrong_in_map));
    CHECK(all.mirrors() == alone.mirrors());
    CHECK(count(all, MirrorClass::unseen) < count(alone, MirrorClass::unseen));
    // Lamps that are off or black are no view; without a mirror nothing runs.
    scene.lights[0].on = false, scene.lights[2].intensity = glm::vec3(0);
    CHECK_FALSE(has(frame::plan(scene, settings), "screen.reflect (key)"));
    CHECK_FALSE(has(frame::plan(scene, settings), "screen.reflect (sun)"));
    scene.materials[1].mirror = glm::vec3(0);
    const frame::Frame none = render(scene, settings);
    CHECK(same(none.radiance, none.reflect.composed));
    for (const frame::StageRun& s : none.stages)
        if (s.label.starts_with("screen.") || s.label.find("mirrored)") != std::string::npos) CHECK_FALSE(s.needed);
    for (const frame::StageRun& s : none.stages)
        if (s.label == "screen.mirror" || s.label == "shadow (bulb, mirrored)" || s.label == "direct (mirrored)") CHECK(s.rule == "no-mirror");
    CHECK(has(frame::plan(scene, settings), "shadow (bulb, mirrored)"));
}

TEST_CASE("reflect: right is the same triangle and at most a texel off", "[frame][reflect][truth]") {
    Scene scene = room();
    scene.frame_size = {96, 78};
    const frame::Settings settings = mirroring();
    const frame::Frame f = render(scene, settings);
    const frame::MirrorClasses before = classes_of(scene, settings, f);
    // All hits moved by so many texels at once; `same`: where the texel shows the triangle that was met. Those that were right.
    struct Moved {
        int same = 0, right = 0, others = 0, right_others = 0, elsewhere = 0;
    };
    const auto moved = [&](glm::ivec2 by) {
        frame::Frame other = f;
        std::vector<glm::ivec2> pixels;
        for (int y = 0; y < 78; ++y)
            for (int x = 0; x < 96; ++x) {
                glm::vec4& hit = other.reflect.hits.back()(x, y);
                const glm::ivec2 to = glm::ivec2(int(hit.x), int(hit.y)) + by;
                if (hit.w == 0 || before.of_pixel(x, y) != float(MirrorClass::right) || to.x < 0 || to.y < 0 || to.x >= 96 || to.y >= 78) continue;
                hit.x += float(by.x), hit.y += float(by.y);
                pixels.push_back({x, y});
            }
        const frame::MirrorClasses after = classes_of(scene, settings, other);
        Moved m;
        for (const glm::ivec2 p : pixels) {
            const glm::vec4 hit = other.reflect.hits.back()(p.x, p.y), was = f.reflect.hits.back()(p.x, p.y);
            const bool is_same = f.gbuffer.id(int(hit.x), int(hit.y)) == f.gbuffer.id(int(was.x), int(was.y)), right = after.of_pixel(p.x, p.y) == float(MirrorClass::right);
            ++(is_same ? m.same : m.others), (is_same ? m.right : m.right_others) += right;
            m.elsewhere += !right && after.of_pixel(p.x, p.y) != float(MirrorClass::wrong);
        }
        return m;
    };
    for (const glm::ivec2 axis : {glm::ivec2(1, 0), glm::ivec2(0, 1)}) {
        CAPTURE(axis.x);
        // A hit is where the ray meets it, or a texel to one side of that: a texel more to this side is right for some at least, two
        // to a side for those alone that were off to the other one, three for none.
        const Moved one = moved(axis), three = moved(3 * axis), back = moved(-3 * axis);
        CHECK(one.same > 600);
        CHECK(one.right > one.same / 2);
        CHECK(one.others > 10);
        CHECK(one.right_others == 0);
        CHECK(three.right + three.right_others + back.right + back.right_others == 0);
        CHECK(one.elsewhere + three.elsewhere + back.elsewhere == 0);
        const Moved two = moved(2 * axis);
        CHECK(two.right < two.same / 4);
    }
}

TEST_CASE("reflect: every parameter that changes a stage's result changes its key", "[frame][reflect][keys]") {
    Scene scene = room();
    scene.frame_size = {24, 20};
    frame::Settings before = mirroring(ReflectViews::lights);
    before.reflect.fade = 0.1f, before.reflect.attenuation = 4;
    const test::Ran old(scene, before);
    int changed = 0;
    for (std::size_t i = 0; i < screen::fields(before.reflect).size(); ++i) {
        frame::Settings after = before;
        Field field = screen::fields(after.reflect)[i];
        CAPTURE(field.name);
        if (!field.choices.empty()) continue;  // of another plan, or refused
        if (auto* p = std::get_if<int*>(&field.value)) **p = 2 * **p;
        if (auto* p = std::get_if<float*>(&field.value)) **p *= 0.75f;
        const test::Ran now(scene, after);
        REQUIRE(old.plan.stages.size() == now.plan.stages.size());
        for (std::size_t s = 0; s < old.plan.stages.size(); ++s) {
            const std::string& label = old.plan.stages[s].label;
            CAPTURE(label);
            if (old.keys[s] == now.keys[s])
                CHECK(test::same_bytes(old.outputs.at(label), now.outputs.at(label)));
            else
                CHECK((label.starts_with("screen.") || label.ends_with("mirrored)") || label == "tonemap"));
            changed += !(old.keys[s] == now.keys[s]);
        }
    }
    CHECK(changed > 40);
    // A lamp that moves is followed again.
    scene.lights[1].position.x += 0.1f;
    const test::Ran after(scene, before);
    for (std::size_t s = 0; s < old.plan.stages.size(); ++s) {
        const std::string& label = old.plan.stages[s].label;
        CAPTURE(label);
        if (label == "screen.reflect" || label == "screen.reflect (key)" || label == "gbuffer (key, map)") CHECK(old.keys[s] == after.keys[s]);
        if (label.starts_with("screen.reflect (bulb") || label == "screen.mirror") CHECK_FALSE(old.keys[s] == after.keys[s]);
    }
}

TEST_CASE("reflect: its stages are explained, and end with what the picture holds", "[frame][reflect][explain]") {
    const Scene scene = room();
    const frame::Settings settings = mirroring(ReflectViews::lights);
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, plan, {});
    for (const glm::ivec2 pixel : {glm::ivec2(30, 44), glm::ivec2(40, 30)}) {
        const auto last = [&](const char* stage) { return frame::explain(scene, settings, plan, f, stage, 2, pixel).back().values.back(); };
        CHECK(float(last("screen.mirror").value[0]) == f.radiance(pixel.x, pixel.y).x);
        CHECK(float(last("screen.reflect").value[0]) == f.reflect.hits.back()(pixel.x, pixel.y).w);
    }
}

TEST_CASE("reflect: what a plan refuses", "[frame][reflect][input]") {
    frame::Settings settings = mirroring(ReflectViews::lights);
    settings.reflect.variant = screen::ReflectVariant::published;
    CHECK_THROWS_WITH(frame::plan(room(), settings), Catch::Contains("variant = published with views = lights"));
    // The picture of the method reference is path traced: it has its mirrors.
    settings.method = frame::Method::reference;
    CHECK_FALSE(has(frame::plan(room(), settings), "screen.reflect"));
}
