// Additional cameras of image-space radiosity: isr.unseen and isr.gather_camera against the geometry of two cameras, worked
// out from their axes and angles of view in double, and not from the vectors that the stages use.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/host_math.h"
#include "gi/isr/isr.h"
#include "tests/gi/random_scene.h"

using namespace plumb;
using namespace plumb::isr;

namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// A pinhole over a frame of `size` pixels, by its axes.
struct Pinhole {
    Camera camera;
    glm::ivec2 size;

    CameraAxes at() const { return axes(camera); }
    double half_height() const { return host::tan(camera.fov_y_deg * host::pi / 360); }
    // The point at eye depth z that the window position shows.
    glm::dvec3 point(const glm::dvec2& window, double z) const {
        const CameraAxes a = at();
        const double y = (1 - 2 * window.y / size.y) * half_height(),
                     x = (2 * window.x / size.x - 1) * half_height() * size.x / size.y;
        return camera.position + z * (a.forward + x * a.right + y * a.up);
    }
    double depth(const glm::dvec3& x) const { return dot(x - camera.position, at().forward); }
    glm::dvec2 window(const glm::dvec3& x) const {
        const CameraAxes a = at();
        const glm::dvec3 d = x - camera.position;
        const double z = depth(x), h = half_height();
        return {(dot(d, a.right) / (z * h) * size.y / size.x + 1) / 2 * size.x, (1 - dot(d, a.up) / (z * h)) / 2 * size.y};
    }
    CoarseCamera coarse() const { return coarse_camera(camera, size); }
};

Pinhole pinhole(test::Dice& dice, glm::ivec2 size) {
    Pinhole p{{}, size};
    p.camera.position = glm::dvec3(dice.away(4, 8));
    p.camera.look_at = glm::dvec3(dice.in_box(glm::vec3(-0.3f), glm::vec3(0.3f)));
    p.camera.up = {0.1, 1, 0.2};
    p.camera.fov_y_deg = dice.between(30, 60);
    p.camera.near = 0.05, p.camera.far = 100;
    return p;
}

// A coarse pixel's centre is the corner that its four pixels share.
glm::dvec2 centre_of(glm::ivec2 coarse) { return glm::dvec2(2 * coarse + 1); }
glm::ivec2 coarse_of(const glm::dvec2& window) {
    return {int(std::floor(window.x / 2)), int(std::floor(window.y / 2))};
}
bool inside(glm::ivec2 p, glm::ivec2 size) { return p.x >= 0 && p.y >= 0 && p.x < size.x && p.y < size.y; }
// Where a rounding of floats decides for no other pixel.
bool well_within(const glm::dvec2& window) {
    for (int c = 0; c < 2; ++c) {
        const double of_pixel = window[c] / 2 - std::floor(window[c] / 2);
        if (of_pixel < 0.02 || of_pixel > 0.98) return false;
    }
    return true;
}

}  // namespace

TEST_CASE("isr.unseen: what another view sees at its place is left out, what it does not stays", "[isr][cameras]") {
    int tried = 0;
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        CAPTURE(seed);
        test::Dice dice(seed);
        const Pinhole extra = pinhole(dice, {48, 36}), view = pinhole(dice, {64, 40});
        const int margin = dice.below(2) * 5;
        const glm::ivec2 extra_size = coarse_size(extra.size), view_size = coarse_size(view.size) + 2 * margin;

        // One surface of the extra camera, and its pixel in the view: with the margin, it may lie beyond the frame.
        const glm::ivec2 from{dice.below(extra_size.x), dice.below(extra_size.y)};
        const glm::dvec3 x = extra.point(centre_of(from), dice.between(3, 7));
        if (view.depth(x) < 0.5) continue;
        const glm::dvec2 window = view.window(x);
        const glm::ivec2 to = coarse_of(window) + margin;
        if (!well_within(window) || !inside(to, view_size)) continue;
        ++tried;

        Image4 surface(extra_size.x, extra_size.y);
        surface(from.x, from.y) = glm::vec4(0, 1, 0, float(extra.depth(x)));
        UnseenInputs in;
        in.surface = &surface, in.camera = extra.coarse(), in.view = view.coarse(), in.margin = margin;
        auto kept = [&](glm::ivec2 at, double depth) {
            Image4 other(view_size.x, view_size.y);
            if (inside(at, view_size)) other(at.x, at.y) = glm::vec4(0, 0, 1, float(depth));
            in.view_surface = &other;
            Image4 result;
            run(IsrParams{}, in, {}, result);
            return result(from.x, from.y) == surface(from.x, from.y);
        };
        const double depth = view.depth(x);
        CHECK_FALSE(kept(to, depth));         // the view sees it
        CHECK_FALSE(kept(to, 1.5 * depth));   // it lies before what the view sees
        CHECK(kept(to, 0.8 * depth));         // something hides it
        CHECK(kept(to, 0));                   // the view sees nothing there
        // Beside its pixel the view sees another point.
        for (const glm::ivec2 step : {glm::ivec2(1, 0), glm::ivec2(-1, 0), glm::ivec2(0, 1), glm::ivec2(0, -1)})
            CHECK(kept(to + step, depth));
    }
    CHECK(tried > 100);
}

TEST_CASE("isr.gather_camera: one patch that only the camera sees sends its form factor's light", "[isr][cameras]") {
    IsrParams params;
    params.rings = 3, params.spacing = 2;
    const Pattern pattern = gather_pattern(params, 18);
    int tried = 0;
    for (std::uint32_t seed = 0; seed < 600; ++seed) {
        CAPTURE(seed);
        test::Dice dice(seed);
        const Pinhole eye = pinhole(dice, {64, 40}), extra = pinhole(dice, {48, 36});
        const glm::ivec2 size = coarse_size(eye.size), extra_size = coarse_size(extra.size);

        // A receiver, and a patch one sample away from where it projects to.
        const glm::ivec2 from{dice.below(size.x), dice.below(size.y)};
        const glm::dvec3 p = eye.point(centre_of(from), dice.between(3, 7));
        if (extra.depth(p) < 0.5) continue;
        const glm::dvec2 window = extra.window(p);
        const std::int32_t offset = pattern.offsets[std::size_t(dice.below(pattern.samples))];
        const glm::ivec2 to = coarse_of(window) + glm::ivec2((offset << 16) >> 16, offset >> 16);
        if (!well_within(window) || !inside(to, extra_size)) continue;
        const double z = extra.depth(p) * double(dice.between(0.7f, 1.3f));
        const glm::dvec3 x = extra.point(centre_of(to), z), d = x - p;
        const glm::vec3 n_p = normalize3<float>(glm::vec3(d) + 0.5f * dice.direction() * float(std::sqrt(dot(d, d)))),
                        n_x = normalize3<float>(-glm::vec3(d) + 0.5f * dice.direction() * float(std::sqrt(dot(d, d))));
        const double d2 = dot(d, d), cos_p = dot(glm::dvec3(n_p), d), cos_x = -dot(glm::dvec3(n_x), d);
        if (cos_p <= 0.05 * std::sqrt(d2) || cos_x <= 0.05 * std::sqrt(d2)) continue;
        ++tried;

        // What a coarse pixel of the camera, two by two samples apart, covers of the patch's plane.
        const double side = 4 * extra.half_height() / extra.size.y * z * double(params.spacing);
        const glm::dvec3 ray = (x - extra.camera.position) / z;
        const double slope = std::max(std::abs(dot(glm::dvec3(n_x), ray)),
                                      double(params.least_cosine) * std::sqrt(dot(ray, ray)));
        const double area = side * side / slope;
        const double form = cos_p * cos_x / d2 * area / (host::pi * d2 + area);

        Image4 surface(size.x, size.y), sources(extra_size.x, extra_size.y), light(extra_size.x, extra_size.y);
        surface(from.x, from.y) = glm::vec4(n_p, float(eye.depth(p)));
        sources(to.x, to.y) = glm::vec4(n_x, float(z));
        light(to.x, to.y) = {2, 3, 5, 0};
        CameraGatherInputs in;
        in.surface = &surface, in.camera = eye.coarse();
        in.source_surface = &sources, in.source_radiosity = &light, in.source_camera = extra.coarse();
        in.pattern = &pattern;
        Image4 gathered;
        run(params, in, {}, gathered);
        const glm::vec4 got = gathered(from.x, from.y);
        CHECK(double(got.w) == Approx(form).epsilon(2e-5));
        CHECK(double(got.x) == Approx(2 * form / std::max(1.0, form)).epsilon(2e-5));
        CHECK(double(got.z) == Approx(5 * form / std::max(1.0, form)).epsilon(2e-5));

        // A source before it: sums go on where they were.
        Image4 before(size.x, size.y, glm::vec4(1, 1, 1, 2));
        in.before = &before;
        run(params, in, {}, gathered);
        CHECK(double(gathered(from.x, from.y).w) == Approx(2 + form).epsilon(2e-5));
        CHECK(double(gathered(from.x, from.y).x) == Approx((2 + 2 * form) / (2 + form)).epsilon(2e-5));

        // A patch that the pattern does not reach sends nothing.
        in.before = nullptr;
        std::fill(sources.texels.begin(), sources.texels.end(), glm::vec4(0));
        const glm::ivec2 far = to + glm::ivec2(1, 1);
        if (inside(far, extra_size)) sources(far.x, far.y) = glm::vec4(n_x, float(z));
        run(params, in, {}, gathered);
        CHECK(gathered(from.x, from.y).w == 0);
    }
    CHECK(tried > 100);
}

TEST_CASE("isr.unseen, isr.gather_camera: the same bits by every instruction set and thread count", "[isr][cameras][bits]") {
    test::Dice dice(5);
    const Pinhole eye = pinhole(dice, {75, 41}), extra = pinhole(dice, {61, 37});
    const glm::ivec2 size = coarse_size(eye.size), extra_size = coarse_size(extra.size);
    auto noise = [&](glm::ivec2 s, float low, float high) {
        Image4 image(s.x, s.y);
        for (glm::vec4& v : image.texels)
            if (!dice.one_in(6)) v = glm::vec4(dice.direction(), dice.between(low, high));
        return image;
    };
    const Image4 surface = noise(size, 3, 7), sources = noise(extra_size, 3, 7), light = noise(extra_size, 0, 1);
    IsrParams params;
    params.rings = 3, params.spacing = 1, params.rotations = 4;
    const Pattern pattern = gather_pattern(params, 18);
    UnseenInputs unseen;
    unseen.surface = &sources, unseen.camera = extra.coarse(), unseen.view_surface = &surface, unseen.view = eye.coarse();
    CameraGatherInputs gather;
    gather.surface = &surface, gather.camera = eye.coarse(), gather.source_surface = &sources;
    gather.source_radiosity = &light, gather.source_camera = extra.coarse(), gather.pattern = &pattern;
    Image4 first_unseen, first_gathered;
    RunOptions scalar;
    scalar.isa = Isa::scalar, scalar.threads = 1;
    run(params, unseen, scalar, first_unseen);
    run(params, gather, scalar, first_gathered);
    double sum = 0;
    for (const glm::vec4& v : first_gathered.texels) sum += double(v.w);
    REQUIRE(sum > 0);
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            Image4 again;
            run(params, unseen, options, again);
            CHECK(std::memcmp(again.data(), first_unseen.data(), again.size() * sizeof(glm::vec4)) == 0);
            run(params, gather, options, again);
            CHECK(std::memcmp(again.data(), first_gathered.data(), again.size() * sizeof(glm::vec4)) == 0);
        }
}
