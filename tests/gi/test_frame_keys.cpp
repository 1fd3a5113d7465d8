// Keys of stages: whatever can change a stage's output changes its key, and what it does not read does not.
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <set>

#include "core/error.h"
#include "gi/frame/kept.h"
#include "tests/gi/keys_of.h"
#include "tests/gi/moving_scene.h"

using namespace plumb;
using moving::differences;

namespace {

using Labels = std::set<std::string>;

struct Case {
    Scene scene;
    frame::Settings settings;
    frame::Plan plan() const { return frame::plan(scene, settings); }
    std::vector<graph::Key> keys(Isa isa = Isa::scalar) const { return test::keys_of(scene, settings, isa); }
};

Case base() {
    Case c{moving::scene(), {}};
    c.settings.rsm.gather = rsm::Gather::disc, c.settings.rsm.samples = 16;
    c.settings.shadow.mode = direct::ShadowMode::hard;
    c.settings.indirect.blur = filter::Blur::none;  // test_filter_frame.cpp has frames with filters
    c.settings.reference.samples = 2, c.settings.reference.rounds = 2, c.settings.reference.rays = Rays::exact;
    c.settings.truth = true;
    c.settings.pruning = false;  // what is wanted of a buffer then depends on nothing
    return c;
}

// The stages whose keys are the same in both.
Labels same(const Case& a, const Case& b) {
    const frame::Plan plan = a.plan();
    const std::vector<std::uint64_t> x = a.keys(), y = b.keys();
    REQUIRE(x.size() == y.size());
    Labels labels;
    for (std::size_t i = 0; i < x.size(); ++i)
        if (x[i] == y[i]) labels.insert(plan.stages[i].label);
    return labels;
}

// Which stages make a buffer of moving::buffers(); the frame's indirect light is of every gather.
Labels makers(const std::string& buffer, const Case& c) {
    Labels labels;
    for (const frame::PlannedStage& s : c.plan().stages) {
        const std::string light = std::to_string(s.light);
        const bool makes = buffer == s.name || buffer == s.name + " " + light || buffer == "traced " + s.layer ||
                           (buffer == "radiance" && (s.name == "compose" || s.layer == "color")) ||
                           (buffer == "display" && s.name == "tonemap") ||
                           (buffer == "truth_display" && (s.layer == "truth" || s.name == "tonemap")) ||
                           ((buffer == "indirect" || buffer == "error") && s.name.starts_with("rsm."));
        if (makes) labels.insert(s.label);
    }
    return labels;
}

// Of every buffer that differs, some maker's key differs. Returns whether any does.
bool check_outputs(const Case& a, const Case& b) {
    const frame::Frame x = frame::execute(a.scene, a.settings, a.plan(), {});
    const frame::Frame y = frame::execute(b.scene, b.settings, b.plan(), {});
    const Labels kept = same(a, b);
    const std::vector<std::string> differ = differences(x, y, a.scene.frame_size);
    for (const std::string& buffer : differ) {
        CAPTURE(buffer);
        const Labels of = makers(buffer, b);
        CHECK_FALSE(of.empty());
        CHECK(std::any_of(of.begin(), of.end(), [&](const std::string& label) { return !kept.contains(label); }));
    }
    return !differ.empty();
}

const Labels maps = {"rsm (key)", "rsm (sun)", "rsm (bulb)"};
const Labels lit = {"rsm (key)",   "rsm (sun)",   "rsm (bulb)",        "shadow (key)",     "shadow (sun)", "shadow (bulb)",
                    "direct",      "gbuffer",     "rsm.disc (key)",    "rsm.disc (sun)",   "rsm.disc (bulb)"};
const Labels traced = {"truth", "truth.direct", "truth.indirect"};

Labels both(Labels a, const Labels& b) {
    a.insert(b.begin(), b.end());
    return a;
}
Labels without(Labels a, const Labels& b) {
    for (const std::string& label : b) a.erase(label);
    return a;
}
Labels everything() {
    Labels labels;
    for (const frame::PlannedStage& s : base().plan().stages) labels.insert(s.label);
    return labels;
}

struct Change {
    const char* name;
    std::function<void(Scene&)> change;
    Labels keeps;          // exactly these
    bool visible = true;   // whether a buffer of the base scene differs
};

// What a light's own stages read of it leaves the others' alone.
Labels others(const std::string& light) {
    return without(lit, {"direct", "rsm (" + light + ")", "shadow (" + light + ")", "rsm.disc (" + light + ")"});
}

// Every member of every part of a scene, in the order of core/scene.h. keys.cpp takes the same structures apart, so that
// a new member cannot be forgotten there.
std::vector<Change> scene_changes() {
    const Labels all = everything(), none;
    return {
        {"name", [](Scene& s) { s.name = "x"; }, all, false},
        {"mesh: name", [](Scene& s) { s.meshes[1].name = "x"; }, all, false},
        {"mesh: vertices", [](Scene& s) { s.meshes[1].vertices[0].position.y += 0.1f; }, none},
        {"mesh: normals", [](Scene& s) { s.meshes[0].vertices[1].normal = {0.6f, 0.8f, 0}; }, none},
        {"mesh: coordinates", [](Scene& s) { s.meshes[0].vertices[1].u += 0.3f; }, none},
        {"mesh: tangents", [](Scene& s) { s.meshes[0].tangents[0].w = -1; }, none},
        {"mesh: triangles", [](Scene& s) { std::swap(s.meshes[0].triangles[0].y, s.meshes[0].triangles[0].z); }, none},
        {"mesh: material", [](Scene& s) { s.meshes[1].material[0] = 1; }, none},
        {"mesh: transform", [](Scene& s) { s.meshes[1].transform[3].x += 0.1; }, none},
        {"mesh: dynamic", [](Scene& s) { s.meshes[1].dynamic = true; }, all, false},
        {"mesh: share", [](Scene& s) { s.meshes[1].share = 0.5; }, none},
        {"meshes", [](Scene& s) { s.meshes.pop_back(); }, none},
        {"material: name", [](Scene& s) { s.materials[0].name = "x"; }, all, false},
        {"material: reflectance", [](Scene& s) { s.materials[1].reflectance.y = 0.3f; }, none},
        {"material: emission", [](Scene& s) { s.materials[1].emission.z = 0.3f; }, maps},
        {"material: texture", [](Scene& s) { s.materials[0].texture = -1; }, none},
        {"material: emission texture", [](Scene& s) { s.materials[1].emission_texture = -1; }, maps},
        {"material: normal texture", [](Scene& s) { s.materials[0].normal_texture = -1; }, none},
        {"material: normal scale", [](Scene& s) { s.materials[0].normal_scale = 0.5f; }, none},
        {"material: alpha", [](Scene& s) { s.materials[3].alpha = 0.4f; }, none},
        {"material: alpha cutoff", [](Scene& s) { s.materials[3].alpha_cutoff = 0; }, none},
        {"material: specular", [](Scene& s) { s.materials[2].specular.x = 0.3f; }, without(all, traced)},
        {"material: exponent", [](Scene& s) { s.materials[2].exponent = 5; }, without(all, traced)},
        {"material: mirror", [](Scene& s) { s.materials[2].mirror.x = 0.2f; }, without(all, traced)},
        {"texture: name", [](Scene& s) { s.textures[0].name = "x"; }, all, false},
        {"texture: a texel", [](Scene& s) { s.textures[0].texels(2, 1) = 0xff202020; }, none},
        {"texture: sRGB", [](Scene& s) { s.textures[0].srgb = false; }, none},
        {"texture: filter", [](Scene& s) { s.textures[0].filter = Filter::nearest; }, none},
        {"texture: wrap u", [](Scene& s) { s.textures[0].wrap_u = Wrap::clamp_to_edge; }, none},
        {"texture: wrap v", [](Scene& s) { s.textures[0].wrap_v = Wrap::clamp_to_edge; }, none},
        {"texture: mips", [](Scene& s) { s.textures[0].mips = true; }, none},
        {"light: name", [](Scene& s) { s.lights[0].name = "x"; }, all, false},
        {"light: type", [](Scene& s) { s.lights[0].type = LightType::point; }, others("key")},
        {"light: position", [](Scene& s) { s.lights[0].position.x += 0.1f; }, others("key")},
        {"light: direction", [](Scene& s) { s.lights[1].direction = {0, -1, 0}; }, others("sun")},
        {"light: inner cone", [](Scene& s) { s.lights[0].cone_inner_deg = 20; }, others("key")},
        {"light: outer cone", [](Scene& s) { s.lights[0].cone_outer_deg = 65; }, others("key")},
        {"light: intensity", [](Scene& s) { s.lights[2].intensity.y = 2; }, others("bulb")},
        {"light: on", [](Scene& s) { s.lights[0].on = false; }, others("key")},
        {"light: map", [](Scene& s) { s.lights[0].rsm_size = 24; }, both(others("key"), traced)},
        {"environment: radiance", [](Scene& s) { s.environment.radiance.x = 0.5f; },
         without(all, both(traced, {"compose", "tonemap"}))},
        {"environment: map", [](Scene& s) { s.environment.map(1, 0).x = 3; }, without(all, traced)},
        {"camera: position", [](Scene& s) { s.camera.position.x += 0.1; }, maps},
        {"camera: look_at", [](Scene& s) { s.camera.look_at.x += 0.1; }, maps},
        {"camera: up", [](Scene& s) { s.camera.up.x += 0.1; }, maps},
        {"camera: fov", [](Scene& s) { s.camera.fov_y_deg = 50; }, maps},
        {"camera: near", [](Scene& s) { s.camera.near = 2.9; }, maps},
        {"camera: far", [](Scene& s) { s.camera.far = 4; }, maps},
        {"camera: reversed z", [](Scene& s) { s.camera.reversed_z = true; }, maps},
        {"convention", [](Scene& s) { s.convention = Convention::opengl; }, both(maps, {"truth"})},
        {"seed of the file", [](Scene& s) { s.seed = 9; }, all, false},
        {"frame size", [](Scene& s) { s.frame_size = {14, 20}; }, maps},
        {"method of the file", [](Scene& s) { s.method = "direct"; }, all, false},
        {"layout of the file", [](Scene& s) { s.layout = "lra"; }, all, false},
        {"animation", [](Scene& s) { moving::move_camera(s); }, all, false},
        {"settings of the file", [](Scene& s) { s.settings.push_back({"rsm", "samples", 3.0, "x"}); }, all, false},
        {"notes", [](Scene& s) { s.notes.push_back("x"); }, all, false},
    };
}

// Another value that the field may have.
void change(Field& f) {
    if (auto p = std::get_if<int*>(&f.value)) {
        if (!f.choices.empty())
            **p = (**p + 1) % int(f.choices.size());
        else
            **p = **p < f.max ? **p + 1 : **p - 1;
    } else if (auto p = std::get_if<float*>(&f.value)) {
        **p = **p * 1.25 + 0.01 <= f.max ? **p * 1.25f + 0.01f : **p * 0.5f;
    } else if (auto p = std::get_if<bool*>(&f.value)) {
        **p = !**p;
    } else if (auto p = std::get_if<glm::vec3*>(&f.value)) {
        (*p)->x = (*p)->x * 0.5f + 0.01f;
    }
}

bool can_be_planned(const Case& c) {
    try {
        c.plan();
        return true;
    } catch (const InputError&) {
        return false;
    }
}

}  // namespace

TEST_CASE("keys: every member of a scene changes the keys of the stages that read it, and no others",
          "[frame][frames][keys]") {
    const Case before = base();
    int seen = 0;
    for (const Change& change : scene_changes()) {
        CAPTURE(change.name);
        Case after = base();
        change.change(after.scene);
        Labels kept = same(before, after);
        CHECK(kept == change.keeps);
        const bool differs = check_outputs(before, after);
        if (!change.visible) CHECK_FALSE(differs);
        seen += differs;
    }
    // What this scene does not show at its size is still in the keys; it is little.
    CHECK(seen >= 38);
}

TEST_CASE("keys: a parameter changes the keys of the stages whose result it changes, and of none that cannot read it",
          "[frame][frames][keys]") {
    const Labels gathers = {"rsm.disc (key)", "rsm.disc (sun)", "rsm.disc (bulb)"};
    const std::map<std::string, Labels> changed = {
        {"rsm", both(gathers, {"compose", "tonemap"})},
        {"shadow", {"shadow (key)", "shadow (sun)", "shadow (bulb)", "direct", "compose", "tonemap"}},
        {"direct", {"direct", "compose", "tonemap"}},
        {"compose", {"direct", "compose", "tonemap"}},  // the first shadow colour also asks for the density
        {"tonemap", {"tonemap"}},
        {"reference", traced},
        {"probes", {}}, {"lod", {}},  // of a bake, and of the method that reads it
        {"radiosity", {}},            // of another method
        {"zbuffer", {}},              // the same
        {"layout", without(everything(), {"truth"})}};
    // The members of a layout are a custom one's.
    auto custom = [](Case c, const std::string& table) {
        if (table == "layout") c.settings.layout.name = "custom";
        return c;
    };
    int parameters = 0, seen = 0;
    for (const std::string& table : frame::method_tables()) {
        // Of stages that this frame has not: test_filter_frame.cpp, test_isr_frame.cpp, test_ao_frame.cpp, test_reflect_frame.cpp,
        // test_reuse_frame.cpp.
        if (table == "indirect" || table == "isr" || table == "ao" || table == "reflect" || table == "reuse") continue;
        const Case before = custom(base(), table);
        Case counted = base();
        for (std::size_t i = 0; i < frame::table_fields(counted.settings, table, "test").size(); ++i) {
            Case after = custom(base(), table);
            std::vector<Field> fields = frame::table_fields(after.settings, table, "test");
            CAPTURE(table, fields[i].name);
            if (table == "rsm" && fields[i].name == "gather") continue;     // another stage, below
            if (table == "shadow" && fields[i].name == "filter") continue;  // one more stage: test_shadow_filter_frame.cpp
            // A file's name is no reason to gather again; its rows are, below.
            if (table == "rsm" && fields[i].name == "pattern") continue;
            change(fields[i]);
            // Some values are refused: that format for that buffer, that part without another, no power of two. The next one then.
            for (int other = 0; other < 64 && !can_be_planned(after); ++other) change(fields[i]);
            // A parameter that the stage does not read as it is set changes no key; one that changes a picture does.
            const Labels kept = same(before, after);
            for (const std::string& label : without(everything(), changed.at(table))) CHECK(kept.contains(label));
            const bool differs = check_outputs(before, after);
            if (differs) CHECK(kept.size() < everything().size());
            seen += differs;
            ++parameters;
        }
    }
    CHECK(parameters > 40);
    CHECK(seen > 15);
}

TEST_CASE("keys: seed, method, gather and what is left out", "[frame][frames][keys]") {
    const Case before = base();
    Case after = base();
    after.settings.seed = 2;
    CHECK(same(before, after) ==
          without(lit, {"rsm.disc (key)", "rsm.disc (sun)", "rsm.disc (bulb)"}));
    CHECK(check_outputs(before, after));

    // A pattern of one's own is its rows, wherever they come from.
    auto with_rows = [](const std::string& file, double dx) {
        Case c = base();
        c.settings.rsm.pattern = file;
        c.settings.rsm.own = std::make_shared<const SampleRows>(SampleRows{file, file, {{dx, 0, 1}}});
        return c;
    };
    CHECK(same(with_rows("a.npy", 1), with_rows("b.npy", 1)) == everything());
    for (const Case& c : {with_rows("a.npy", 2), before})
        CHECK(same(with_rows("a.npy", 1), c) ==
              without(everything(), {"rsm.disc (key)", "rsm.disc (sun)", "rsm.disc (bulb)", "compose", "tonemap"}));

    // Another gather is another stage, with another key.
    for (auto gather : {rsm::Gather::paths, rsm::Gather::all}) {
        after = base();
        after.settings.rsm.gather = gather;
        CHECK(same(before, after) == both({"gbuffer", "shadow (key)", "shadow (sun)", "shadow (bulb)", "direct"},
                                          both(maps, traced)));
    }
    // Its parameters are in its key.
    Case paths = base();
    paths.settings.rsm.gather = rsm::Gather::paths;
    for (auto change : {+[](rsm::GatherParams& p) { p.slots = 7; }, +[](rsm::GatherParams& p) { p.steps = 9; },
                        +[](rsm::GatherParams& p) { p.visibility = rsm::Visibility::algorithm_2; },
                        +[](rsm::GatherParams& p) { p.turn = rsm::Turn::hash; }}) {
        after = paths;
        change(after.settings.rsm);
        for (const char* light : {"key", "sun", "bulb"})
            CHECK_FALSE(same(paths, after).contains(std::string("rsm.paths (") + light + ")"));
        CHECK(check_outputs(paths, after));
    }

    // Nothing that emits: with pruning the buffer is not wanted.
    Case unpruned = base();
    for (Material& m : unpruned.scene.materials) m.emission = glm::vec3(0);
    Case pruned = unpruned;
    pruned.settings.pruning = true;
    CHECK_FALSE(same(pruned, unpruned).contains("gbuffer"));
    check_outputs(pruned, unpruned);

    // A light that is off: what stands in its stages' places has keys of its own.
    Case off = pruned;
    off.scene.lights[0].on = false;
    for (const char* label : {"rsm (key)", "shadow (key)", "rsm.disc (key)"})
        CHECK_FALSE(same(pruned, off).contains(label));
    Case moved = off;
    moved.scene.lights[0].position.x += 1;
    for (const char* label : {"rsm (key)", "shadow (key)", "rsm.disc (key)"}) CHECK(same(off, moved).contains(label));

    // A camera that sees nothing: its depth buffer is cleared to 1 or, with reversed z, to 0.
    Case blind = pruned;
    blind.scene.camera.position = {0, 0, 1000}, blind.scene.camera.look_at = {0, 0, 2000};
    Case reversed = blind;
    reversed.scene.camera.reversed_z = true;
    REQUIRE_FALSE(blind.plan().stages[0].needed);
    CHECK_FALSE(same(blind, reversed).contains("gbuffer"));
    CHECK(check_outputs(blind, reversed));
}

TEST_CASE("keys: the instruction set counts for native rays alone", "[frame][frames][keys]") {
    Case c = base();
    CHECK(c.keys(Isa::scalar) == c.keys(supported_isas().back()));
    c.settings.rsm.gather = rsm::Gather::all_rays;
    CHECK(c.keys(Isa::scalar) == c.keys(supported_isas().back()));
    auto differing = [&] {
        Labels labels;
        const std::vector<std::uint64_t> a = c.keys(Isa::scalar), b = c.keys(supported_isas().back());
        for (std::size_t i = 0; i < a.size(); ++i)
            if (a[i] != b[i]) labels.insert(c.plan().stages[i].label);
        return labels;
    };
    c.settings.reference.rays = Rays::native;
    CHECK(differing() == traced);
    c.settings.reference.rays = Rays::exact, c.settings.rsm.rays = Rays::native;
    CHECK(differing() ==
          Labels{"rsm.all_rays (key)", "rsm.all_rays (sun)", "rsm.all_rays (bulb)", "compose", "tonemap"});
}
