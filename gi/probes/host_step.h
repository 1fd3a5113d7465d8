// A step that no device could run, as `plumb stages` lists it.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/fields.h"
#include "core/stage.h"

namespace plumb::probes {

// params: names out of those that fields(Params&) lists.
template <class Params>
StageInfo host_step(const std::string& name, const std::string& source, std::vector<Port> inputs, std::vector<Port> outputs,
                    const std::vector<std::string>& params) {
    Params defaults;
    StageInfo s;
    s.name = name, s.source = source;
    s.inputs = std::move(inputs), s.outputs = std::move(outputs);
    s.params = describe(fields(defaults), params);
    return s;
}

}  // namespace plumb::probes
