#include "gi/probes/coefficients.h"

#include <cmath>

#include "core/sh.h"
#include "gi/lend.h"
#include "gi/probes/share.h"

namespace plumb::probes {

namespace {

// Columns [first, last) of `count` rows of `columns` numbers.
struct Numbers {
    const char* name;
    const float* at;
    std::size_t count, columns = 1, first = 0, last = 1;
};

// `within` is false for what is not a number.
template <class Within>
void require_all(const char* stage, const Numbers& n, const char* expected, Within within) {
    for (std::size_t i = 0; i < n.count; ++i)
        for (std::size_t c = n.first; c < n.last; ++c)
            if (const float x = n.at[i * n.columns + c]; !within(x))
                throw InputError(fmt::format("{}: {}: number {} is {:g}: expected {}", stage, n.name, i * n.columns + c, x, expected));
}

}  // namespace

void check_share(ShareView& v, Buffer<float>&) {
    const std::size_t receivers = std::size_t(v.u.width), rays = std::size_t(v.u.height);
    require_all("probes.share", {"supporting", v.supporting, receivers * std::size_t(v.u.slots), 4, 3, 4}, "a weight of 0, or 2^-64 to 1",
                [](float w) { return w == 0 || (w >= least_weight && w <= most_weight); });
    require_all("probes.share", {"factors", v.factors, rays}, "0 to 4 pi sr", [](float f) { return f >= 0 && f <= most_factor; });
    require_all("probes.share", {"lengths", v.lengths, rays * receivers}, "0 to 1e16 m",
                [](float x) { return x >= 0 && x <= most_length; });
}

void check_coefficients(CoefficientsView& v, Buffer<float>&) {
    const std::size_t receivers = std::size_t(v.u.width), rays = std::size_t(v.u.rays);
    const auto near = [](float x) { return std::fabs(x) <= most_coordinate; };
    require_all("probes.coefficients", {"supporting", v.supporting, receivers * std::size_t(v.u.slots), 4, 0, 4},
                "a coordinate within 2^60 m, and a weight", near);
    require_all("probes.coefficients", {"seen", v.seen, rays * receivers, 4, 0, 4}, "a coordinate within 2^60 m", near);
    require_all("probes.coefficients", {"shares", v.shares, rays * receivers}, "a finite number",
                [](float x) { return std::isfinite(x); });
}

std::vector<std::int32_t> coefficient_rows(int slots, int degree) {
    std::vector<std::int32_t> rows;
    for (int slot = 0; slot < slots; ++slot)
        for (int l = 0; l <= degree; ++l)
            for (int m = -l; m <= l; ++m)
                for (const int value : {slot, l, std::abs(m), m < 0 ? 1 : 0}) rows.push_back(value);
    return rows;
}

StageData data_of(const ShareInputs& in) {
    const ShareUniforms u{in.receivers, in.rays, in.slots, in.published ? 1 : 0};
    StageData data = begin_data<ShareKernel>({in.receivers, in.rays}, u);
    const std::int64_t receivers = in.receivers;
    lend(data.inputs, "supporting", {in.slots * receivers, 4}, &in.supporting->x);
    lend(data.inputs, "factors", {in.rays}, in.factors);
    lend(data.inputs, "visible", {in.rays * receivers}, in.visible);
    lend(data.inputs, "lengths", {in.rays * receivers}, in.lengths);
    return data;
}

StageData data_of(const CoefficientsInputs& in) {
    const int count = sh::count(in.degree);
    const CoefficientsUniforms u{in.receivers, in.slots * count, in.rays, in.slots};
    StageData data = begin_data<CoefficientsKernel>({u.width, u.height}, u);
    const std::int64_t receivers = in.receivers;
    lend(data.inputs, "rows", {u.height, 4}, in.rows);
    lend(data.inputs, "recurrence", {sh::recurrence_size}, sh::recurrence().data());
    lend(data.inputs, "supporting", {in.slots * receivers, 4}, &in.supporting->x);
    lend(data.inputs, "seen", {in.rays * receivers, 4}, &in.seen->x);
    lend(data.inputs, "visible", {in.rays * receivers}, in.visible);
    lend(data.inputs, "shares", {in.rays * receivers}, in.shares);
    return data;
}

}  // namespace plumb::probes
