// The dispatches of one stage on a device: data, buffers and what the twin itself writes are made once, and one pipeline a
// mutant serves them all.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gi/parity/verdict.h"
#include "tools/mutants/dispatches.h"
#include "tools/vulkan/runner.h"

namespace plumb::mutants {

// SPIR-V of a compute or a fragment stage, and of a vertex stage: empty for the one that is embedded.
struct Shaders {
    std::vector<std::uint32_t> spirv, vertex;
};

// The module as it runs: guarded (edit.h).
std::vector<std::uint32_t> runnable(std::span<const std::uint32_t> spirv);

// One thread's: all that it is given must outlive it.
class OnDevice {
  public:
    OnDevice(const vulkan::Device& device, const std::vector<Dispatch>& dispatches, const DeviceProfile& profile);
    ~OnDevice();
    OnDevice(OnDevice&&) noexcept;

    // Brings the stage's dispatches here, in place of another stage's. `twin` is the twin itself, as it runs. Dispatches on
    // which a twin cannot be judged, for what is not a number, are left out. Throws InputError where none is left.
    void hold(const StageBinding& binding, const Shaders& twin);
    const std::string& stage() const { return stage_; }

    std::size_t size() const { return held_.size(); }
    const Dispatch& dispatch(std::size_t i) const;

    void use(const Shaders& shaders);
    Bundle run(std::size_t i);
    bool is_as_the_twin(std::size_t i, const Bundle& outputs) const;
    parity::StageVerdict judge(std::size_t i, const Bundle& outputs, bool until_wrong) const;
    // From now on this dispatch is the first.
    void put_first(std::size_t i);

  private:
    struct Held;
    void adopt(Held& held, const Shaders& shaders);

    const vulkan::Device& device_;
    const std::vector<Dispatch>& dispatches_;
    const DeviceProfile& profile_;
    std::string stage_;
    std::vector<std::unique_ptr<Held>> held_;
    Shaders shaders_;
};

}  // namespace plumb::mutants
