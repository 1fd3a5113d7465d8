// The stages of this folder, in the place of the program's own (gi/methods.cpp): what works for all stages works for them.
#include "gi/methods.h"

#include "core/kernel_stage.h"
#include "tests/proof/stages.h"
#include "twins/tests.proof.list.comp.h"
#include "twins/tests.proof.pair.comp.h"
#include "twins/tests.proof.step.comp.h"

namespace plumb {

using namespace proof;

// One lane at a time serves these tests; shade_rows.h is for kernel files.
template <class Kernel>
struct OneLane {
    using View = typename Kernel::View;
    static void run(const View& in, int first, int last, const Tiles&, float*) {
        NoTap tap;
        for (int y = first; y < last; ++y)
            for (int x = 0; x < in.u.width; ++x) {
                const auto value = Kernel::template item<float>(in, x, y, tap);
                if constexpr (requires { Kernel::out(in); })
                    number<float>::store4(Kernel::out(in), y * in.u.width + x, value, true);
                else
                    Kernel::template store<float>(in, y * in.u.width + x, value, true);
            }
    }
};
template <Isa isa>
struct Rows<ListKernel, isa> : OneLane<ListKernel> {};
template <Isa isa>
struct Rows<PairKernel, isa> : OneLane<PairKernel> {};
template <Isa isa>
struct Rows<StepKernel, isa> : OneLane<StepKernel> {};

template <>
const StageBinding& stage<ListKernel>() { return made<ListKernel, twins::tests_proof_list_comp>(); }
template <>
const StageBinding& stage<PairKernel>() { return made<PairKernel, twins::tests_proof_pair_comp>(); }
template <>
const StageBinding& stage<StepKernel>() { return made<StepKernel, twins::tests_proof_step_comp>(); }

const std::vector<ListedStage>& stages() {
    static const std::vector<ListedStage> all = {{stage<ListKernel>().info, &stage<ListKernel>()},
                                                 {stage<PairKernel>().info, &stage<PairKernel>()},
                                                 {stage<StepKernel>().info, &stage<StepKernel>()}};
    return all;
}

}  // namespace plumb
