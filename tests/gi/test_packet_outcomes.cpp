// Outcomes of many pixels at once are those of each alone, to the bit, for every compute stage; and so is every verdict.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <map>

#include "core/device_profile.h"
#include "core/packet_outcomes.h"
#include "gi/parity/stages.h"
#include "gi/parity/verdict.h"
#include "tests/core/legal_device.h"
#include "tests/parity/twin_data.h"

using namespace plumb;
using parity::Verdict;

namespace {

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b); }
bool same(const std::vector<Outcome>& a, const std::vector<Outcome>& b) {
    const auto value = [](const BoundedValue& x, const BoundedValue& y) {
        return same(x.shadow, y.shadow) && same(x.bound, y.bound);
    };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](const Outcome& x, const Outcome& y) {
        return x.ambiguous == y.ambiguous &&
               std::equal(x.values.begin(), x.values.end(), y.values.begin(), y.values.end(), value);
    });
}

// Pixels that the stage writes, by groups of 16 and a rest.
std::vector<std::vector<glm::ivec2>> groups_of(const BoundStage& stage, glm::ivec2 size) {
    std::vector<std::vector<glm::ivec2>> groups(1);
    for (int i = 0; i < size.x * size.y; ++i) {
        const glm::ivec2 pixel(i % size.x, i / size.x);
        if (!stage.writes(pixel)) continue;
        if (groups.back().size() == PacketOutcomes::most) groups.emplace_back();
        groups.back().push_back(pixel);
    }
    return groups;
}

// A stage that computes one pixel at a time and nothing besides.
class OneByOne final : public BoundStage {
  public:
    explicit OneByOne(std::unique_ptr<BoundStage> stage) : stage_(std::move(stage)) {}
    void run(const RunOptions& options, const DeviceProfile& profile, Bundle& outputs) const override {
        stage_->run(options, profile, outputs);
    }
    bool writes(glm::ivec2 pixel) const override { return stage_->writes(pixel); }
    void outcomes(glm::ivec2 pixel, const DeviceProfile& profile, std::span<const float> got,
                  std::span<const std::int32_t> choices, std::vector<Outcome>& out) const override {
        stage_->outcomes(pixel, profile, got, choices, out);
    }
    void follow(glm::ivec2 pixel, DecisionTape& tape, std::vector<Followed>& out) const override {
        stage_->follow(pixel, tape, out);
    }
    std::vector<TapValue> explain(glm::ivec2, const DeviceProfile&) const override { return {}; }

  private:
    std::unique_ptr<BoundStage> stage_;
};
StageBinding one_by_one(const StageBinding& binding) {
    StageBinding b = binding;
    b.bind = [](const StageData& data) -> std::unique_ptr<BoundStage> {
        return std::make_unique<OneByOne>(parity::find_binding(data.stage, "test").bind(data));
    };
    return b;
}

// What a device wrote: ours, moved by parts of the bound from none to far beyond, by units in the last place, to
// another outcome, or to nonsense.
Bundle planted(const BoundStage& stage, const Bundle& own, glm::ivec2 size, const DeviceProfile& profile, int seed) {
    test::Random random{std::uint64_t(seed)};
    Bundle b = own;
    std::vector<Outcome> outcomes;
    for (int i = 0; i < size.x * size.y; ++i) {
        const glm::ivec2 pixel(i % size.x, i / size.x);
        if (!stage.writes(pixel)) continue;
        stage.outcomes(pixel, profile, {}, {}, outcomes);
        if (outcomes.empty()) continue;
        const Outcome& from = outcomes[std::size_t(random.below(int(outcomes.size())))];
        const int kind = random.below(8);
        std::size_t component = 0;
        for (Array& a : b.arrays) {
            const int n = int(a.bytes.size() / 4) / (size.x * size.y);
            for (int c = 0; c < n; ++c, ++component) {
                if (a.dtype != DType::f32) continue;
                float& got = reinterpret_cast<float*>(a.bytes.data())[i * n + c];
                const BoundedValue v = from.values.at(component);
                const double part = std::exp2(random.between(-4, 4)) * (random.below(2) ? 1 : -1);
                if (kind < 4) got = float(v.shadow + part * v.bound);
                if (kind == 4) got = test::neighbour(got, random.below(5) - 2);
                if (kind == 5) got = float(v.shadow + (random.below(2) ? 1 : -1) * v.bound * (1 + 1e-7 * (random.below(3) - 1)));
                if (kind == 6 && random.below(4) == 0) got *= 1 + float(random.between(-1e-3, 1e-3));
                if (kind == 7 && random.below(16) == 0) got = random.below(2) ? __builtin_nanf("") : __builtin_inff();
            }
        }
    }
    return b;
}

parity::StageVerdict judged(const StageBinding& binding, const StageData& data, const Bundle& got, const DeviceProfile& profile,
                            Isa isa, int threads) {
    std::vector<parity::Dumped> dumped;
    for (const Array& a : got.arrays) dumped.push_back({a.name, a, Format::rgba32f, 15});
    parity::JudgeOptions options;
    options.profile = profile, options.run.isa = isa, options.run.threads = threads;
    return parity::judge(binding, data, dumped, options);
}

bool same(const parity::StageVerdict& a, const parity::StageVerdict& b) {
    const auto worst = [](const parity::WorstPixel& x, const parity::WorstPixel& y) {
        return x.pixel == y.pixel && x.verdict == y.verdict && x.output == y.output && x.channel == y.channel &&
               same(x.expected, y.expected) && same(x.got, y.got) && same(x.bound, y.bound) && same(x.excess, y.excess);
    };
    return a.verdict == b.verdict && a.passed == b.passed && a.decided == b.decided && a.reason == b.reason &&
           a.count == b.count && a.nonzero_count == b.nonzero_count && a.map.texels == b.map.texels &&
           std::equal(a.worst.begin(), a.worst.end(), b.worst.begin(), b.worst.end(), worst);
}

constexpr glm::ivec2 size(21, 14);

}  // namespace

TEST_CASE("packets of pixels: every compute stage has the outcomes of each pixel alone", "[packet][verdict]") {
    const std::vector<Isa> isas = supported_isas();
    std::size_t turn = 0;
    std::map<std::string, int> pixels;
    for (const StageData& data : test::compute_cases(size)) {
        const std::unique_ptr<BoundStage> stage = parity::find_binding(data.stage, "test").bind(data);
        const auto* packets = dynamic_cast<const PacketOutcomes*>(stage.get());
        INFO(data.stage << " " << data.id);
        REQUIRE(packets);
        for (const char* profile : {"ideal", "nvidia-hopper-580"}) {
            const DeviceProfile device = find_profile(profile, "test");
            int differ = 0;
            for (const auto& group : groups_of(*stage, data.size)) {
                const Isa isa = isas[turn++ % isas.size()];
                std::vector<Outcome> together[PacketOutcomes::most], alone;
                if (group.empty()) continue;
                packets->outcomes(group, device, isa, together);
                for (std::size_t i = 0; i < group.size(); ++i) {
                    stage->outcomes(group[i], device, {}, {}, alone);
                    differ += !same(together[i], alone), ++pixels[data.stage];
                }
            }
            INFO(profile);
            CHECK(differ == 0);
        }
    }
    for (const StageBinding& b : parity::bindings())
        if (!b.raster) {
            INFO(b.info.name);
            CHECK(pixels[b.info.name] > 0);
        }
}

TEST_CASE("packets of pixels: verdicts are those of each pixel alone, with errors of every size about the bound",
          "[packet][verdict]") {
    std::array<std::int64_t, parity::verdicts> met{};
    const std::vector<Isa> isas = supported_isas();
    std::size_t turn = 0;
    for (const StageData& data : test::compute_cases(size)) {
        const StageBinding &binding = parity::find_binding(data.stage, "test"), alone = one_by_one(binding);
        const std::unique_ptr<BoundStage> stage = binding.bind(data);
        const DeviceProfile profile = find_profile(turn % 2 ? "ideal" : "nvidia-hopper-580", "test");
        Bundle own;
        stage->run({}, profile, own);
        const Bundle got = planted(*stage, own, data.size, profile, int(turn));
        const parity::StageVerdict one = judged(alone, data, got, profile, Isa::scalar, 1);
        const parity::StageVerdict many = judged(binding, data, got, profile, isas[turn++ % isas.size()], 2);
        INFO(data.stage << " " << data.id);
        CHECK(same(one, many));
        for (std::size_t i = 0; i < met.size(); ++i) met[i] += one.count[i];
    }
    for (const Verdict v : {Verdict::equal, Verdict::within_bound, Verdict::ambiguous, Verdict::wrong}) {
        INFO(parity::verdict_name(v));
        CHECK(met[std::size_t(v)] > 50);
    }
}
