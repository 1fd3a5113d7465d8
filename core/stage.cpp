#include "core/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

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

std::vector<ParamInfo> describe(const std::vector<Field>& fields, const std::vector<std::string>& names) {
    std::vector<ParamInfo> rows;
    for (const Field& f : fields)
        if (std::find(names.begin(), names.end(), f.name) != names.end()) rows.push_back(describe({f}).front());
    if (rows.size() != names.size()) throw std::logic_error("describe(): a name that is no field");
    return rows;
}

}  // namespace plumb
