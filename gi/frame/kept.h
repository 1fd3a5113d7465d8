// What stages made, kept by what they were made from, so that a frame reuses what did not change.
//
// Every stage has a key: a hash of everything that its output depends on, that is, of its parameters, of what it reads
// of the scene, and of the keys of the stages that it reads. Equal keys are equal bits.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "gi/frame/frame.h"

namespace plumb::frame {

// The key of each stage of the plan, in its order; one that is left out has the key of what stands in its place. The
// instruction set counts where native rays are asked.
std::vector<std::uint64_t> stage_keys(const Scene& scene, const Settings& settings, const Plan& plan, Isa isa);

struct KeptMemory;  // kept_memory.h

// One frame: the last output of every stage, the geometry and what rays need of it. Nothing of it is copied; where a
// stage runs again, it writes over what it made before.
class KeptStages {
  public:
    using KeysOf = std::function<std::vector<std::uint64_t>(const Scene&, const Settings&, const Plan&, Isa)>;
    // Other keys than stage_keys(): a test breaks one and must see the picture change.
    explicit KeptStages(KeysOf keys = {});
    ~KeptStages();

    KeptMemory& memory() { return *memory_; }
    const KeysOf& other_keys() const { return other_keys_; }

  private:
    std::unique_ptr<KeptMemory> memory_;
    KeysOf other_keys_;
};

// As execute() of frame.h, bit for bit, but a stage whose key is that of what is kept does not run. The frame lies in
// `kept` until the next call; after an exception nothing is kept.
const Frame& execute(const Scene& scene, const Settings& settings, const Plan& plan, const RunOptions& options,
                     KeptStages& kept, const Progress& progress = {}, reference::Store* store = nullptr);

}  // namespace plumb::frame
