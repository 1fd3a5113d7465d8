#include "io/findings.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "io/file.h"

namespace plumb::io {

bool Findings::counted(std::string_view kind) {
    const auto at = std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& k) { return k.name == kind; });
    if (at == kinds_.end()) return false;
    ++at->more;
    return true;
}

void Findings::add(std::string_view kind, const std::string& path, std::int64_t line, const std::string& cause,
                   const std::string& instead) {
    if (counted(kind)) return;
    const std::string place = line > 0 ? fmt::format("line {}", line) : "";
    if (strict_) throw InputError(shown(path), place, cause + "; --strict refuses that");
    kinds_.push_back({std::string(kind), InputError(shown(path), place, cause).what() + (": " + instead)});
}

std::vector<std::string> Findings::notes() const {
    std::vector<std::string> lines;
    for (const Kind& kind : kinds_)
        lines.push_back(kind.more == 0 ? kind.text : fmt::format("{} (and {} more of the kind)", kind.text, kind.more));
    return lines;
}

}  // namespace plumb::io
