#include "core/stage.h"

#include <fmt/format.h>

namespace plumb {

std::vector<ParamInfo> describe(const std::vector<Field>& fields) {
    std::vector<ParamInfo> rows;
    for (const Field& f : fields) {
        std::string range;
        if (!f.choices.empty())
            range = fmt::format("{}", fmt::join(f.choices, " | "));
        else if (type_name(f) == "string")
            range = "";  // words have no bounds
        else if (f.max != unbounded)
            range = fmt::format("{}..{}", f.min, f.max);
        else if (f.min != -unbounded)
            range = fmt::format(">= {}", f.min);
        rows.push_back({f.name, type_name(f), f.unit, f.meaning, value_text(f), range});
    }
    return rows;
}

}  // namespace plumb
