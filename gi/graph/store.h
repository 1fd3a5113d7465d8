// Where a graph keeps what its nodes made, beyond the program's run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/bundle.h"

namespace plumb::graph {

using Key = std::uint64_t;

// Neither function throws: what cannot be found is made, what cannot be kept is not.
class Store {
  public:
    virtual ~Store() = default;
    // What was kept under that key, checked against its checksum; nothing where there is none to be trusted.
    virtual std::optional<Bundle> find(Key key) = 0;
    // Published as a whole: who looks sees all of it or nothing. `what`: who made it, for messages.
    virtual void keep(Key key, const Bundle& bundle, const std::string& what) = 0;
};

}  // namespace plumb::graph
