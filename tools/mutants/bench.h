// Generic mutants on a device, held against the kernel: found or not, and if not, why.
#pragma once

#include "tools/mutants/generic.h"
#include "tools/mutants/on_device.h"

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
          const DeviceProfile& profile)
        : all_(all), panels_(device, dispatches, profile) {}

    // Throws InputError where a twin itself, with its lines and its guards, does not pass.
    Fate operator()(const GenericMutant& mutant);

  private:
    void hold(const StageBinding& binding);
    void use(const TwinShader& shader, const SpirvModule& module);
    bool changes_output(const TwinShader& shader, const SpirvModule& module);
    Fate run(const TwinShader& shader, const Site& site);
    Fate why(const TwinShader& shader, const Site& site);

    const GenericMutants& all_;
    OnDevice panels_;
    std::vector<std::uint32_t> fragment_;  // of a raster stage, as it runs
};

}  // namespace plumb::mutants
