// The published pass, drawn and summed anew, against rows; and what it makes of buffers of 8 bits.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/formats.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/published_pass.h"
#include "radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;

namespace {

Scene box() { return test::cube(3, {{0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, {1, 0, 0, 0, 0, 0}}); }

Buffer<glm::vec4> uneven(int n) {
    Buffer<glm::vec4> b;
    for (int i = 0; i < n; ++i) b.push_back({1 + float(i % 7), float(i % 3), 0.25f * float(i % 5), 0});
    return b;
}

Buffer<glm::vec4> published(const Elements& e, const PublishedPass& pass, const Buffer<glm::vec4>& b, const RunOptions& options = {}) {
    Buffer<glm::vec4> h;
    published_irradiance(e, pass, b, 0, e.count(), options, h);
    return h;
}

}  // namespace

TEST_CASE("published pass: the same irradiance as rows give, up to their halves", "[radiosity][HEM 5.6]") {
    const Scene scene = box();
    for (const Kind kind : {Kind::vertices, Kind::triangles}) {
        const Elements e = elements_of(scene, {kind});
        const Buffer<glm::vec4> b = uneven(e.count()), dark(b.size(), glm::vec4(0));
        for (const Weights weights : {Weights::exact, Weights::published}) {
            const RowParams row{16, weights};
            Buffer<glm::vec4> gathered;
            gather(form_factors(e, row, {}), dark, b, {}, gathered);
            const Buffer<glm::vec4> summed = published(e, {row, {}}, b);
            double worst = 0, largest = 0;
            for (std::size_t i = 0; i < b.size(); ++i)
                for (int c = 0; c < 3; ++c) worst = std::max(worst, std::fabs(double(summed[i][c]) - double(gathered[i][c]))), largest = std::max(largest, double(summed[i][c]));
            CAPTURE(int(kind), int(weights), worst, largest);
            CHECK(largest > 1);
            CHECK(worst < 2e-4 * largest);
        }
    }
}

TEST_CASE("published pass: a closed room of one radiosity sends it to all, and RGBE keeps it", "[radiosity][HEM 5.7][analytic]") {
    const Elements e = elements_of(box(), {});
    // Codes of 8 bits below 2^0: off by 1 / 510 at most.
    const Buffer<glm::vec4> one(std::size_t(e.count()), glm::vec4(0.9f, 0.5f, 0.25f, 0));
    const auto rgbe = [](const std::array<glm::vec3, 3>& c, const glm::vec3& at) { return decode_rgbe(encode_rgbe(at.x * c[0] + at.y * c[1] + at.z * c[2])); };
    for (const auto& texel : {decltype(PublishedPass::texel)(), decltype(PublishedPass::texel)(rgbe)})
        for (const glm::vec4& h : published(e, {{16, Weights::exact}, texel}, one)) {
            CHECK(h.x == Approx(0.9).epsilon(1e-6).margin(texel ? 0.00197 : 0));
            CHECK(h.y == Approx(0.5).epsilon(1e-6).margin(texel ? 0.00197 : 0));
            CHECK(h.z == Approx(0.25).epsilon(1e-6).margin(texel ? 0.00197 : 0));
        }
    // What a texel holds is what counts.
    for (const glm::vec4& h : published(e, {{8, Weights::exact}, [](const auto&, const glm::vec3&) { return glm::vec3(3); }}, one)) CHECK(h.y == Approx(3).epsilon(1e-6));
}

TEST_CASE("published pass: some elements are the same bits as all, for any threads and instruction set", "[radiosity][bits]") {
    const Elements e = elements_of(box(), {});
    const Buffer<glm::vec4> b = uneven(e.count());
    const PublishedPass pass{{12, Weights::exact}, {}};
    const Buffer<glm::vec4> all = published(e, pass, b);
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            Buffer<glm::vec4> some;
            const PassTimes times = published_irradiance(e, pass, b, 17, 9, options, some);
            REQUIRE(some.size() == 9);
            CHECK(std::memcmp(some.data(), &all[17], 9 * sizeof(glm::vec4)) == 0);
            CHECK((times.draw_seconds > 0 && times.sum_seconds > 0));
        }
    Buffer<glm::vec4> none;
    CHECK_THROWS_AS(published_irradiance(e, pass, b, e.count() - 3, 4, {}, none), InputError);
    CHECK_THROWS_AS(published_irradiance(e, pass, Buffer<glm::vec4>(3), 0, 1, {}, none), InputError);
}
