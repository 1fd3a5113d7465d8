#include "tools/mutants/trial.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gi/parity/stages.h"
#include "tools/vulkan/runner.h"

namespace plumb::mutants {

Judge::Judge(const vulkan::Device& device, const TwinCompiler& compiler, const std::vector<Dispatch>& dispatches,
             const DeviceProfile& profile)
    : compiler_(compiler), panels_(device, dispatches, profile) {}

Trial Judge::unmutated(const std::string& stage) {
    const StageBinding& binding = parity::find_binding(stage, "plumb_mutants");
    return run(binding, compiler_.compile(binding), false);
}

Trial Judge::operator()(const Mutant& mutant, bool until_wrong, double scale) {
    const StageBinding& binding = parity::find_binding(mutant.stage, mutant.place);
    return run(binding, compiler_.compile(binding, mutant, scale), until_wrong);
}

Trial Judge::run(const StageBinding& binding, std::span<const std::uint32_t> spirv, bool until_wrong) {
    if (panels_.stage() != binding.info.name) panels_.hold(binding, {runnable(compiler_.compile(binding)), {}});
    panels_.use({runnable(spirv), {}});
    Trial trial;
    for (std::size_t i = 0; i < panels_.size(); ++i) {
        const parity::StageVerdict verdict = panels_.judge(i, panels_.run(i), until_wrong);
        const double pixels = double(std::max<std::int64_t>(verdict.pixels, 1));
        ++trial.runs;
        trial.passed = trial.passed && verdict.passed;
        trial.ambiguous = std::max(trial.ambiguous, double(verdict.count[int(parity::Verdict::ambiguous)]) / pixels);
        if (verdict.verdict > trial.verdict || trial.dispatch.empty()) {
            trial.verdict = verdict.verdict, trial.dispatch = panels_.dispatch(i).name, trial.pixels = verdict.pixels;
            trial.wrong_pixels = verdict.count[int(parity::Verdict::wrong)];
            trial.worst = verdict.worst.empty() ? parity::WorstPixel{} : verdict.worst.front();
        }
        if (until_wrong && trial.verdict == parity::Verdict::wrong) break;
    }
    return trial;
}

double smallest_error(Judge& judge, const Mutant& mutant) {
    const auto is_wrong = [&](double e) { return judge(mutant, true, 1 + e).verdict == parity::Verdict::wrong; };
    double found = 0.1, missed = 1e-8;
    if (!is_wrong(found)) return 0;
    while (found > 1.1 * missed) {
        const double e = std::sqrt(found * missed);
        (is_wrong(e) ? found : missed) = e;
    }
    return double(float(1 + found)) - 1;  // as the shader has it
}

}  // namespace plumb::mutants
