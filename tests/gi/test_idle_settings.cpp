// Parameters that are said to change nothing change no bit of the picture, and their neighbours do.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "core/error.h"
#include "gi/frame/idle_settings.h"
#include "tests/gi/open_room.h"

using namespace plumb;
using test::render;
using test::same;

namespace {

Scene room() {
    Scene s = test::open_room({1, 0.1f, 0.6f, 0.7, {24, 20}});
    s.materials.resize(2);
    s.materials[1].reflectance = glm::vec3(0.25f), s.materials[1].mirror = glm::vec3(0.25f);
    s.materials[1].specular = glm::vec3(0.25f), s.materials[1].exponent = 9;
    for (Light& light : s.lights) light.rsm_size = 24;
    return s;
}

frame::Settings base(frame::Method method) {
    frame::Settings s;
    s.method = method;
    s.rsm.gather = rsm::Gather::disc, s.rsm.samples = 9, s.reference.samples = 2;
    return s;
}

// Another value within the range: a larger one, or a smaller one.
bool change(Field& field, bool larger) {
    if (auto* p = std::get_if<int*>(&field.value)) {
        const double other = field.choices.empty() ? (larger ? 2.0 * **p + 1 : **p / 64) : (**p + 1) % int(field.choices.size());
        if (other < field.min || (field.choices.empty() && other > field.max)) return false;
        **p = int(other);
        return true;
    }
    if (auto* p = std::get_if<float*>(&field.value)) {
        const float other = larger ? **p * 20 : **p * 0.75f + (**p == 0 ? 0.25f : 0.0f);
        if (other < field.min || other > field.max) return false;
        **p = other;
        return true;
    }
    return false;
}

}  // namespace

TEST_CASE("settings: what is idle changes no bit of the picture", "[frame][settings]") {
    const Scene shining = room();
    // Nothing mirrors; nothing has a lobe.
    Scene dull = room(), smooth = room();
    for (Material& m : dull.materials) m.mirror = m.specular = glm::vec3(0);
    for (Material& m : smooth.materials) m.specular = glm::vec3(0);
    std::vector<frame::Settings> all = {base(frame::Method::direct), base(frame::Method::rsm), base(frame::Method::isr), base(frame::Method::reference)};
    const auto add = [&](auto set) { all.push_back(base(frame::Method::rsm)), set(all.back()); };
    add([](frame::Settings& s) { s.ao.method = screen::AoMethod::ssao, s.reflect.march = screen::March::steps, s.reflect.step = 0.05f; });
    add([](frame::Settings& s) { s.ao.method = screen::AoMethod::horizon, s.reflect.march = screen::March::hierarchical, s.reflect.lobe = screen::Lobe::phong; });
    add([](frame::Settings& s) { s.ao.method = screen::AoMethod::ssao, s.ao.views = screen::AoViews::lights, s.reuse.frames = 4; });
    int idle = 0, changed = 0;
    all.push_back(base(frame::Method::zbuffer)), all.back().reflect.march = screen::March::steps;
    add([](frame::Settings& s) { s.reflect.march = screen::March::steps, s.reflect.variant = screen::ReflectVariant::published; });
    add([](frame::Settings& s) { s.shadow.filter = direct::VisibilityFilter::gaussian; });
    std::vector<std::pair<const Scene*, frame::Settings>> cases;
    for (const frame::Settings& settings : all) cases.emplace_back(&shining, settings);
    for (const Scene* scene : {&dull, &smooth})
        add([](frame::Settings& s) { s.reflect.march = screen::March::steps, s.reflect.lobe = screen::Lobe::phong; }), cases.emplace_back(scene, all.back());
    // Parameters that ever worked, and of them those that ever moved a bit.
    std::set<std::string> works, moves;
    for (const auto& [of, before] : cases) {
        const Scene& scene = *of;
        const Image4 picture = render(scene, before).radiance;
        for (const std::string table : {"ao", "reflect", "reuse", "rsm", "indirect", "isr", "reference", "shadow"}) {
            if (before.method == frame::Method::reference && table == "reference") continue;
            frame::Settings copy = before;
            const std::size_t count = frame::table_fields(copy, table, table).size();
            for (std::size_t i = 0; i < 2 * count; ++i) {
                frame::Settings after = before;
                std::vector<Field> fields = frame::table_fields(after, table, table);
                Field& field = fields[i / 2];
                const bool larger = i % 2 == 0;
                CAPTURE(frame::method_name(before.method), larger, table, field.name, frame::idle(before, scene, table, field.name));
                const bool is_idle = !frame::idle(before, scene, table, field.name).empty();
                // What works is tried where it is cheap: one frame's own tables.
                if (!is_idle && table != "ao" && table != "reflect") continue;
                if (!change(field, larger)) continue;
                bool is_same = false;
                try {
                    is_same = same(render(scene, after).radiance, picture);
                } catch (const InputError&) {
                    continue;  // refused beside the others
                }
                ++(is_idle ? idle : changed);
                if (is_idle) CHECK(is_same);
                if (!is_same) CHECK_FALSE(is_idle);
                if (!is_idle) works.insert(table + "." + field.name);
                if (!is_idle && !is_same) moves.insert(table + "." + field.name);
                const std::vector<std::string> always = {"samples", "radius", "slices", "step", "rays"};
                if (!is_idle && std::count(always.begin(), always.end(), field.name) > 0) CHECK_FALSE(is_same);
            }
        }
    }
    CHECK(idle > 100);
    CHECK(changed > 40);
    // What is never idle where it is tried moves something somewhere.
    CHECK(works == moves);
}

TEST_CASE("settings: why one is idle", "[frame][settings]") {
    frame::Settings s = base(frame::Method::rsm);
    Scene scene = room();
    CHECK(frame::idle(s, scene, "rsm", "samples").empty());
    CHECK(frame::idle(s, scene, "ao", "method").empty());
    CHECK(frame::idle(s, scene, "ao", "samples") == "ao.method is off");
    CHECK(frame::idle(s, scene, "reflect", "rays") == "reflect.march is off");
    CHECK(frame::idle(s, scene, "probes", "count") == "the method is rsm");
    CHECK(frame::idle(s, scene, "reuse", "clamp") == "reuse.frames is 0");
    s.reflect.march = screen::March::steps;
    CHECK(frame::idle(s, scene, "reflect", "rays") == "reflect.lobe is off");
    CHECK(frame::idle(s, scene, "reflect", "layers").empty());
    CHECK(frame::idle(s, scene, "reflect", "cells") == "reflect.march is steps");
    CHECK(frame::idle(s, scene, "reflect", "views").empty());
    s.method = frame::Method::zbuffer;
    CHECK(frame::idle(s, scene, "reflect", "views") == "no light has a map: nothing casts shadows");
    s.method = frame::Method::rsm;
    CHECK(frame::idle(s, scene, "reference", "samples") == "no path is traced: neither method reference nor --truth");
    s.truth = true;
    CHECK(frame::idle(s, scene, "reference", "samples").empty());
    // What no material of the scene has.
    s.reflect.march = screen::March::steps, s.reflect.lobe = screen::Lobe::phong;
    CHECK(frame::idle(s, scene, "reflect", "rays").empty());
    for (Material& m : scene.materials) m.specular = glm::vec3(0);
    CHECK(frame::idle(s, scene, "reflect", "rays") == "no material has a lobe");
    CHECK(frame::idle(s, scene, "reflect", "lobe") == "no material has a lobe");
    CHECK(frame::idle(s, scene, "reflect", "step").empty());
    for (Material& m : scene.materials) m.mirror = glm::vec3(0);
    CHECK(frame::idle(s, scene, "reflect", "step") == "nothing mirrors");
    CHECK(frame::idle(s, scene, "reflect", "march") == "nothing mirrors");
}
