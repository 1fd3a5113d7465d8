// Every way in which one invocation of a kernel may legally come out, by running it over Bounded once a combination of
// its undecided comparisons and indices (core/decisions.h).
//
//     const PrecisionScope precision(profile.precision);
//     enumerate_outcomes(
//         [&](std::vector<Bounded>& values) {
//             NoTap tap;
//             const vec3<Bounded> e = rsm::gather_disc<Bounded>(in, pixel.x, pixel.y, tap);
//             values.insert(values.end(), {e.x, e.y, e.z, Bounded(1.0f)});
//         },
//         most_outcomes, out, choices);
//
// The run appends all components of all outputs, in the outputs' order. It must do the same for the same decisions: no
// state may outlive it. `choices` are what the device dumped, in the order in which the kernel calls chosen().
#pragma once

#include "core/binding.h"
#include "core/bounded.h"
#include "core/inexact_inputs.h"

namespace plumb {

inline constexpr int most_outcomes = 32;

inline Outcome outcome_of(const std::vector<Bounded>& values, bool ambiguous) {
    Outcome outcome{{}, ambiguous};
    outcome.values.reserve(values.size());
    for (const Bounded& v : values) {
        outcome.values.push_back({v.shadow, v.bound});
        outcome.ambiguous = outcome.ambiguous || v.ambiguous;
    }
    return outcome;
}

// The first outcome is the float kernel's own. Where there are more than `most` there is one, with bounds that hold
// them all; it is ambiguous where an index was undecided. Choices that no device can make have no outcome.
template <class Run>
void enumerate_outcomes(Run&& run, int most, std::vector<Outcome>& out, std::span<const std::int32_t> choices = {}) {
    Decisions decisions;
    decisions.prescribed = choices;
    const DecisionScope scope(decisions);
    std::vector<Bounded> values;
    auto run_once = [&] {
        decisions.begin();
        values.clear();
        run(values);
        if (!decisions.illegal) out.push_back(outcome_of(values, decisions.ambiguous));
    };

    out.clear();
    for (int runs = 0; runs < most; ++runs) {
        run_once();
        // Each decision that the first run met has another outcome at least.
        if (runs == 0 && decisions.met() >= std::size_t(most)) break;
        if (!decisions.next_path()) return;
    }
    decisions.widen = true;
    out.clear();
    run_once();
}

}  // namespace plumb
