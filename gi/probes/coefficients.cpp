#include "gi/probes/coefficients.h"

#include "core/sh.h"
#include "gi/lend.h"
#include "gi/probes/share.h"

namespace plumb::probes {

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
