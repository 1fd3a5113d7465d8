// Few samples a frame, turned, and joined with those of frames before: errors, keys, half size, and what may not change.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "gi/frame/kept.h"
#include "tests/gi/keys_of.h"
#include "tests/gi/open_room.h"

using namespace plumb;
using test::render;
using test::same;

namespace {

Scene scene_of(const glm::ivec2& size) {
    Scene s = moving::scene();
    s.frame_size = size;
    return s;
}

frame::Settings ten_samples(int frames) {
    frame::Settings settings;
    settings.method = frame::Method::rsm;
    settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 10, settings.rsm.turn = rsm::Turn::hash, settings.reuse.frames = frames;
    settings.reuse.clamp = screen::ReuseClamp::none;
    return settings;
}

double rms(const Image4& a, const Image4& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 3; ++c) sum += std::pow(double(a.texels[i][c]) - double(b.texels[i][c]), 2);
    return std::sqrt(sum / double(3 * a.size()));
}

const frame::Frame& next(const Scene& scene, const frame::Settings& settings, frame::KeptStages& kept) {
    return frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
}

}  // namespace

TEST_CASE("reuse: the first frame is that of the gather alone, to the bit", "[frame][reuse]") {
    const Scene scene = scene_of({48, 36});
    for (const filter::Blur blur : {filter::Blur::none, filter::Blur::separable}) {
        frame::Settings on = ten_samples(8), off = ten_samples(0);
        on.indirect.blur = off.indirect.blur = blur;
        const frame::Frame a = render(scene, on), b = render(scene, off);
        CHECK(same(a.radiance, b.radiance));
        CHECK_FALSE(a.reused_age.empty());
        CHECK(b.reused_age.empty());
    }
}

TEST_CASE("reuse: under a still camera frames of ten turned samples become what all of them make", "[frame][reuse]") {
    const Scene scene = scene_of({48, 36});
    frame::Settings all = ten_samples(0);
    all.rsm.gather = rsm::Gather::disc, all.rsm.samples = 640, all.rsm.turn = rsm::Turn::hash, all.indirect.blur = filter::Blur::none;
    const Image4 truth = render(scene, all).indirect;
    const frame::Settings settings = ten_samples(64);
    frame::KeptStages kept;
    double first = 0, last = 0;
    for (int f = 1; f <= 64; ++f) {
        const frame::Frame& frame = next(scene, settings, kept);
        last = rms(frame.indirect, truth);
        if (f == 1) first = last;
        for (const glm::vec4& age : frame.reused_age.texels)
            if (age.w > 0) REQUIRE(age.x == Approx(f).epsilon(1e-3));
    }
    CAPTURE(first, last);
    // Noise alone would keep an eighth; all rotations of a pattern are less than that.
    CHECK(last < first / 8);
    CHECK(first > 0);
}

TEST_CASE("reuse: the mean of 64 frames is the mean of the 64 rotations", "[frame][reuse]") {
    // Each frame alone has the pattern of its turn; the clock starts anew.
    const Scene scene = scene_of({24, 18});
    const frame::Settings settings = ten_samples(64);
    frame::KeptStages kept;
    Image4 mean(24, 18);
    for (int f = 0; f < 64; ++f) {
        const frame::Frame& frame = next(scene, settings, kept);
        for (std::size_t i = 0; i < mean.size(); ++i) mean.texels[i] += frame.gathered.texels[i] / 64.0f;
        if (f == 63) CHECK(rms(frame.indirect, mean) < 1e-4 * rms(mean, Image4(24, 18)));
    }
}

TEST_CASE("reuse: a turned pattern has its rotations in another order, offsets and weights of one together", "[rsm][reuse]") {
    for (const auto& [gather, texels] : {std::pair(rsm::Gather::disc, rsm::Texels::whole), std::pair(rsm::Gather::paths, rsm::Texels::whole),
                                         std::pair(rsm::Gather::paths, rsm::Texels::continuous)}) {
        rsm::GatherParams params;
        params.gather = gather, params.texels = texels, params.samples = 6, params.directions = 3, params.steps = 2, params.rotations = 8;
        const rsm::Pattern plain = rsm::pattern_of(params, 64, 1), turned = rsm::turned(plain, 3);
        const std::size_t n = 6, r = 8;
        const bool own_weights = plain.weights.size() == n * r;
        REQUIRE(own_weights == (gather == rsm::Gather::paths));
        int moved = 0;
        for (std::size_t k = 0; k < n; ++k)
            for (std::size_t i = 0; i < r; ++i) {
                const std::size_t to = k * r + i, from = k * r + (i + 3) % r;
                if (!plain.offsets.empty()) CHECK(turned.offsets[to] == plain.offsets[from]);
                for (std::size_t c = 0; c < 2 && !plain.positions.empty(); ++c) CHECK(turned.positions[2 * to + c] == plain.positions[2 * from + c]);
                if (own_weights) CHECK(turned.weights[to] == plain.weights[from]);
                moved += own_weights && turned.weights[to] != plain.weights[to];
            }
        CHECK((moved > 0) == own_weights);
        if (!own_weights) CHECK(turned.weights == plain.weights);
    }
    CHECK(rsm::turned({}, 3).offsets.empty());
}

TEST_CASE("reuse: at half size of an odd picture a still camera sees every pixel again", "[frame][reuse]") {
    const Scene scene = scene_of({47, 35});
    frame::Settings settings = ten_samples(8);
    settings.indirect.resolution = filter::Resolution::half, settings.indirect.blur = filter::Blur::full;
    frame::KeptStages kept;
    next(scene, settings, kept);
    const frame::Frame& frame = next(scene, settings, kept);
    REQUIRE(frame.reused_age.width == 24);
    for (const glm::vec4& age : frame.reused_age.texels)
        if (age.w > 0) {
            CHECK(age.x == Approx(2).epsilon(1e-3));
            CHECK(age.y == Approx(1).epsilon(1e-2));
        }
}

TEST_CASE("reuse: switched off and on again, or of another size, frames begin anew", "[frame][reuse]") {
    const Scene scene = scene_of({48, 36}), other = scene_of({40, 36});
    const frame::Settings on = ten_samples(8), off = ten_samples(0);
    frame::KeptStages kept;
    const Image4 first = next(scene, on, kept).radiance;
    CHECK_FALSE(same(first, next(scene, on, kept).radiance));
    next(scene, off, kept);
    CHECK(same(first, next(scene, on, kept).radiance));
    const frame::Frame& small = next(other, on, kept);
    for (const glm::vec4& age : small.reused_age.texels) CHECK(age.x <= 1);
}

TEST_CASE("reuse: its parameters are in its key, and in no other's", "[frame][reuse][keys]") {
    const Scene scene = scene_of({20, 14});
    frame::Settings base = ten_samples(8);
    base.pruning = false;
    const std::vector<graph::Key> before = test::keys_of(scene, base, Isa::scalar);
    const frame::Plan plan = frame::plan(scene, base);
    for (std::size_t i = 0; i < screen::fields(base.reuse).size(); ++i) {
        frame::Settings changed = base;
        std::vector<Field> fields = screen::fields(changed.reuse);
        CAPTURE(fields[i].name);
        if (fields[i].name == "frames") changed.reuse.frames = 9;
        if (fields[i].name == "clamp") changed.reuse.clamp = screen::ReuseClamp::box;
        if (fields[i].name == "sigma_depth") changed.reuse.sigma_depth *= 2;
        if (fields[i].name == "sigma_normal") changed.reuse.sigma_normal *= 2;
        const std::vector<graph::Key> after = test::keys_of(scene, changed, Isa::scalar);
        REQUIRE(after.size() == before.size());
        bool own = false;
        for (std::size_t k = 0; k < before.size(); ++k) {
            const std::string& name = plan.stages[k].name;
            if (name == "screen.reuse") own = before[k] != after[k];
            if (name == "gbuffer" || name == "rsm" || name == "rsm.disc" || name == "direct") CHECK(before[k] == after[k]);
        }
        CHECK(own);
    }
}

TEST_CASE("reuse: threads change no bit of a sequence", "[frame][reuse][bits]") {
    const Scene scene = scene_of({48, 36});
    const frame::Settings settings = ten_samples(8);
    Image4 expected;
    for (const int threads : {1, 3})
        for (const Isa isa : supported_isas()) {
            frame::KeptStages kept;
            RunOptions options;
            options.threads = threads, options.isa = isa;
            Image4 last;
            for (int f = 0; f < 3; ++f) {
                const Scene now = scene_at(scene, f);
                last = frame::execute(now, settings, frame::plan(now, settings), options, kept).radiance;
            }
            if (expected.empty()) expected = last;
            CHECK(same(last, expected));
        }
}
