// Frames that reuse what did not change: a stage whose key (gi/graph/graph.h) is that of what is kept does not run.
#pragma once

#include <functional>
#include <memory>

#include "gi/frame/frame.h"

namespace plumb::frame {

struct KeptMemory;  // kept_memory.h

// One frame: the last output of every stage, the geometry and what rays need of it. Nothing of it is copied; where a
// stage runs again, it writes over what it made before.
class KeptStages {
  public:
    using OtherKey = std::function<graph::Key(const graph::Node&, graph::Key)>;
    // Other keys than the stages' own: a test breaks one and must see the picture change.
    explicit KeptStages(OtherKey other = {});
    ~KeptStages();

    KeptMemory& memory() { return *memory_; }
    const OtherKey& other_key() const { return other_key_; }

  private:
    std::unique_ptr<KeptMemory> memory_;
    OtherKey other_key_;
};

// As execute() of frame.h, bit for bit, but a stage whose key is that of what is kept does not run. The frame lies in
// `kept` until the next call; after an exception nothing is kept.
const Frame& execute(const Scene& scene, const Settings& settings, const Plan& plan, const RunOptions& options,
                     KeptStages& kept, const Progress& progress = {}, const Stores& stores = {});

}  // namespace plumb::frame
