// Parameters that are said to change nothing change no bit of the picture, and their neighbours do.
#include <algorithm>
#include <catch2/catch.hpp>

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
    s.rsm.samples = 9, s.reference.samples = 2;
    return s;
}

// Another value within the range.
bool change(Field& field) {
    if (auto* p = std::get_if<int*>(&field.value)) {
        const double twice = field.choices.empty() ? 2.0 * **p + 1 : (**p + 1) % int(field.choices.size());
        if (twice < field.min || (field.choices.empty() && twice > field.max)) return false;
        **p = int(twice);
        return true;
    }
    if (auto* p = std::get_if<float*>(&field.value)) {
        const float other = **p * 0.75f + (**p == 0 ? 0.25f : 0.0f);
        if (other < field.min || other > field.max) return false;
        **p = other;
        return true;
    }
    return false;
}

}  // namespace

TEST_CASE("settings: what is idle changes no bit of the picture", "[frame][settings]") {
    const Scene scene = room();
    std::vector<frame::Settings> all = {base(frame::Method::direct), base(frame::Method::rsm), base(frame::Method::isr), base(frame::Method::reference)};
    const auto add = [&](auto set) { all.push_back(base(frame::Method::rsm)), set(all.back()); };
    add([](frame::Settings& s) { s.ao.method = screen::AoMethod::ssao, s.reflect.march = screen::March::steps, s.reflect.step = 0.05f; });
    add([](frame::Settings& s) { s.ao.method = screen::AoMethod::horizon, s.reflect.march = screen::March::hierarchical, s.reflect.lobe = screen::Lobe::phong; });
    add([](frame::Settings& s) { s.ao.method = screen::AoMethod::ssao, s.ao.views = screen::AoViews::lights, s.reuse.frames = 4; });
    int idle = 0, changed = 0;
    all.push_back(base(frame::Method::zbuffer)), all.back().reflect.march = screen::March::steps;
    add([](frame::Settings& s) { s.reflect.march = screen::March::steps, s.reflect.variant = screen::ReflectVariant::published; });
    for (const frame::Settings& before : all) {
        const Image4 picture = render(scene, before).radiance;
        for (const std::string table : {"ao", "reflect", "reuse", "rsm", "indirect", "isr", "reference"}) {
            if (before.method == frame::Method::reference && table == "reference") continue;
            frame::Settings copy = before;
            const std::size_t count = frame::table_fields(copy, table, table).size();
            for (std::size_t i = 0; i < count; ++i) {
                frame::Settings after = before;
                std::vector<Field> fields = frame::table_fields(after, table, table);
                CAPTURE(frame::method_name(before.method), table, fields[i].name, frame::idle(before, table, fields[i].name));
                const bool is_idle = !frame::idle(before, table, fields[i].name).empty();
                // What works is tried where it is cheap: one frame's own tables.
                if (!is_idle && table != "ao" && table != "reflect") continue;
                if (!change(fields[i])) continue;
                bool is_same = false;
                try {
                    is_same = same(render(scene, after).radiance, picture);
                } catch (const InputError&) {
                    continue;  // refused beside the others
                }
                ++(is_idle ? idle : changed);
                if (is_idle) CHECK(is_same);
                if (!is_same) CHECK_FALSE(is_idle);
                const std::vector<std::string> always = {"samples", "radius", "slices", "step", "rays"};
                if (!is_idle && std::count(always.begin(), always.end(), fields[i].name) > 0) CHECK_FALSE(is_same);
            }
        }
    }
    CHECK(idle > 100);
    CHECK(changed > 40);
}

TEST_CASE("settings: why one is idle", "[frame][settings]") {
    frame::Settings s = base(frame::Method::rsm);
    CHECK(frame::idle(s, "rsm", "samples").empty());
    CHECK(frame::idle(s, "ao", "method").empty());
    CHECK(frame::idle(s, "ao", "samples") == "ao.method is off");
    CHECK(frame::idle(s, "reflect", "rays") == "reflect.march is off");
    CHECK(frame::idle(s, "probes", "count") == "the method is rsm");
    CHECK(frame::idle(s, "reuse", "clamp") == "reuse.frames is 0");
    s.reflect.march = screen::March::steps;
    CHECK(frame::idle(s, "reflect", "rays") == "reflect.lobe is off");
    CHECK(frame::idle(s, "reflect", "layers").empty());
    CHECK(frame::idle(s, "reflect", "cells") == "reflect.march is steps");
    CHECK(frame::idle(s, "reflect", "views").empty());
    s.method = frame::Method::zbuffer;
    CHECK(frame::idle(s, "reflect", "views") == "no light has a map: nothing casts shadows");
    s.method = frame::Method::rsm;
    CHECK(frame::idle(s, "reference", "samples") == "no path is traced: neither method reference nor --truth");
    s.truth = true;
    CHECK(frame::idle(s, "reference", "samples").empty());
}
