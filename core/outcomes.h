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

#include <algorithm>
#include <limits>
#include <numeric>

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

// What the first outcome becomes where any number of decisions come out otherwise, the others being those of one decision
// each, if what each changes is added to what the others change, as by the samples of a sum. Of what is not a sum it is a
// guess, so it is ambiguous.
inline Outcome added_up(const std::vector<Outcome>& ways) {
    Outcome all{{}, true};
    for (std::size_t v = 0; v < ways[0].values.size(); ++v) {
        const BoundedValue own = ways[0].values[v];
        double below = own.bound, above = own.bound;
        for (std::size_t w = 1; w < ways.size(); ++w) {
            const BoundedValue other = ways[w].values[v];
            const double change = other.shadow - own.shadow, more = std::max(0.0, other.bound - own.bound);
            below += std::max(0.0, more - change), above += std::max(0.0, more + change);
        }
        const double reach = 0.5 * (below + above) * (1 + 0x1p-50), infinity = std::numeric_limits<double>::infinity();
        if (reach < infinity)
            all.values.push_back({own.shadow + 0.5 * (above - below), reach});
        else
            all.values.push_back({own.shadow, infinity});
    }
    return all;
}

// The first outcome is the float kernel's own, if the choices allow it. Where there are more than `most`, `most` of them are
// followed by those that part from the first in one decision, if they are no more than that, and by one with bounds that hold
// all; it is ambiguous where an index was undecided, and then followed by added_up(). Choices that no device can make have no
// outcome.
template <class Run>
void enumerate_outcomes(Run&& run, int most, std::vector<Outcome>& out, std::span<const std::int32_t> choices = {}) {
    Decisions decisions;
    decisions.prescribed = choices;
    const DecisionScope scope(decisions);
    std::vector<Bounded> values;
    auto run_once = [&](std::vector<Outcome>& to) {
        decisions.begin();
        values.clear();
        run(values);
        if (!decisions.illegal) to.push_back(outcome_of(values, decisions.ambiguous));
    };

    out.clear();
    run_once(out);
    std::vector<Outcome> single = out;  // the float kernel's own, if it is legal, then those of one decision each
    const std::vector<int> options = decisions.options();
    const std::size_t own = out.size();
    // Each decision that the first run met has another outcome at least.
    for (int runs = 1; int(options.size()) < most; ++runs) {
        if (!decisions.next_path()) return;
        if (runs == most) break;
        run_once(out);
    }

    if (std::accumulate(options.begin(), options.end(), 0) - int(options.size()) < most)
        for (std::size_t d = 0; d < options.size(); ++d)
            for (int option = 1; option < options[d]; ++option) {
                decisions.part_at(d, option);
                run_once(single);
            }
    out.insert(out.end(), single.begin() + std::ptrdiff_t(own), single.end());
    decisions.widen = true;
    run_once(out);
    if (own > 0 && single.size() > 1 && out.back().ambiguous) out.push_back(added_up(single));
}

}  // namespace plumb
