// probes.relief in closed form: how a ratio and a lobe act, and that of a single light they are the path tracer's.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/relief.h"

namespace {

using namespace plumb;
using namespace plumb::probes;

// A row of pixels, all alike until they are changed.
struct Row {
    Image4 position, normal, irradiance, mapped, plain, light, from_light, specular;
    explicit Row(int n)
        : position(n, 1, glm::vec4(0)), normal(n, 1, glm::vec4(0, 0, 1, 1)), irradiance(n, 1, glm::vec4(2, 4, 8, 1)),
          mapped(n, 1, glm::vec4(3, 3, 3, 1)), plain(n, 1, glm::vec4(2, 2, 2, 1)), light(n, 1, glm::vec4(0, 0, 1, 1)),
          from_light(n, 1, glm::vec4(5, 6, 7, 1)), specular(n, 1, glm::vec4(0.25f, 0.5f, 0, 10)) {}
    ReliefInputs inputs(const glm::vec3& eye = {0, 0, 3}) const {
        ReliefInputs in;
        in.eye = eye, in.position = &position, in.normal = &normal, in.irradiance = &irradiance, in.mapped = &mapped;
        in.plain = &plain, in.light = &light, in.from_light = &from_light, in.specular = &specular;
        return in;
    }
};
ReliefLight shaded(const ReliefInputs& in, const RunOptions& options = {}) {
    ReliefLight out;
    run(in, options, out);
    return out;
}

}  // namespace

TEST_CASE("probes.relief: irradiance times what the volume has more along the mapped normal", "[probes][relief][IPR 5.2.1.6][analytic]") {
    Row row(6);
    row.mapped(1, 0) = glm::vec4(1, 0, 0, 1);       // a sixth
    row.mapped(2, 0) = glm::vec4(100, 0, 0, 1);     // more than four times
    row.plain(3, 0) = glm::vec4(2, 2, 2, 0);        // of a surface that the volume itself lights
    row.plain(4, 0) = glm::vec4(0, 0, 0, 1);        // in the dark nothing is known
    row.normal(5, 0) = glm::vec4(0);
    const ReliefLight r = shaded(row.inputs());
    CHECK(r.relieved(0, 0) == glm::vec4(3, 6, 12, 1));
    CHECK(r.relieved(1, 0).y == Approx(4.0 / 6));
    CHECK(r.relieved(2, 0) == glm::vec4(8, 16, 32, 1));
    CHECK(r.relieved(3, 0) == glm::vec4(2, 4, 8, 1));
    CHECK(r.relieved(4, 0) == glm::vec4(2, 4, 8, 1));
    CHECK(r.relieved(5, 0) == glm::vec4(0));
    CHECK(r.glossy(5, 0) == glm::vec4(0));
    ReliefInputs flat = row.inputs();
    flat.maps = false;
    for (int i = 0; i < 5; ++i) CHECK(shaded(flat).relieved(i, 0) == glm::vec4(2, 4, 8, 1));
    flat.highlights = false;
    CHECK(shaded(flat).glossy(0, 0) == glm::vec4(0, 0, 0, 1));
}

TEST_CASE("probes.relief: the lobe of a single light", "[probes][relief][IPR 4.1.2][analytic]") {
    // Seen and lit along the normal: k_s (e + 2) / (2 pi) E.
    Row row(64);
    const ReliefLight head_on = shaded(row.inputs());
    CHECK(head_on.glossy(0, 0).x == Approx(0.25 * 12 / (2 * host::pi) * 5));
    CHECK(head_on.glossy(0, 0).y == Approx(0.5 * 12 / (2 * host::pi) * 6));
    CHECK(head_on.glossy(0, 0).z == 0);
    // Lit at an angle a and seen from the mirrored direction turned by b: cos^e(b) cos(a).
    for (int i = 0; i < 64; ++i) {
        const double a = 0.02 * (i % 8) * host::pi, b = 0.02 * (i / 8) * host::pi;
        row.light(i, 0) = glm::vec4(float(host::sin(a)), 0, float(host::cos(a)), 1);
        row.position(i, 0) = glm::vec4(-3.0f * glm::vec3(float(-host::sin(a)) * float(host::cos(b)), float(host::sin(b)), float(host::cos(a)) * float(host::cos(b))), 0);
    }
    const ReliefLight turned = shaded(row.inputs(glm::vec3(0)));
    for (int i = 0; i < 64; ++i) {
        const double a = 0.02 * (i % 8) * host::pi, b = 0.02 * (i / 8) * host::pi;
        double power = 1;
        for (int k = 0; k < 10; ++k) power *= host::cos(b);
        CHECK(turned.glossy(i, 0).x == Approx(0.25 * 12 / (2 * host::pi) * 5 * power * host::cos(a)).epsilon(1e-4));
    }
    // From behind the surface, or with the mirrored direction away from the light: none.
    row = Row(2);
    row.light(0, 0) = glm::vec4(0, 0, -1, 1);
    row.light(1, 0) = glm::vec4(1, 0, 0, 1);
    const ReliefLight none = shaded(row.inputs());
    CHECK(none.glossy(0, 0) == glm::vec4(0, 0, 0, 1));
    CHECK(none.glossy(1, 0) == glm::vec4(0, 0, 0, 1));
    // An exponent of a million is a mirror: nothing a degree beside it, and no NaN.
    row = Row(2);
    for (int i = 0; i < 2; ++i) row.specular(i, 0).w = 1e6f;
    row.light(1, 0) = glm::vec4(0.0174524f, 0, 0.9998477f, 1);
    const ReliefLight sharp = shaded(row.inputs());
    CHECK(sharp.glossy(0, 0).x == Approx(0.25 * 1000002 / (2 * host::pi) * 5).epsilon(1e-5));
    CHECK(sharp.glossy(1, 0).x == 0);
    // e = 0: (2 / 2 pi) for all directions.
    row.specular(0, 0).w = 0;
    CHECK(shaded(row.inputs()).glossy(0, 0).x == Approx(0.25 / host::pi * 5));
}

TEST_CASE("probes.relief: refuses what is not bound, or of another size; the same bits everywhere", "[probes][relief][bits]") {
    Row row(33);
    ReliefInputs in = row.inputs({1, 2, 3});
    in.plain = nullptr;
    CHECK_THROWS_AS(shaded(in), InputError);
    const Image4 smaller(3, 1);
    in.plain = &smaller;
    CHECK_THROWS_AS(shaded(in), InputError);
    in = row.inputs({1, 2, 3});
    in.most = std::nanf("");
    CHECK_THROWS_AS(shaded(in), InputError);
    in.most = 4;
    for (int i = 0; i < 33; ++i) {
        row.light(i, 0) = glm::vec4(glm::normalize(glm::vec3(0.1f * float(i) - 1, 0.3f, 1)), 1);
        row.specular(i, 0).w = 0.7f * float(i);
    }
    const ReliefLight first = shaded(in);
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            const ReliefLight r = shaded(in, options);
            CHECK(r.relieved.texels == first.relieved.texels);
            CHECK(r.glossy.texels == first.glossy.texels);
        }
}
