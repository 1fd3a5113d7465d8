// Method isr in a frame: its modes, its guard band, layers and cameras, and what may not change the picture.
#include <catch2/catch.hpp>
#include <cstring>

#include "core/error.h"
#include "gi/frame/isr.h"
#include "tests/gi/keys_of.h"
#include "tests/gi/moving_scene.h"

using namespace plumb;

namespace {

// An open box of 2 m, its left wall red and its right one green, with a panel that stands in it, under a spot.
Scene cornell(glm::ivec2 size = {64, 64}) {
    Scene s;
    s.name = "box";
    s.materials.resize(3);
    s.materials[0].reflectance = glm::vec3(0.7f);
    s.materials[1].reflectance = {0.6f, 0.05f, 0.05f};
    s.materials[2].reflectance = {0.1f, 0.5f, 0.1f};
    Mesh& m = s.meshes.emplace_back();
    m.name = "box";
    moving::add_quad(m, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 0);   // floor
    moving::add_quad(m, {-1, 2, -1}, {2, 0, 0}, {0, 0, 2}, 0);   // ceiling
    moving::add_quad(m, {-1, 0, -1}, {2, 0, 0}, {0, 2, 0}, 0);   // back
    moving::add_quad(m, {-1, 0, 1}, {0, 0, -2}, {0, 2, 0}, 1);   // left
    moving::add_quad(m, {1, 0, -1}, {0, 0, 2}, {0, 2, 0}, 2);    // right
    moving::add_quad(m, {-0.6f, 0, 0.1f}, {0.5f, 0, -0.3f}, {0, 0.9f, 0}, 0);
    s.lights.push_back(moving::spot("key", {0.1f, 1.95f, 0.1f}, {0, -1, 0}, 6));
    s.lights.back().cone_inner_deg = 50, s.lights.back().cone_outer_deg = 70, s.lights.back().rsm_size = 128;
    s.camera.position = {0, 1, 3.6}, s.camera.look_at = {0, 1, 0}, s.camera.up = {0, 1, 0};
    s.camera.fov_y_deg = 42, s.camera.near = 0.1, s.camera.far = 20;
    s.frame_size = size;
    return s;
}

frame::Settings isr_settings() {
    frame::Settings settings;
    settings.method = frame::Method::isr;
    settings.isr.rings = 4, settings.isr.spacing = 2;
    return settings;
}

frame::Frame render(const Scene& scene, const frame::Settings& settings) {
    return frame::execute(scene, settings, frame::plan(scene, settings), {});
}

bool same(const Image4& a, const Image4& b) {
    return a.width == b.width && a.height == b.height && !a.empty() &&
           std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

double mean(const Image4& image) {
    double sum = 0;
    for (const glm::vec4& v : image.texels) sum += double(v.x) + double(v.y) + double(v.z);
    return sum / double(3 * image.size());
}

}  // namespace

TEST_CASE("isr: the modes of ISR's appendix D show what they say", "[frame][isr]") {
    const Scene scene = cornell();
    frame::Settings settings = isr_settings();
    auto in_mode = [&](isr::Mode mode) {
        settings.isr.mode = mode;
        return render(scene, settings);
    };
    const frame::Frame f2 = in_mode(isr::Mode::f2), f3 = in_mode(isr::Mode::f3), f4 = in_mode(isr::Mode::f4),
                       f5 = in_mode(isr::Mode::f5);

    // F4 is the method direct, bit for bit; F5 the same without shadows.
    frame::Settings direct = settings;
    direct.method = frame::Method::direct;
    CHECK(same(f4.radiance, render(scene, direct).radiance));
    CHECK(mean(f5.direct) > mean(f4.direct));
    for (std::size_t i = 0; i < f5.visibility.size(); ++i) REQUIRE(f5.visibility[i] == 1.0f);

    // Indirect light is added to F4 and F5: nowhere less, in most places more.
    for (const auto& [with, without] : {std::pair{&f2, &f4}, std::pair{&f3, &f5}}) {
        int more = 0;
        for (std::size_t i = 0; i < with->radiance.size(); ++i) {
            REQUIRE(with->radiance.texels[i].x >= without->radiance.texels[i].x);
            more += with->radiance.texels[i].x > without->radiance.texels[i].x;
        }
        CHECK(more > int(with->radiance.size()) / 2);
    }
    CHECK(same(f2.direct, f4.direct));
    CHECK(same(f3.direct, f5.direct));
}

namespace {

// The same room, `length` times as large, under lamps that make `light` times the irradiance.
Scene scaled(const Scene& scene, double length, double light) {
    Scene s = scene;
    for (Mesh& mesh : s.meshes)
        for (Vertex& v : mesh.vertices) v.position *= float(length);
    for (Light& lamp : s.lights) lamp.position *= float(length), lamp.intensity *= float(length * length * light);
    s.camera.position *= length, s.camera.look_at *= length;
    s.camera.near *= length, s.camera.far *= length;
    return s;
}

}  // namespace

TEST_CASE("isr: published, the picture is the same for every scale of lamps and of the scene", "[frame][isr][ISR (29)]") {
    const Scene scene = cornell();
    frame::Settings settings = isr_settings();
    settings.isr.variant = isr::Variant::published, settings.isr.k_ssao = 1, settings.isr.k_isr = 0.5f;
    settings.isr.solid_angle = isr::SolidAngle::none;
    auto shown = [&](double length, double light) {
        frame::Settings s = settings;
        s.shadow.bias *= float(length), s.tonemap.exposure /= float(light);
        return render(scaled(scene, length, light), s);
    };
    const frame::Frame once = shown(1, 1);
    // Indirect light and occlusion are there to be seen.
    frame::Settings without = settings;
    without.isr.k_isr = 0;
    CHECK(mean(once.display) > 1.01 * mean(render(scene, without).display));
    without.isr.k_ssao = 0;
    const frame::Frame direct = render(scene, without);
    without.isr.k_ssao = 1;
    CHECK(mean(render(scene, without).display) < 0.995 * mean(direct.display));
    // To the bit by powers of two.
    CHECK(same(shown(1, 128).display, once.display));
    CHECK(same(shown(8, 1).display, once.display));
    CHECK(same(shown(0.25, 1024).display, once.display));
    // By other factors up to roundings: of vertices, which move silhouettes and shadows by a pixel, hence the share.
    for (const auto& [length, light] : {std::pair{1.0, 100.0}, std::pair{10.0, 1.0}, std::pair{10.0, 100.0}}) {
        CAPTURE(length, light);
        const frame::Frame other = shown(length, light);
        int off = 0;
        for (std::size_t i = 0; i < other.display.size(); ++i)
            for (int c = 0; c < 3; ++c)
                off += !(std::abs(double(other.display.texels[i][c]) - double(once.display.texels[i][c])) <= 1e-4);
        CHECK(off <= int(other.display.size()) / 100);
    }
}

TEST_CASE("isr: every convention sees the same picture, Direct3D 9's half pixel included", "[frame][isr]") {
    const frame::Settings settings = isr_settings();
    Scene scene = cornell({61, 47});
    const frame::Frame canonical = render(scene, settings);
    REQUIRE(mean(canonical.indirect) > 0);
    for (const Convention c : {Convention::d3d11, Convention::d3d9, Convention::left_handed}) {
        CAPTURE(rules(c).name);
        scene.convention = c;
        const frame::Frame other = render(scene, settings);
        CHECK(same(canonical.radiance, other.radiance));
        CHECK(same(canonical.indirect, other.indirect));
    }
    // OpenGL's depth -1..1 costs half a unit in the last place of w (core/convention.h).
    scene.convention = Convention::opengl;
    const frame::Frame other = render(scene, settings);
    double worst = 0;
    for (std::size_t i = 0; i < other.radiance.size(); ++i)
        worst = std::max(worst, std::abs(double(other.radiance.texels[i].x) - canonical.radiance.texels[i].x));
    CHECK(worst <= 1e-4 * mean(canonical.radiance));
}

TEST_CASE("isr: the layout of ISR fig. 4.1 gives the picture of fp32 within its normals' eight bits", "[frame][isr]") {
    const Scene scene = cornell();
    frame::Settings settings = isr_settings();
    const frame::Frame exact = render(scene, settings);
    settings.layout = raster::Layout::isr;
    const frame::Frame stored = render(scene, settings);
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < exact.indirect.size(); ++i) {
        difference += std::abs(double(stored.indirect.texels[i].x) - exact.indirect.texels[i].x);
        sum += exact.indirect.texels[i].x;
    }
    REQUIRE(sum > 0);
    CHECK(difference > 0);
    CHECK(difference < 0.02 * sum);  // 1/255 of a component turns a normal by 0.2 to 0.4 degrees
}

TEST_CASE("isr: how positions are rebuilt changes no more than roundings", "[frame][isr]") {
    const Scene scene = cornell();
    frame::Settings settings = isr_settings();
    settings.isr.blur = isr::Blur::gaussian;  // automatic is another blur with inverse matrices
    const frame::Frame linear = render(scene, settings);
    settings.isr.position = isr::Position::inverse_matrix;
    const frame::Frame inverse = render(scene, settings);
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < linear.indirect.size(); ++i) {
        difference += std::abs(double(inverse.indirect.texels[i].x) - linear.indirect.texels[i].x);
        sum += linear.indirect.texels[i].x;
    }
    REQUIRE(sum > 0);
    CHECK(difference > 0);
    CHECK(difference < 1e-3 * sum);
}

TEST_CASE("isr: a guard band sends light to the border, and leaves what is out of its reach alone", "[frame][isr]") {
    // A camera near the floor, so that the frame's border cuts through lit surfaces.
    Scene scene = cornell({96, 96});
    scene.camera.fov_y_deg = 25;
    frame::Settings settings = isr_settings();
    settings.isr.blur = isr::Blur::none;
    const frame::Frame without = render(scene, settings);
    settings.isr.guard = 32;
    const frame::Frame with = render(scene, settings);
    const Image4 &a = without.isr.gathered.back(), &b = with.isr.gathered.back();
    REQUIRE(a.width == b.width);
    const int reach = isr::gather_pattern(settings.isr, a.height).reach;
    double border_gain = 0, middle_change = 0, middle = 0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x) {
            const bool inside = x >= reach && y >= reach && x < a.width - reach && y < a.height - reach;
            const double change = double(b(x, y).x) - a(x, y).x;
            if (inside)
                middle_change += std::abs(change), middle += a(x, y).x;
            else
                border_gain += change;
        }
    CHECK(border_gain > 0);
    REQUIRE(middle > 0);
    // The wider view's pixels are the frame's up to roundings of its projection.
    CHECK(middle_change < 1e-3 * middle);
}

TEST_CASE("isr: layers and cameras add light that the frame does not see, and never take any", "[frame][isr]") {
    const Scene scene = cornell();
    for (const bool camera : {false, true}) {
        CAPTURE(camera);
        frame::Settings settings = isr_settings();
        settings.isr.blur = isr::Blur::none;
        const frame::Frame alone = render(scene, settings);
        if (camera)
            settings.isr.cameras = 2;
        else
            settings.isr.layers = 2;
        const frame::Frame more = render(scene, settings);
        double gain = 0;
        for (std::size_t i = 0; i < alone.isr.lit.size(); ++i) {
            // The sum of form factors grows; where it stays at most 1 no light is lost.
            const float before = alone.isr.gathered.back().texels[i].w, after = more.isr.gathered.back().texels[i].w;
            CHECK(after >= before * (1 - 1e-6f));
            if (after <= 1) CHECK(more.isr.lit.texels[i].x >= alone.isr.lit.texels[i].x * (1 - 1e-5f));
            gain += double(more.isr.lit.texels[i].x) - alone.isr.lit.texels[i].x;
        }
        CHECK(gain > 0);
    }
}

TEST_CASE("isr: a camera that sees what the frame sees adds nothing", "[frame][isr]") {
    // Turned by a hair: nearly every surface of it is seen. What remains lies along edges, where a coarse pixel of the camera
    // is half another surface; it falls with the pixel's side.
    const Scene scene = cornell({256, 256});
    frame::Settings settings = isr_settings();
    settings.isr.blur = isr::Blur::none;
    const frame::Frame alone = render(scene, settings);
    settings.isr.cameras = 1, settings.isr.camera_angle = 1;
    const frame::Frame more = render(scene, settings);
    CHECK(mean(more.isr.lit) < 1.02 * mean(alone.isr.lit));
    CHECK(mean(more.isr.lit) >= mean(alone.isr.lit));
}

TEST_CASE("isr: cameras turn about what the frame shows, however far along its axis look_at lies", "[frame][isr]") {
    Scene scene = cornell();
    frame::Settings settings = isr_settings();
    settings.isr.cameras = 4;
    const frame::Frame near = render(scene, settings);
    // Four cameras that turn by 30 degrees about a point in the room stand near it; what they see is light that the frame lacks.
    settings.isr.cameras = 0;
    CHECK(mean(near.isr.lit) > 1.02 * mean(render(scene, settings).isr.lit));
    settings.isr.cameras = 4;
    // Along the axis z the direction is the same to the bit.
    for (const double z : {3.5, -40.0, -1e6}) {
        CAPTURE(z);
        scene.camera.look_at.z = z;
        const frame::Frame other = render(scene, settings);
        CHECK(same(near.radiance, other.radiance));
        CHECK(same(near.isr.lit, other.isr.lit));
    }
    // In the middle of the frame at the median depth: halfway from the eye the room's surfaces are nearer and farther.
    const std::vector<frame::IsrView> views = frame::isr_views(scene, settings);
    std::vector<float> depths;
    for (std::size_t i = 0; i < near.gbuffer.normal.size(); ++i)
        if (near.gbuffer.normal.texels[i].w > 0) depths.push_back(near.gbuffer.position.texels[i].w);
    std::sort(depths.begin(), depths.end());
    const double low = double(depths[depths.size() * 45 / 100]), high = double(depths[depths.size() * 55 / 100]);
    REQUIRE(views.size() == 5);
    for (std::size_t v = 1; v < views.size(); ++v) {
        const Camera& camera = views[v].camera;
        const double depth = scene.camera.position.z - camera.look_at.z;
        CHECK(camera.look_at.x == 0.0);
        CHECK(camera.look_at.y == 1.0);
        CHECK(depth >= low);
        CHECK(depth <= high);
        const glm::dvec3 from = camera.position - camera.look_at;
        CHECK(std::sqrt(from.x * from.x + from.y * from.y + from.z * from.z) == Approx(depth).epsilon(1e-12));
    }
    // Nothing to see: about the point that it looks at.
    scene.meshes.clear();
    scene.camera.look_at = {0, 1, 1.6};
    for (const frame::IsrView& view : frame::isr_views(scene, settings))
        if (view.kind == frame::ViewKind::camera) CHECK(view.camera.look_at.z == Approx(1.6).epsilon(1e-12));
}

TEST_CASE("isr: at native resolution nothing is averaged and nothing upsampled", "[frame][isr][ISR 6]") {
    const glm::ivec2 size(61, 47);
    const Scene scene = cornell(size);
    frame::Settings settings = isr_settings();
    settings.isr.resolution = isr::Resolution::native;
    for (const isr::Blur blur : {isr::Blur::none, isr::Blur::gaussian})
        for (const int guard : {0, 6}) {
            CAPTURE(int(blur), guard);
            settings.isr.blur = blur, settings.isr.guard = guard, settings.isr.k_ssao = 0.5f;
            const frame::Plan plan = frame::plan(scene, settings);
            for (const auto& stage : plan.stages) CHECK(stage.name != "isr.upsample");
            const frame::Frame f = frame::execute(scene, settings, plan, {});
            // The surfaces are the G-buffer's own, with their light.
            REQUIRE(f.isr.surface.width == size.x);
            REQUIRE(f.indirect.height == size.y);
            const Image4& sent = guard > 0 ? f.views[1].radiosity : f.isr.radiosity;
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    const glm::vec4 s = f.isr.surface(x, y), n = f.gbuffer.normal(x, y);
                    CHECK(s.w == f.gbuffer.position(x, y).w);
                    CHECK(std::abs(s.x - n.x) + std::abs(s.y - n.y) + std::abs(s.z - n.z) <= 1e-6f);
                    if (guard == 0)
                        CHECK(sent(x, y).x == Approx(f.gbuffer.albedo(x, y).x * f.direct(x, y).x + f.gbuffer.emission(x, y).x).epsilon(1e-6));
                }
            if (blur == isr::Blur::none) {
                bool lit = false;
                for (std::size_t i = 0; i < f.indirect.size(); ++i) {
                    const glm::vec4 a = f.indirect.texels[i], b = f.isr.gathered.back().texels[i];
                    CHECK(glm::vec3(a) == glm::vec3(b));
                    lit = lit || b.x > 0;
                }
                CHECK(lit);
            }
        }
    // The same light as in a quarter of the pixels of a frame twice as large, whose coarse pixels lie where these do.
    frame::Settings quarter = isr_settings();
    const frame::Frame of_quarter = render(cornell(2 * size), quarter);
    quarter.isr.resolution = isr::Resolution::native;
    const frame::Frame of_native = render(scene, quarter);
    REQUIRE(of_quarter.isr.lit.size() == of_native.isr.lit.size());
    double off = 0, sum = 0;
    for (std::size_t i = 0; i < of_native.isr.lit.size(); ++i) {
        off += std::abs(double(of_native.isr.lit.texels[i].x) - double(of_quarter.isr.lit.texels[i].x));
        sum += double(of_quarter.isr.lit.texels[i].x);
    }
    CHECK(off < 0.05 * sum);
    CHECK(off > 0);
}

TEST_CASE("isr: bounces grow to a limit that keeps energy", "[frame][isr]") {
    const Scene scene = cornell();
    frame::Settings settings = isr_settings();
    double last = 0, first_step = 0;
    for (const int bounces : {1, 2, 3, 8, 16}) {
        settings.isr.bounces = bounces;
        const double now = mean(render(scene, settings).indirect);
        CAPTURE(bounces, now, last);
        CHECK(now >= last);
        if (bounces == 2) first_step = now - last;
        if (bounces == 16) CHECK(now - last < 0.1 * first_step);
        last = now;
    }
}

TEST_CASE("isr: what one setting alone cannot say is refused in one line", "[frame][isr][error]") {
    using Catch::Contains;
    Scene scene = cornell();
    frame::Settings settings = isr_settings();
    auto refusal = [&] {
        try {
            frame::plan(scene, settings);
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    CHECK(refusal() == "");
    settings.isr.guard = 3;
    CHECK_THAT(refusal(), Contains("guard = 3: expected an even number"));
    settings.isr.guard = 0, settings.isr.rotations = 3;
    CHECK_THAT(refusal(), Contains("rotations = 3: expected a power of two"));
    settings.isr.rotations = 1, settings.isr.far_rings = 1;
    CHECK_THAT(refusal(), Contains("far_rings = 1: expected a full_depth above 0"));
    settings.isr.full_depth = 1, settings.isr.far_rings = 9;
    CHECK_THAT(refusal(), Contains("far_rings = 9: expected at most rings = 4"));
    settings.isr.far_rings = 0, settings.isr.variant = isr::Variant::published, settings.isr.cameras = 1;
    CHECK_THAT(refusal(), Contains("ISR prints no equation"));
    settings.isr.cameras = 0;
    CHECK(refusal() == "");
    scene.camera.far = std::numeric_limits<double>::infinity();
    CHECK_THAT(refusal(), Contains("far is infinite"));
}

TEST_CASE("isr: a parameter changes the keys of all stages whose result it changes, and of none before them",
          "[frame][isr][keys]") {
    const Scene scene = cornell();
    frame::Settings before = isr_settings();
    before.pruning = false;
    const test::Ran old(scene, before);
    int changed = 0, kept = 0;
    for (std::size_t i = 0; i < isr::fields(before.isr).size(); ++i) {
        frame::Settings after = before;
        Field field = isr::fields(after.isr)[i];
        CAPTURE(field.name);
        if (field.name == "pattern") after.isr.spacing = 0;  // it is the grid's
        if (field.name == "far_rings") after.isr.full_depth = 1, after.isr.far_rings = 0;
        if (auto* p = std::get_if<int*>(&field.value)) **p = field.choices.empty() ? 2 * **p + 2 : (**p + 1) % int(field.choices.size());
        if (auto* p = std::get_if<float*>(&field.value)) **p = **p == 0 ? 0.5f : 0.75f * **p;
        const test::Ran now(scene, after);
        // Stages of the same label in both plans.
        int same_before = 0;
        std::vector<std::string> new_keys;
        for (std::size_t a = 0; a < old.plan.stages.size(); ++a)
            for (std::size_t b = 0; b < now.plan.stages.size(); ++b) {
                const std::string& label = old.plan.stages[a].label;
                if (label != now.plan.stages[b].label) continue;
                CAPTURE(label);
                const bool same = old.keys[a] == now.keys[b];
                if (!same) new_keys.push_back(label);
                if (same) CHECK(test::same_bytes(old.outputs.at(label), now.outputs.at(label)));
                kept += same;
                same_before += same && !label.starts_with("isr.");
            }
        const bool shadowless = field.name == "mode" && !frame::casts_shadows(after);
        if (!shadowless) CHECK(same_before >= 4);  // gbuffer, rsm, shadow, direct
        if (field.name == "k_isr") CHECK(new_keys == std::vector<std::string>{"isr.compose", "tonemap"});
        if (field.name == "blur_sigma")
            CHECK(new_keys == std::vector<std::string>{"isr.blur (horizontal)", "isr.blur (vertical)", "isr.upsample",
                                                       "isr.compose", "tonemap"});
        ++changed;
    }
    CHECK(changed > 20);
    CHECK(kept > 150);  // of 24 times 18
}
