// Changed twins on a device, held against the kernel: data, buffers and what the twin itself writes are made once a stage.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gi/parity/verdict.h"
#include "tools/mutants/dispatches.h"
#include "tools/mutants/generic.h"
#include "tools/vulkan/runner.h"
#include "tools/vulkan/twins.h"

namespace plumb::mutants {

// What became of a mutant.
enum class Fate : int {
    found,      // a verdict is `wrong`, or too much is ambiguous
    in_bounds,  // outputs have other bits, and every verdict lets them pass
    no_effect,  // a value differs, and no output
    same_value, // the changed instruction runs, and gives what the original gives
    unreached,  // it never runs
};
inline constexpr int fates = 5;
const char* fate_name(Fate fate);

// One thread's: all that it is given must outlive it.
class Bench {
  public:
    Bench(const vulkan::Device& device, const GenericMutants& all, const std::vector<Dispatch>& dispatches,
          const DeviceProfile& profile);
    ~Bench();
    Bench(Bench&&) noexcept;

    // Throws InputError where a twin itself, with its lines and its guards, does not pass.
    Fate operator()(const GenericMutant& mutant);

  private:
    struct Prepared;
    void check_twin(const TwinShader& shader);
    std::vector<std::unique_ptr<Prepared>>& prepared(const StageBinding& binding);
    void use(Prepared& first, const TwinShader& shader, std::span<const std::uint32_t> spirv);
    void use_too(Prepared& p, const Prepared& first, const TwinShader& shader, std::span<const std::uint32_t> spirv);
    parity::StageVerdict judged(const Prepared& p, const Bundle& outputs) const;
    bool changes_output(const TwinShader& shader, const SpirvModule& module);
    Fate run(const TwinShader& shader, const Site& site);
    Fate why(const TwinShader& shader, const Site& site);

    const vulkan::Device& device_;
    const GenericMutants& all_;
    const std::vector<Dispatch>& dispatches_;
    const DeviceProfile& profile_;
    std::string stage_;  // whose data is on the device
    std::vector<std::unique_ptr<Prepared>> prepared_;
};

}  // namespace plumb::mutants
