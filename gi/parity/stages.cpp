#include "gi/parity/stages.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/nearest_known.h"
#include "gi/methods.h"

namespace plumb::parity {

const std::vector<StageBinding>& bindings() {
    static const std::vector<StageBinding> all = [] {
        std::vector<StageBinding> bound;
        for (const ListedStage& s : stages())
            if (s.binding) bound.push_back(*s.binding);
        return bound;
    }();
    return all;
}

const StageBinding& find_binding(const std::string& stage, const std::string& place) {
    std::vector<std::string> names;
    for (const StageBinding& b : bindings()) {
        if (b.info.name == stage) return b;
        names.push_back(b.info.name);
    }
    for (const ListedStage& s : stages())
        if (s.info.name == stage) throw InputError(fmt::format("{}: the stage \"{}\" has no twin: it runs on the host alone", place, stage));
    throw InputError(fmt::format("{}: unknown stage \"{}\"{}", place, stage, nearest_known(stage, names, "\"\"")));
}

}  // namespace plumb::parity
