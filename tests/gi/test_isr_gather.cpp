// The gathering stages of image-space radiosity: the camera, downsampling, gather, ambient occlusion, bounces.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/hash.h"
#include "gi/isr/isr.h"
#include "gi/isr/isr.h"
#include "core/scene.h"
#include "raster/gbuffer.h"
#include "tests/gi/random_scene.h"

using namespace plumb;
using namespace plumb::isr;

namespace {

const Convention conventions[] = {Convention::vulkan, Convention::opengl, Convention::d3d11, Convention::d3d9,
                                  Convention::left_handed};

constexpr int some_height = 20;  // of a frame, coarse pixels

Camera some_camera() {
    Camera camera;
    camera.position = {3.1, 2.2, -4.7}, camera.look_at = {-0.4, 0.7, 0.2}, camera.up = {0.1, 1, 0.05};
    camera.fov_y_deg = 62, camera.near = 0.05, camera.far = 300;
    return camera;
}

double length(const glm::dvec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }
double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

bool same_bits(const Image4& a, const Image4& b) {
    return a.width == b.width && a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}
bool finite(const glm::vec4& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) && std::isfinite(v.w);
}

float noise(int x, int y, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(x, y, channel, 11).x); }

// Surfaces of noise, some without one, with light and reflectance; `margin` pixels of sources around the receivers.
struct Noise {
    CoarseCamera camera;
    Image4 surface, source_surface, source_radiosity, reflectance;
    int margin;

    explicit Noise(glm::ivec2 size, int around = 0, double scale = 1, float wall = 0.1f)
        : surface(size.x, size.y), source_surface(size.x + 2 * around, size.y + 2 * around),
          source_radiosity(source_surface.width, source_surface.height), reflectance(size.x, size.y), margin(around) {
        camera = coarse_camera(some_camera(), 2 * size, 2 * around);
        for (int y = 0; y < source_surface.height; ++y)
            for (int x = 0; x < source_surface.width; ++x) {
                source_radiosity(x, y) = {noise(x, y, 1), 3 * noise(x, y, 2), noise(x, y, 3), noise(x, y, 9)};
                if (noise(x, y, 4) < wall) continue;
                const glm::vec3 n(noise(x, y, 5) - 0.5f, noise(x, y, 6) - 0.5f, noise(x, y, 7) - 0.5f);
                source_surface(x, y) = glm::vec4(normalize3<float>(n), float(scale * (2 + 0.3 * double(noise(x, y, 8)))));
            }
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                surface(x, y) = source_surface(x + around, y + around);
                reflectance(x, y) = {noise(x, y, 20), noise(x, y, 21), noise(x, y, 22), 0};
            }
    }
    GatherInputs gather(const Pattern& pattern) const {
        GatherInputs in;
        in.surface = &surface, in.source_surface = &source_surface, in.source_radiosity = &source_radiosity;
        in.camera = camera, in.margin = margin, in.pattern = &pattern, in.seed = 5;
        return in;
    }
    SsaoInputs ssao(const Pattern& pattern) const {
        SsaoInputs in;
        in.surface = &surface, in.source_surface = &source_surface;
        in.camera = camera, in.margin = margin, in.pattern = &pattern, in.seed = 5;
        return in;
    }
};

Image4 gathered(const IsrParams& params, const GatherInputs& in, const RunOptions& options = {}) {
    Image4 out;
    run(params, in, options, out);
    return out;
}
Image4 occluded(const IsrParams& params, const SsaoInputs& in, const RunOptions& options = {}) {
    Image4 out;
    run(params, in, options, out);
    return out;
}

RunOptions scalar() {
    RunOptions options;
    options.isa = Isa::scalar, options.threads = 1;
    return options;
}

// Rings that reach beyond small images, all rotations of which differ.
void in_rings(IsrParams& params) { params.pattern = PatternKind::rings, params.spacing = 0, params.reach = 0.6f, params.growth = 1.5f; }

IsrParams small_params() {
    IsrParams params;
    params.rings = 3, params.spacing = 2, params.ssao_rings = 2, params.ssao_spacing = 1;
    return params;
}

// The equations in double, written as the README has them, with what rounding may change.
struct Reference {
    glm::dvec3 irradiance{0};
    double forms = 0, occlusion = 0;
    double forms_error = 0, light_error = 0, occlusion_error = 0;
};
Reference expected_of(const Noise& room, const IsrParams& params, const Pattern& pattern, bool ssao, int px, int py) {
    const bool published = params.variant == Variant::published;
    const double u = 0x1p-24;
    auto ray = [&](int x, int y) { return room.camera.f_o + double(x) * room.camera.f_u + double(y) * room.camera.f_v; };
    const glm::dvec4 s_p(room.surface(px, py));
    const glm::dvec3 n_p(s_p), x_p = ray(px, py) * s_p.w;
    Reference r;
    glm::dvec3 sum(0);
    double largest = 0;
    for (int k = 0; k < pattern.samples; ++k) {
        const std::int32_t packed = pattern.offsets[std::size_t(k)];
        const int dx = std::int16_t(packed & 0xffff), dy = packed >> 16;
        const int x = px + dx + room.margin, y = py + dy + room.margin;
        if (x < 0 || y < 0 || x >= room.source_surface.width || y >= room.source_surface.height) continue;
        const glm::dvec4 s(room.source_surface(x, y));
        const glm::dvec3 n(s), along = ray(px + dx, py + dy), d = along * s.w - x_p;
        if (dot(n, n) == 0) continue;
        const double distance = length(d), cos_p = std::max(0.0, dot(n_p, d) / distance);
        const double cos_x = std::max(0.0, -dot(n, d) / distance), spacing = pattern.side;
        const double slope = std::max(std::abs(dot(n, along)), double(params.least_cosine) * length(along));
        const double head_on = std::pow(room.camera.footprint * s.w * spacing, 2);
        const double area = head_on / (published ? 1 : slope);
        // Positions err by some units of their own length; d by as much, its direction by that over |d|. Cosines move with
        // it, the slope with |r| over itself.
        const double off = 8 * u * (length(x_p) + length(along * s.w)) / distance;
        const double off_area = 16 * u * (1 + length(along) / slope);
        if (ssao) {
            const double ratio = std::min(1.0, head_on / M_PI / (distance * distance));
            const double unit = published && params.length_unit > 0 ? distance / double(params.length_unit) : 1;
            const double cap = (published ? 1 - std::sqrt(1 - ratio) : ratio) * unit;
            r.occlusion += cap * cos_p;
            // At ratio = 1 the cap's slope has no bound; its square root errs by the root of what the ratio does.
            const double root = published && ratio > 0.9 ? std::sqrt(2 * off + 16 * u) * unit : 0;
            r.occlusion_error += cap * (5 * off + 32 * u) + root;
            continue;
        }
        const double pattern_weight = double(pattern.weights[std::size_t(k)]);
        const bool by_angle = published && params.solid_angle == SolidAngle::hemisphere;
        // A sample whose cosine is nearly 0 may face away after rounding: then it is all of the error.
        const double weight = by_angle ? 1 / M_PI : area / (M_PI * distance * distance + (published ? 0 : area));
        const bool faces = by_angle ? cos_x > 0 : true;
        const double form = cos_p * (by_angle ? double(faces) : cos_x) * weight * pattern_weight;
        const double edge = by_angle && cos_x <= 4 * off ? cos_p * weight : 0, error = pattern_weight * weight * (4 * off + off_area + 16 * u) + edge;
        const glm::dvec3 b(room.source_radiosity(x, y));
        r.forms += form, sum += form * b;
        largest = std::max(largest, std::max(b.x, std::max(b.y, b.z)));
        r.forms_error += error + pattern.samples * u * form;
    }
    if (ssao) {
        const double scale = published && params.solid_angle != SolidAngle::none ? 2 * M_PI / pattern.samples : 1;
        r.occlusion *= scale, r.occlusion_error = scale * r.occlusion_error + pattern.samples * u * r.occlusion;
        return r;
    }
    const double mask = double(room.source_radiosity(px + room.margin, py + room.margin).w);
    const double part = params.solid_angle == SolidAngle::none ? 1 : 2 * M_PI / pattern.samples;
    const double share = published ? mask * part : 1 / std::max(1.0, r.forms);
    r.irradiance = sum * share;
    // E = sum / max(1, S): both move.
    r.light_error = 2 * r.forms_error * share * largest + 8 * u * largest * share * r.forms;
    return r;
}

}  // namespace

// ---- The camera ----------------------------------------------------------------------------------------------------

TEST_CASE("isr: coarse pixels' rays go through the corners that full pixels share", "[isr][ISR (24)][analytic]") {
    for (glm::ivec2 size : {glm::ivec2(64, 48), glm::ivec2(33, 17), glm::ivec2(1, 1)})
        for (int guard : {0, 8}) {
            CAPTURE(size.x, size.y, guard);
            const Camera camera = some_camera();
            const CoarseCamera c = coarse_camera(camera, size, guard);
            CHECK(c.size == coarse_size(size) + guard);
            for (int y = -guard / 2; y < c.size.y - guard / 2; ++y)
                for (int x = -guard / 2; x < c.size.x - guard / 2; ++x) {
                    const glm::dvec3 ray = c.f_o + double(x) * c.f_u + double(y) * c.f_v;
                    const Ray expected = ray_through(camera, size, {2 * x + 1, 2 * y + 1});
                    const double z = dot(axes(camera).forward, expected.direction);
                    CHECK(length(ray - expected.direction / z) <= 1e-12);
                    // The inverse of the projection of this rectangle.
                    const double ndc_x = 2 * (x + guard / 2 + 0.5) / c.size.x - 1;
                    const double ndc_y = 2 * (y + guard / 2 + 0.5) / c.size.y - 1;
                    for (double depth : {0.1, 5.0, 250.0}) {
                        const double clip = c.far / (c.far - c.near) * (1 - c.near / depth);
                        const glm::dvec4 v = c.view_to_world * (c.clip_to_view * glm::dvec4(ndc_x, ndc_y, clip, 1));
                        // Clip depth holds eye depth to 2^-53 z / near of itself.
                        CHECK(length(glm::dvec3(v) / v.w - ray * depth) <= 1e-14 * depth * (100 + depth / c.near));
                    }
                }
            CHECK(c.footprint == Approx(length(c.f_u)).epsilon(1e-14));
            CHECK(c.footprint == Approx(length(c.f_v)).epsilon(1e-14));
        }
    CHECK_THROWS_WITH(coarse_camera(some_camera(), {8, 8}, 3), "isr: guard = 3: expected an even number, 0 or more");
}

TEST_CASE("isr: at native resolution rays go through the centres of the frame's pixels", "[isr][ISR (24)][analytic]") {
    for (glm::ivec2 size : {glm::ivec2(64, 48), glm::ivec2(33, 17), glm::ivec2(1, 1)})
        for (int guard : {0, 8}) {
            CAPTURE(size.x, size.y, guard);
            const Camera camera = some_camera();
            const CoarseCamera c = coarse_camera(camera, size, guard, 1);
            CHECK(c.size == size + 2 * guard);
            for (int y = -guard; y < c.size.y - guard; ++y)
                for (int x = -guard; x < c.size.x - guard; ++x) {
                    const glm::dvec3 ray = c.f_o + double(x) * c.f_u + double(y) * c.f_v;
                    const Ray expected = ray_through(camera, size, {x + 0.5, y + 0.5});
                    CHECK(length(ray - expected.direction / dot(axes(camera).forward, expected.direction)) <= 1e-12);
                    const double ndc_x = 2 * (x + guard + 0.5) / c.size.x - 1, ndc_y = 2 * (y + guard + 0.5) / c.size.y - 1;
                    const double depth = 5, clip = c.far / (c.far - c.near) * (1 - c.near / depth);
                    const glm::dvec4 v = c.view_to_world * (c.clip_to_view * glm::dvec4(ndc_x, ndc_y, clip, 1));
                    CHECK(length(glm::dvec3(v) / v.w - ray * depth) <= 1e-14 * depth * (100 + depth / c.near));
                }
            CHECK(c.footprint == Approx(coarse_camera(camera, size).footprint / 2).epsilon(1e-14));
        }
}

TEST_CASE("isr: the frustum's vectors are the same through the matrices of every convention",
          "[isr][ISR (23)][ISR (24)][convention]") {
    const glm::ivec2 size(64, 48);
    const Camera camera = some_camera();
    const CameraAxes a = axes(camera);
    // (23) with f_x and f_y the right way round, (24) with its -1.
    const double f_y = camera.far * std::tan(camera.fov_y_deg * M_PI / 360), f_x = f_y * size.x / size.y;
    for (Convention convention : conventions) {
        CAPTURE(rules(convention).name);
        const FrustumVectors f = frustum_vectors(camera, size, convention);
        const double allowed = 1e-12 * camera.far;
        CHECK(length(f.f_o - (a.forward * camera.far - a.right * f_x + a.up * f_y)) <= allowed);
        CHECK(length(f.f_u - a.right * 2.0 * f_x) <= allowed);
        CHECK(length(f.f_v + a.up * 2.0 * f_y) <= allowed);
        const CoarseCamera c = coarse_camera(camera, size);
        for (int y = 0; y < 24; y += 5)
            for (int x = 0; x < 32; x += 5) {
                const glm::dvec3 ray = f.f_o + (2 * x + 1.0) / size.x * f.f_u + (2 * y + 1.0) / size.y * f.f_v;
                CHECK(length(ray / camera.far - (c.f_o + double(x) * c.f_u + double(y) * c.f_v)) <= 1e-12);
            }
    }
    Camera endless = camera;
    endless.far = INFINITY;
    CHECK_THROWS_AS(frustum_vectors(endless, size, Convention::vulkan), InputError);
}

TEST_CASE("isr: positions from depth are those that the rasteriser stores", "[isr][ISR 4.3]") {
    Scene scene;
    scene.materials.emplace_back();
    Mesh mesh;
    test::add_quad(mesh, {-9, -2, -9}, {-9, 1, 9}, {9, -2, -9}, 0);
    scene.meshes.push_back(mesh);
    scene.camera = some_camera();
    const glm::ivec2 size(64, 48);
    const Geometry geometry = flatten(scene);
    raster::GBuffer g;
    raster::draw_gbuffer(geometry, raster::prepare(scene, geometry), make_view(scene.camera, double(size.x) / size.y), size,
                         raster::Layout::fp32, {}, g);
    const CoarseCamera c = coarse_camera(scene.camera, size);
    int covered = 0;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            if (!(g.normal(x, y).w > 0)) continue;
            ++covered;
            // A full pixel's centre lies a quarter of a coarse pixel beside a coarse one's.
            const glm::dvec3 at = c.eye + (c.f_o + (x - 0.5) / 2 * c.f_u + (y - 0.5) / 2 * c.f_v) * double(g.position(x, y).w);
            // Vertices are snapped to 1/256 pixel: a point may lie a 512th beside its pixel's centre along each axis.
            const double snapped = c.footprint / 2 * double(g.position(x, y).w) * std::sqrt(2.0) / 512;
            CHECK(length(at - glm::dvec3(g.position(x, y))) <= snapped + 32 * 0x1p-24 * (length(c.eye) + length(at)));
        }
    CHECK(covered > 1000);
}

// ---- Downsampling --------------------------------------------------------------------------------------------------

TEST_CASE("isr.downsample: means over what sees a surface, by hand", "[isr][ISR Listing 3][analytic]") {
    // 3 x 3: the coarse pixels have 4, 2, 2 and 1 of them; one of the first four sees nothing.
    Image4 position(3, 3), normal(3, 3), albedo(3, 3), emission(3, 3), direct(3, 3);
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x) {
            position(x, y).w = float(1 + x + 3 * y);
            normal(x, y) = {0, 0, 1, 1};
            albedo(x, y) = {0.5f, 0.25f, 1, 0};
            emission(x, y) = {1, 0, 0, 0};
            direct(x, y) = glm::vec4(float(x + y));
        }
    normal(1, 0) = position(1, 0) = albedo(1, 0) = emission(1, 0) = direct(1, 0) = glm::vec4(0);
    normal(0, 1) = {0, 1, 0, 1};
    normal(2, 0) = {1, 0, 0, 1}, normal(2, 1) = {-1, 0, 0, 1};  // they cancel
    albedo(2, 2).w = 0.7f;
    DownsampleInputs in;
    in.position = &position, in.normal = &normal, in.albedo = &albedo, in.emission = &emission, in.direct = &direct;
    in.near = 0.5, in.far = 20;
    auto made = [&](Coarse what, const IsrParams& params = {}) {
        Image4 out;
        in.what = what;
        run(params, in, {}, out);
        return out;
    };
    const Image4 surface = made(Coarse::surface), radiosity = made(Coarse::radiosity), rho = made(Coarse::reflectance);
    REQUIRE(surface.width == 2);
    REQUIRE(surface.height == 2);
    // (0, 0): depths 1, 4 and 5; normals z, y and z.
    CHECK(surface(0, 0).w == Approx(10 / 3.0).epsilon(1e-6));
    CHECK(surface(0, 0).y == Approx(1 / std::sqrt(5.0)).epsilon(1e-6));
    CHECK(surface(0, 0).z == Approx(2 / std::sqrt(5.0)).epsilon(1e-6));
    CHECK(surface(1, 0) == glm::vec4(1, 0, 0, 4.5f));
    CHECK(surface(0, 1) == glm::vec4(0, 0, 1, 7.5f));
    CHECK(surface(1, 1) == glm::vec4(0, 0, 1, 9));
    // E is 0, 1 and 2 there: M + rho E = 1 + 0.5, and so on. The mask is the luminance of rho.
    const double luminance = 0.27 * 0.5 + 0.67 * 0.25 + 0.06;
    CHECK(radiosity(0, 0).x == Approx(1.5).epsilon(1e-6));
    CHECK(radiosity(0, 0).y == Approx(0.25).epsilon(1e-6));
    CHECK(radiosity(0, 0).z == Approx(1).epsilon(1e-6));
    CHECK(radiosity(0, 0).w == Approx(luminance).epsilon(1e-6));
    CHECK(radiosity(1, 1) == glm::vec4(3, 1, 4, 0.7f));
    CHECK(rho(0, 0) == glm::vec4(0.5f, 0.25f, 1, 0));

    // As printed: all four, background too; the border's pixels twice.
    IsrParams printed;
    printed.variant = Variant::published;
    const Image4 all = made(Coarse::surface, printed), colour = made(Coarse::radiosity, printed);
    CHECK(all(0, 0) == glm::vec4(0, 0.25f, 0.5f, 2.5f));
    CHECK(all(1, 1) == glm::vec4(0, 0, 1, 9));
    CHECK(colour(0, 0).x == Approx(0.375).epsilon(1e-6));
    CHECK(colour(0, 0).w == Approx(0.75 * luminance).epsilon(1e-6));

    // Clip depth of the mean, and back.
    IsrParams inverse;
    inverse.position = Position::inverse_matrix;
    Camera camera;
    camera.near = 0.5, camera.far = 20;
    for (glm::ivec2 p : {glm::ivec2(0, 0), glm::ivec2(1, 0), glm::ivec2(1, 1)})
        CHECK(linear_depth_from_clip(camera, double(made(Coarse::surface, inverse)(p.x, p.y).w)) ==
              Approx(double(surface(p.x, p.y).w)).epsilon(1e-5));

    // Nothing is 0 everywhere, also as clip depth.
    normal = position = Image4(3, 3);
    for (const IsrParams& params : {IsrParams{}, inverse})
        for (const glm::vec4& s : made(Coarse::surface, params).texels) CHECK(s == glm::vec4(0));
}

// ---- Gather and ambient occlusion ----------------------------------------------------------------------------------

TEST_CASE("isr.gather, isr.ssao: the equations, in double, within what rounding may change", "[isr][ISR (25)][ISR (26)]") {
    for (int kind : {0, 1, 2, 3, 4})
        for (Position position : {Position::linear, Position::inverse_matrix})
            for (int margin : {0, 5}) {
                CAPTURE(kind, int(position), margin);
                const Noise room({24, 17}, margin);
                IsrParams params = small_params();
                if (kind == 1) params.variant = Variant::published;
                if (kind == 2) in_rings(params), params.rotations = 1;
                if (kind == 3) params.variant = Variant::published, params.solid_angle = SolidAngle::none, params.length_unit = 0.25f;
                if (kind == 4) params.variant = Variant::published, params.solid_angle = SolidAngle::hemisphere;
                const Pattern pattern = gather_pattern(params, some_height), near = ssao_pattern(params);
                // Clip depth in a float holds eye depth to 2^-24 z / near; the reference has the linear one.
                Noise stored = room;
                double more = 1;
                if (position == Position::inverse_matrix) {
                    params.position = position;
                    const double n = room.camera.near, f = room.camera.far;
                    for (Image4* image : {&stored.surface, &stored.source_surface})
                        for (glm::vec4& s : image->texels)
                            if (s.w > 0) s.w = float(f / (f - n) * (1 - n / double(s.w)));
                    more = 2.3 / n;
                }
                const Image4 got = gathered(params, stored.gather(pattern)), open = occluded(params, stored.ssao(near));
                for (int y = 0; y < 17; ++y)
                    for (int x = 0; x < 24; ++x) {
                        CAPTURE(x, y);
                        if (room.surface(x, y).w == 0) {
                            CHECK(got(x, y) == glm::vec4(0));
                            CHECK(open(x, y) == glm::vec4(0, 0, 0, 1));
                            continue;
                        }
                        const Reference r = expected_of(room, params, pattern, false, x, y);
                        CHECK(std::abs(double(got(x, y).w) - r.forms) <= more * r.forms_error);
                        for (int c = 0; c < 3; ++c)
                            CHECK(std::abs(double(got(x, y)[c]) - r.irradiance[c]) <= more * r.light_error);
                        const Reference o = expected_of(room, params, near, true, x, y);
                        CHECK(std::abs(double(open(x, y).w) - std::clamp(1 - o.occlusion, 0.0, 1.0)) <=
                              more * o.occlusion_error + 0x1p-23);
                    }
            }
}

TEST_CASE("isr.gather: no pixel gathers more than the brightest sends", "[isr][energy]") {
    // Corners, coincident points, surfaces at the eye: whatever the form factors sum to.
    bool exceeded = false;
    for (double scale : {1.0, 1e-4, 1e6})
        for (float spacing : {0.0f, 1.0f, 4.0f, 40.0f}) {  // 0: rings
            Noise room({48, 31}, 3, scale);
            for (std::size_t i = 0; i < room.source_surface.size(); i += 7) room.source_surface.texels[i].w = 0;
            for (int y = 0; y < 31; ++y)
                for (int x = 0; x < 48; ++x) room.surface(x, y) = room.source_surface(x + 3, y + 3);
            IsrParams params = small_params();
            params.spacing = spacing, params.least_cosine = 1e-3f;
            if (spacing == 0) in_rings(params);
            const Pattern pattern = gather_pattern(params, some_height);
            const Image4 got = gathered(params, room.gather(pattern));
            glm::vec3 most(0);
            for (const glm::vec4& b : room.source_radiosity.texels) most = glm::max(most, glm::vec3(b));
            double above = 0, pixels = 0, largest = 0;
            for (std::size_t i = 0; i < got.size(); ++i) {
                REQUIRE(finite(got.texels[i]));
                // Each sum rounds once a sample.
                for (int c = 0; c < 3; ++c) CHECK(got.texels[i][c] <= most[c] * (1 + 100 * 0x1p-24f));
                if (dot(glm::dvec3(room.surface.texels[i]), glm::dvec3(room.surface.texels[i])) == 0) continue;
                pixels += 1, above += got.texels[i].w > 1, largest = std::max(largest, double(got.texels[i].w));
            }
            const Excess excess = excess_of(room.surface, got);
            CHECK(excess.largest == largest);
            CHECK(excess.share == above / pixels);
            exceeded = exceeded || excess.largest > 1;
        }
    CHECK(exceeded);  // or nothing was tried
}

TEST_CASE("isr.gather: one bright texel is not divided, a corner of mirrors is", "[isr][energy][analytic]") {
    // Two patches that face each other at distance d: F = A / (pi d^2 + A), whatever A.
    Noise room({2, 1}, 0, 1, 2.0f);
    room.source_surface = Image4(2, 1);
    room.source_surface(0, 0) = {1, 0, 0, 2}, room.source_surface(1, 0) = {-1, 0, 0, 2};
    const glm::dvec3 across = room.camera.f_u / length(room.camera.f_u);
    const glm::vec3 a(across);
    room.source_surface(0, 0) = glm::vec4(a, 2), room.source_surface(1, 0) = glm::vec4(-a, 2);
    room.surface = room.source_surface;
    room.source_radiosity(1, 0) = {8, 0, 0, 1};
    IsrParams params = small_params();
    params.rings = 1, params.spacing = 1;
    const Pattern pattern = gather_pattern(params, some_height);
    const double d = 2 * room.camera.footprint;
    const glm::dvec3 ray = room.camera.f_o + room.camera.f_u;
    const double slope = std::max(std::abs(dot(across, ray)), 0.1 * length(ray));
    const double area = d * d / slope, form = area / (M_PI * d * d + area);
    CHECK(gathered(params, room.gather(pattern))(0, 0).x == Approx(8 * form).epsilon(1e-5));

    // B = B0 + rho E, again and again: the series of two patches, F and G their form factors.
    const glm::dvec3 ray_0 = room.camera.f_o;
    const double slope_0 = std::max(std::abs(dot(across, ray_0)), 0.1 * length(ray_0));
    const double area_0 = d * d / slope_0, back = area_0 / (M_PI * d * d + area_0);
    room.reflectance(0, 0) = {0.9f, 0, 0, 0}, room.reflectance(1, 0) = {0.8f, 0, 0, 0};
    room.source_radiosity(0, 0) = {1, 0, 0, 0.25f};
    Image4 radiosity = room.source_radiosity;
    double b[2] = {1, 8};
    for (int bounce = 0; bounce < 40; ++bounce) {
        GatherInputs in = room.gather(pattern);
        in.source_radiosity = &radiosity;
        const Image4 e = gathered(params, in);
        Image4 next;
        run(params, BounceInputs{&room.source_radiosity, &room.reflectance, &e, 0}, {}, next);
        const double to_0 = 1 + double(0.9f) * form * b[1], to_1 = 8 + double(0.8f) * back * b[0];
        b[0] = to_0, b[1] = to_1;
        CHECK(next(0, 0).x == Approx(b[0]).epsilon(1e-5));
        CHECK(next(1, 0).x == Approx(b[1]).epsilon(1e-5));
        CHECK(next(0, 0).w == 0.25f);
        radiosity = next;
    }
    // Where it goes: B_0 = 1 + r_0 F B_1, B_1 = 8 + r_1 G B_0.
    const double limit = (1 + 0.9 * form * 8) / (1 - 0.9 * 0.8 * form * back);
    CHECK(radiosity(0, 0).x == Approx(limit).epsilon(1e-5));
}

TEST_CASE("isr.bounce: around the receivers the sources keep what they send", "[isr][analytic]") {
    const Noise room({7, 5}, 2);
    Image4 e(7, 5, glm::vec4(2, 3, 4, 9)), out;
    run(IsrParams{}, BounceInputs{&room.source_radiosity, &room.reflectance, &e, 2}, {}, out);
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            const glm::vec4 b0 = room.source_radiosity(x, y);
            const bool inside = x >= 2 && y >= 2 && x < 9 && y < 7;
            const glm::vec3 rho = inside ? glm::vec3(room.reflectance(x - 2, y - 2)) : glm::vec3(0);
            CHECK(out(x, y) == glm::vec4(glm::vec3(b0) + rho * glm::vec3(2, 3, 4), b0.w));
        }
}

TEST_CASE("isr.gather: sources one after the other add up, and share one sum of form factors", "[isr][layers]") {
    for (Variant variant : {Variant::corrected, Variant::published}) {
        CAPTURE(int(variant));
        const Noise room({20, 15});
        IsrParams params = small_params();
        params.variant = variant, params.spacing = 1;
        const Pattern pattern = gather_pattern(params, some_height);
        // Two layers that have half of the sources each.
        Image4 layers[2] = {room.source_surface, room.source_surface};
        for (int y = 0; y < 15; ++y)
            for (int x = 0; x < 20; ++x) layers[(x + y) % 2](x, y) = glm::vec4(0);
        const Image4 both = gathered(params, room.gather(pattern));
        GatherInputs in = room.gather(pattern);
        in.source_surface = &layers[0];
        const Image4 first = gathered(params, in);
        in.source_surface = &layers[1], in.before = &first;
        const Image4 got = gathered(params, in);
        for (std::size_t i = 0; i < got.size(); ++i)
            for (int c = 0; c < 4; ++c)
                CHECK(std::abs(got.texels[i][c] - both.texels[i][c]) <= 100 * 0x1p-24f * both.texels[i][c]);
        CHECK(excess_of(room.surface, first).largest > 0);
    }
}

TEST_CASE("isr.gather: a margin is a window of a larger image", "[isr][guard]") {
    const Noise large({40, 30});
    const IsrParams params = small_params();
    const Pattern pattern = gather_pattern(params, some_height), near = ssao_pattern(params);
    const Image4 whole = gathered(params, large.gather(pattern)), open = occluded(params, large.ssao(near));
    Image4 window(24, 14);
    for (int y = 0; y < 14; ++y)
        for (int x = 0; x < 24; ++x) window(x, y) = large.surface(x + 8, y + 8);
    GatherInputs in = large.gather(pattern);
    SsaoInputs ao = large.ssao(near);
    // Pixel (8, 8) is called (0, 0).
    in.camera.f_o += 8.0 * in.camera.f_u + 8.0 * in.camera.f_v;
    ao.camera = in.camera;
    in.surface = ao.surface = &window, in.margin = ao.margin = 8;
    const Image4 got = gathered(params, in), got_open = occluded(params, ao);
    for (int y = 0; y < 14; ++y)
        for (int x = 0; x < 24; ++x) {
            for (int c = 0; c < 4; ++c) CHECK(got(x, y)[c] == Approx(whole(x + 8, y + 8)[c]).epsilon(1e-3).margin(1e-7));
            CHECK(got_open(x, y).w == Approx(open(x + 8, y + 8).w).margin(1e-4));
        }
}

TEST_CASE("isr.gather: pixels far away have fewer rings", "[isr][ISR 6]") {
    Noise room({30, 20});
    IsrParams params = small_params(), one = params;
    params.far_rings = 1, params.full_depth = 0.75f;
    one.rings = 1;
    const Pattern pattern = gather_pattern(params, some_height), inner = gather_pattern(one, some_height);
    for (float depth : {0.5f, 0.74f, 1.0f, 1.2f, 5.0f}) {
        CAPTURE(depth);
        for (std::size_t i = 0; i < room.surface.size(); ++i)
            if (room.surface.texels[i].w > 0) room.surface.texels[i].w = room.source_surface.texels[i].w = depth;
        // Ring r is there where r z <= 3 x 0.75 m: all to 0.75 m, two to 1.125 m, then far_rings.
        IsrParams fewer = small_params();
        fewer.rings = depth <= 0.75f ? 3 : depth <= 1.125f ? 2 : 1;
        const Pattern expected = gather_pattern(fewer, some_height);
        CHECK(same_bits(gathered(params, room.gather(pattern)), gathered(fewer, room.gather(expected))));
    }
    // Beside each other, as packets have them.
    for (std::size_t i = 0; i < room.surface.size(); ++i)
        if (room.surface.texels[i].w > 0) room.surface.texels[i].w = room.source_surface.texels[i].w = i % 2 ? 0.5f : 5.0f;
    const Image4 mixed = gathered(params, room.gather(pattern));
    CHECK(same_bits(mixed, gathered(params, room.gather(pattern), scalar())));
    IsrParams all = small_params();
    const Image4 near = gathered(all, room.gather(pattern)), far = gathered(one, room.gather(inner));
    for (std::size_t i = 0; i < mixed.size(); ++i) CHECK(mixed.texels[i] == (i % 2 ? near : far).texels[i]);
}

TEST_CASE("isr.gather: published, N is of the samples that a pixel has", "[isr][ISR (25)][ISR 6]") {
    Noise room({30, 20});
    IsrParams params = small_params();
    params.variant = Variant::published;
    IsrParams fewer = params, one = params;
    fewer.far_rings = 1, fewer.full_depth = 0.75f;
    one.rings = 1;
    for (std::size_t i = 0; i < room.surface.size(); ++i)
        if (room.surface.texels[i].w > 0) room.surface.texels[i].w = room.source_surface.texels[i].w = i % 2 ? 0.5f : 5.0f;
    const Pattern pattern = gather_pattern(params, some_height), inner = gather_pattern(one, some_height);
    for (SolidAngle of : {SolidAngle::printed, SolidAngle::none, SolidAngle::hemisphere}) {
        CAPTURE(int(of));
        params.solid_angle = fewer.solid_angle = one.solid_angle = of;
        const Image4 mixed = gathered(fewer, room.gather(pattern)), near = gathered(params, room.gather(pattern)),
                     far = gathered(one, room.gather(inner));
        CHECK(same_bits(mixed, gathered(fewer, room.gather(pattern), scalar())));
        bool lit = false;
        for (std::size_t i = 0; i < mixed.size(); ++i) {
            if (i % 2) CHECK(mixed.texels[i] == near.texels[i]);
            for (int c = 0; c < 4 && i % 2 == 0; ++c) {
                CHECK(mixed.texels[i][c] == Approx(far.texels[i][c]).epsilon(1e-6));
                lit = lit || far.texels[i][c] > 0;
            }
        }
        CHECK(lit);
    }
}

TEST_CASE("isr.bounce: as printed, what is gathered has the receiver's reflectance once", "[isr][ISR (8)][analytic]") {
    // (25) is a term of (8) with rho_p in it: M_i = M0_i + rho_i sum M_j F_ij. Two bounces by hand, of masks that differ.
    const Noise room({7, 5}, 2);
    Image4 e(7, 5, glm::vec4(2, 3, 4, 9)), out;
    IsrParams printed;
    printed.variant = Variant::published;
    run(printed, BounceInputs{&room.source_radiosity, &room.reflectance, &e, 2}, {}, out);
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            const glm::vec4 b0 = room.source_radiosity(x, y);
            const bool inside = x >= 2 && y >= 2 && x < 9 && y < 7;
            CHECK(out(x, y) == glm::vec4(glm::vec3(b0) + (inside ? glm::vec3(2, 3, 4) : glm::vec3(0)), b0.w));
        }
    // Through both stages: the second bounce is linear in the first one's light, with the mask once a bounce.
    IsrParams params = small_params();
    params.variant = Variant::published;
    Noise halved({24, 17});
    const Noise full = halved;
    for (glm::vec4& b : halved.source_radiosity.texels) b.w *= 0.5f;
    const Pattern pattern = gather_pattern(params, some_height);
    auto second = [&](const Noise& of) {
        GatherInputs in = of.gather(pattern);
        const Image4 first = gathered(params, in);
        Image4 sent;
        run(params, BounceInputs{&of.source_radiosity, &of.reflectance, &first, 0}, {}, sent);
        in.source_radiosity = &sent;
        std::pair<Image4, Image4> both{first, gathered(params, in)};
        return both;
    };
    const auto [a1, a2] = second(full);
    const auto [b1, b2] = second(halved);
    double more = 0;
    for (std::size_t i = 0; i < a1.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            CHECK(b1.texels[i][c] == Approx(0.5f * a1.texels[i][c]).epsilon(1e-6));
            CHECK(b2.texels[i][c] - b1.texels[i][c] == Approx(0.25f * (a2.texels[i][c] - a1.texels[i][c])).epsilon(1e-3).margin(1e-7));
            more = std::max(more, double(a2.texels[i][c] - a1.texels[i][c]));
        }
    CHECK(more > 1e-4);
}

TEST_CASE("isr: the same bits for every instruction set and thread count, from planes and from images", "[isr][bits]") {
    for (glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(5, 3), glm::ivec2(17, 33), glm::ivec2(50, 40)})
        for (int margin : {0, 3})
            for (int kind = 0; kind < 11; ++kind) {
                IsrParams params = small_params();
                if (kind == 1) params.variant = Variant::published;
                if (kind == 2) params.rotations = 8;
                if (kind == 3) params.position = Position::inverse_matrix;
                if (kind == 4) params.far_rings = 1, params.full_depth = 1;
                if (kind == 5) params.spacing = 19, params.ssao_spacing = 30;  // beyond small images
                if (kind >= 6) in_rings(params), params.rotations = kind == 6 ? 1 : kind == 7 ? 8 : kind == 8 ? 4 : 64;
                if (kind == 10) params.turn = Turn::hash;
                const Noise room(size, margin);
                const Image4 before(size.x, size.y, glm::vec4(0.1f, 0.2f, 0.3f, 1.5f));
                const Pattern pattern = gather_pattern(params, some_height), near = ssao_pattern(params);
                GatherInputs in = room.gather(pattern);
                SsaoInputs ao = room.ssao(near);
                if (kind % 2) in.before = ao.gathered = &before;
                const Image4 e = gathered(params, in, scalar()), lit = occluded(params, ao, scalar());
                for (Isa isa : supported_isas())
                    for (int threads : {1, 3}) {
                        CAPTURE(size.x, size.y, margin, kind, isa_name(isa), threads);
                        RunOptions options;
                        options.isa = isa, options.threads = threads;
                        CHECK(same_bits(gathered(params, in, options), e));
                        CHECK(same_bits(occluded(params, ao, options), lit));
                    }
                // The kernel on the images as they are bound, which the twin mirrors, and along with double.
                const StageData datas[] = {data_of(params, in), data_of(params, ao)};
                const StageBinding* bindings[] = {&stage<GatherKernel>(), &stage<SsaoKernel>()};
                for (int s = 0; s < 2; ++s) {
                    const Image4& expected = s == 0 ? e : lit;
                    const auto stage = bindings[s]->bind(datas[s]);
                    Bundle outputs;
                    stage->run({}, {}, outputs);
                    CHECK(std::memcmp(outputs.arrays[0].bytes.data(), expected.data(), outputs.arrays[0].bytes.size()) == 0);
                    DecisionTape tape;
                    for (int y = 0; y < size.y; ++y)
                        for (int x = 0; x < size.x; ++x) {
                            std::vector<Followed> one;
                            tape.record();
                            stage->follow({x, y}, tape, one);
                            for (int c = 0; c < 4; ++c) CHECK(one[std::size_t(c)].value == expected(x, y)[c]);
                        }
                }
            }
}

TEST_CASE("isr.downsample, isr.bounce: the same bits for every instruction set", "[isr][bits]") {
    for (glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(5, 3), glm::ivec2(33, 18)}) {
        const Noise room(size);
        Image4 normal = room.surface;
        for (glm::vec4& n : normal.texels) n.w = n.w > 0 ? 1.0f : 0.0f;
        DownsampleInputs in;
        in.position = &room.surface, in.normal = &normal, in.albedo = &room.reflectance;
        in.emission = &room.source_radiosity, in.direct = &room.source_radiosity, in.near = 0.1, in.far = INFINITY;
        for (Coarse what : {Coarse::surface, Coarse::radiosity, Coarse::reflectance})
            for (int kind = 0; kind < 3; ++kind) {
                IsrParams params;
                if (kind == 1) params.variant = Variant::published;
                if (kind == 2) params.position = Position::inverse_matrix;
                Image4 first, got;
                in.what = what;
                run(params, in, scalar(), first);
                for (Isa isa : supported_isas()) {
                    RunOptions options;
                    options.isa = isa;
                    run(params, in, options, got);
                    CHECK(same_bits(got, first));
                }
                const StageData data = data_of(params, in);
                const auto stage = plumb::stage<DownsampleKernel>().bind(data);
                Bundle outputs;
                stage->run({}, {}, outputs);
                CHECK(std::memcmp(outputs.arrays[0].bytes.data(), first.data(), outputs.arrays[0].bytes.size()) == 0);
            }
        Image4 first, got;
        const BounceInputs bounce{&room.source_radiosity, &room.reflectance, &room.reflectance, 0};
        const IsrParams params;
        run(params, bounce, scalar(), first);
        for (Isa isa : supported_isas()) {
            RunOptions options;
            options.isa = isa;
            run(params, bounce, options, got);
            CHECK(same_bits(got, first));
        }
        const StageData data = data_of(params, bounce);
        Bundle outputs;
        stage<BounceKernel>().bind(data)->run({}, {}, outputs);
        CHECK(std::memcmp(outputs.arrays[0].bytes.data(), first.data(), outputs.arrays[0].bytes.size()) == 0);
    }
}

TEST_CASE("isr: tiles that see nothing are left as they were made", "[isr][tiles]") {
    Noise room({40, 35});
    for (int y = 0; y < 35; ++y)
        for (int x = 16; x < 32; ++x) room.surface(x, y) = glm::vec4(0);
    const IsrParams params = small_params();
    const Pattern pattern = gather_pattern(params, some_height), near = ssao_pattern(params);
    raster::Covered tiles({40, 35}, 1);
    for (int y = 0; y < tiles.tiles.y; ++y) tiles.any[std::size_t(y * tiles.tiles.x + 1)] = 0;
    GatherInputs in = room.gather(pattern);
    SsaoInputs ao = room.ssao(near);
    const Image4 e = gathered(params, in), lit = occluded(params, ao);
    in.tiles = ao.tiles = &tiles;
    CHECK(same_bits(gathered(params, in), e));
    CHECK(same_bits(occluded(params, ao), lit));
}

TEST_CASE("isr: nothing that surfaces and light can be becomes no number", "[isr][extremes]") {
    const float depths[] = {0, 1e-38f, 1e-20f, 1e-6f, 1, 1e6f, 1e10f, 1e14f, 1e16f, 3e38f, INFINITY};
    const float lights[] = {0, 1e-38f, 1, 1e30f, 3e38f, INFINITY};
    Noise room({33, 21}, 2);
    for (Variant variant : {Variant::corrected, Variant::published})
        for (int seed = 0; seed < 8; ++seed) {
            CAPTURE(int(variant), seed);
            for (int y = 0; y < room.source_surface.height; ++y)
                for (int x = 0; x < room.source_surface.width; ++x) {
                    glm::vec4& s = room.source_surface(x, y);
                    if (dot(glm::dvec3(s), glm::dvec3(s)) > 0) s.w = depths[int(noise(x, y, 30 + seed) * 11)];
                    room.source_radiosity(x, y) = glm::vec4(lights[int(noise(x, y, 40 + seed) * 6)]);
                    room.source_radiosity(x, y).w = noise(x, y, 9);
                }
            for (int y = 0; y < 21; ++y)
                for (int x = 0; x < 33; ++x) room.surface(x, y) = room.source_surface(x + 2, y + 2);
            IsrParams params = small_params();
            params.variant = variant;
            const Pattern pattern = gather_pattern(params, some_height), near = ssao_pattern(params);
            for (const glm::vec4& e : gathered(params, room.gather(pattern)).texels)
                for (int c = 0; c < 4; ++c) CHECK(e[c] == e[c]);
            for (const glm::vec4& o : occluded(params, room.ssao(near)).texels) CHECK((o.w >= 0 && o.w <= 1));
        }
}

TEST_CASE("isr.gather: neither the scene's unit nor its place changes the light", "[isr][extremes]") {
    const Noise room({24, 18});
    const IsrParams params = small_params();
    const Pattern pattern = gather_pattern(params, some_height);
    const Image4 got = gathered(params, room.gather(pattern));
    // By powers of two, to the bit.
    for (double scale : {0x1p-13, 0x1p20}) {
        const Noise scaled({24, 18}, 0, scale);
        CHECK(same_bits(gathered(params, scaled.gather(pattern)), got));
    }
    // Positions are relative to the eye.
    Noise moved({24, 18});
    Camera away = some_camera();
    away.position += glm::dvec3(1e7, -1e7, 1e7), away.look_at += glm::dvec3(1e7, -1e7, 1e7);
    moved.camera = coarse_camera(away, {48, 36});
    const Image4 there = gathered(params, moved.gather(pattern));
    for (std::size_t i = 0; i < got.size(); ++i)
        for (int c = 0; c < 4; ++c)
            CHECK(there.texels[i][c] == Approx(got.texels[i][c]).epsilon(1e-3).margin(1e-6));
}

TEST_CASE("isr: bad input of the gathering stages is refused in one line", "[isr]") {
    const Noise room({8, 6});
    const IsrParams params = small_params();
    const Pattern pattern = gather_pattern(params, some_height);
    Image4 out;
    GatherInputs in = room.gather(pattern);
    in.source_radiosity = nullptr;
    CHECK_THROWS_WITH(run(params, in, {}, out), "isr.gather: source_radiosity must be bound");
    const Image4 other(3, 3);
    in.source_radiosity = &other;
    CHECK_THROWS_WITH(run(params, in, {}, out), "isr.gather: input \"source_radiosity\" is 3 x 3: expected 8 x 6, as source_width and source_height say");
    in = room.gather(pattern), in.margin = 1;
    CHECK_THROWS_AS(run(params, in, {}, out), InputError);
    CHECK_THROWS_WITH(run(IsrParams{}, room.gather(pattern), {}, out),
                      "isr.gather: pattern has 48 samples in 1 rotations: expected 80 in 64");
    CHECK_THROWS_WITH(run(params, DownsampleInputs{Coarse::radiosity}, {}, out), "isr.downsample: normal must be bound");
    UnseenInputs left;
    left.view_surface = &other;
    CHECK_THROWS_WITH(run(params, left, {}, out), "isr.unseen: surface must be bound");
    CameraGatherInputs around;
    around.source_surface = &other;
    CHECK_THROWS_WITH(run(params, around, {}, out), "isr.gather_camera: surface must be bound");
    CHECK_THROWS_AS(run(params, BounceInputs{&other, &room.reflectance, &room.reflectance, 0}, {}, out), InputError);
    CHECK(out.empty());
}
