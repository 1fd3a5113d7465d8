// Sample patterns that are kept: the same bits as made anew, and never those of other parameters.
#include <catch2/catch.hpp>

#include "core/fields.h"
#include "gi/rsm/kept_patterns.h"

using namespace plumb;
using namespace plumb::rsm;

namespace {

bool same(const Pattern& a, const Pattern& b) {
    return a.samples == b.samples && a.rotations == b.rotations && a.offsets == b.offsets && a.positions == b.positions && a.weights == b.weights;
}

GatherParams small() {
    GatherParams params{.gather = Gather::disc};
    params.samples = 12, params.rotations = 16, params.directions = 3, params.steps = 4;
    params.spacing = Spacing::geometric;  // which reads growth, too
    return params;
}

}  // namespace

TEST_CASE("kept patterns: the same one for the same, until others were asked for", "[rsm][determinism]") {
    KeptPatterns kept;
    const GatherParams params = small();
    const auto first = kept.of(params, 64, 1);
    CHECK(same(*first, pattern_of(params, 64, 1)));
    CHECK(kept.of(params, 64, 1) == first);
    CHECK(kept.of(params, 32, 1) != first);
    CHECK(same(*kept.of(params, 32, 1), pattern_of(params, 32, 1)));
    CHECK(kept.of(params, 64, 1) == first);  // used last but one
    for (const int size : {8, 16, 24, 40}) kept.of(params, size, 1);
    CHECK(kept.of(params, 64, 1) != first);  // gone, but for whoever holds it
    CHECK(same(*first, *kept.of(params, 64, 1)));
}

TEST_CASE("kept patterns: every parameter that a pattern is made from is asked for", "[rsm][determinism]") {
    for (const Gather gather : {Gather::disc, Gather::paths}) {
        GatherParams params = small();
        params.gather = gather;
        const std::size_t count = fields(params).size();
        for (std::size_t i = 0; i < count; ++i) {
            GatherParams other = params;
            Field f = fields(other)[i];
            CAPTURE(f.name);
            if (f.name == "pattern") continue;  // a file
            if (auto n = std::get_if<int*>(&f.value)) **n = f.name == "rotations" ? 32 : f.choices.empty() ? **n + 1 : (**n + 1) % int(f.choices.size());
            else if (auto x = std::get_if<float*>(&f.value)) **x = **x > 1 ? **x / 2 : **x > 0.5f ? 0.25f : **x + 0.125f;
            else continue;
            KeptPatterns kept;
            kept.of(params, 64, 1);
            CHECK(same(*kept.of(other, 64, 1), pattern_of(other, 64, 1)));
        }
        params.sequence = Sequence::random;
        KeptPatterns kept;
        kept.of(params, 64, 1);
        CHECK(same(*kept.of(params, 64, 2), pattern_of(params, 64, 2)));
    }
    // A file's samples: by what it holds.
    GatherParams own = small();
    own.pattern = "a.npy";
    own.own = std::make_shared<const SampleRows>(SampleRows{"a.npy", "a.npy", {{1, 2, 3}, {4, 5, 6}}});
    KeptPatterns kept;
    const auto first = kept.of(own, 64, 1);
    own.own = std::make_shared<const SampleRows>(SampleRows{"a.npy", "a.npy", {{1, 2, 3}, {4, 7, 6}}});
    CHECK(kept.of(own, 64, 1) != first);
    CHECK(same(*kept.of(own, 64, 1), pattern_of(own, 64, 1)));
}
