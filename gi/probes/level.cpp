#include "gi/probes/level.h"

#include <algorithm>
#include <cmath>

#include "gi/lend.h"

namespace plumb::probes {

namespace {

constexpr float farthest = 0x1p60f;  // m: squares of differences stay within the range of floats
constexpr int fold = 1024;  // boxes in a row: a list of any length, and a device's 65535 groups a side

[[noreturn]] void refuse(const std::string& what) { throw InputError("probes.level: " + what); }

void check_box(const float* low, const float* high, int i) {
    for (int c = 0; c < 3; ++c) {
        if (!(std::fabs(low[c]) <= farthest && std::fabs(high[c]) <= farthest))
            refuse(fmt::format("box {}: expected coordinates within 2^60 m", i));
        // But for what rounding one of them may do: the kernel serves such a box as a point.
        if (low[c] - high[c] > 1e-5f * (std::fabs(low[c]) + std::fabs(high[c]))) refuse(fmt::format("box {}: low is above high", i));
    }
    if (!(low[3] >= 0 && low[3] <= farthest)) refuse(fmt::format("box {}: margin {}: expected 0 m or more", i, low[3]));
}

void check_rule(const LevelUniforms& u) {
    const auto within = [](const float* v, int n, float low, float high) {
        return std::all_of(v, v + n, [&](float x) { return x >= low && x <= high; });
    };
    const auto ascends = [](const float* v) { return v[0] <= v[1] && v[1] <= v[2]; };
    if (!within(u.eye, 3, -farthest, farthest)) refuse("eye: expected coordinates within 2^60 m");
    const float length = u.forward[0] * u.forward[0] + u.forward[1] * u.forward[1] + u.forward[2] * u.forward[2];
    if (!(std::fabs(length - 1) < 1e-5f)) refuse("forward: expected a unit vector");
    if (!within(u.zones, 4, -1, 1)) refuse("zones: expected cosines and sines");
    if (!within(u.scales, 3, 1, 1e6f) || !ascends(u.scales)) refuse("scales: expected ascending numbers from 1 on");
    if (!within(u.distances, 3, 0, farthest) || !ascends(u.distances)) refuse("distances: expected ascending numbers, 0 m or more");
    if (!within(u.margins, 3, 0, 1e6f) || !ascends(u.margins)) refuse("margins: expected ascending numbers, 0 or more");
}

}  // namespace

void check_levels(LevelView& v, Buffer<float>&) {
    check_rule(v.u);
    for (int i = 0; i < v.u.count; ++i)
        check_box(v.low + 4 * std::ptrdiff_t(i), v.high + 4 * std::ptrdiff_t(i), i);
}

StageData data_of(const LevelInputs& in) {
    if (!in.low || !in.high || in.low->empty()) refuse("no boxes");
    if (in.low->size() != in.high->size())
        refuse(fmt::format("{} low corners and {} high ones", in.low->size(), in.high->size()));
    if (in.low->size() > std::size_t(most_boxes)) refuse(fmt::format("{} boxes: expected at most {}", in.low->size(), most_boxes));
    const int count = int(in.low->size());
    const LevelRule& r = in.rule;
    LevelUniforms u{std::min(count, fold), (count + fold - 1) / fold, count, r.levels, {}, {}, {}, {}, {}, {}};
    const auto copy = [](const glm::vec4& from, float* to) {
        for (int c = 0; c < 4; ++c) to[c] = from[c];
    };
    copy(r.eye, u.eye), copy(r.forward, u.forward), copy(r.zones, u.zones), copy(r.scales, u.scales);
    copy(r.distances, u.distances), copy(r.margins, u.margins);
    StageData d = begin_data<LevelKernel>({u.width, u.height}, u);
    lend(d.inputs, "low", {count, 4}, &(*in.low)[0].x);
    lend(d.inputs, "high", {count, 4}, &(*in.high)[0].x);
    return d;
}

void run(const LevelInputs& in, const RunOptions& options, std::vector<std::int32_t>& levels) {
    const StageData data = data_of(in);
    levels.assign(std::size_t(data.size.x) * std::size_t(data.size.y), 0);
    Bundle outputs;
    lend(outputs, "level", {std::int64_t(levels.size()), 1}, levels.data());
    stage<LevelKernel>().bind(data)->run(options, {}, outputs);
    levels.resize(in.low->size());
}

PointLevel level_at(const LevelRule& r, const glm::vec3& p) {
    const float d = point_distance<float>(p, &r.eye.x, &r.forward.x, &r.zones.x, &r.scales.x);
    PointLevel l;
    l.level = level_of<float>({d, d, d}, &r.distances.x, r.levels);
    l.share = blend_of<float>(d, l.level, &r.distances.x, &r.widths.x, r.levels);
    return l;
}

}  // namespace plumb::probes
