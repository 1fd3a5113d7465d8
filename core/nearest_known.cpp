#include "core/nearest_known.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/fields.h"

namespace plumb {

namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; }

// Damerau 1964, "A technique for computer detection and correction of spelling errors": one row of a table a character of
// `a`, one column a character of `b`; an exchange looks two rows back.
std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> two_above, above(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        two_above = above, above = row;
        row[0] = i;
        for (std::size_t j = 1; j < row.size(); ++j) {
            const auto same = [&](std::size_t m, std::size_t n) { return lower(a[m - 1]) == lower(b[n - 1]); };
            row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + !same(i, j)});
            if (i > 1 && j > 1 && same(i, j - 1) && same(i - 1, j)) row[j] = std::min(row[j], two_above[j - 2] + 1);
        }
    }
    return row.back();
}

bool is_near(const std::string& a, const std::string& b, std::size_t distance) {
    const std::size_t shorter = std::min(a.size(), b.size()), longer = std::max(a.size(), b.size());
    const bool begins = std::equal(a.begin(), a.begin() + std::ptrdiff_t(shorter), b.begin(),
                                   [](char x, char y) { return lower(x) == lower(y); });
    return (begins && shorter >= 2) || (distance < longer && distance <= std::max<std::size_t>(longer / 3, 1));
}

// What a file calls something may be of any length.
std::string shortened(const std::string& name) { return name.size() > 60 ? name.substr(0, 60) + "..." : name; }

// In a list: in quotes where its end would not be seen.
std::string listed(const std::string& name) {
    const bool plain = !name.empty() && name.find_first_of(" ,") == std::string::npos;
    return plain ? shortened(name) : "\"" + shortened(name) + "\"";
}

}  // namespace

std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates) {
    std::string nearest;
    std::size_t least = ~std::size_t(0);
    for (const std::string& candidate : candidates)
        if (const std::size_t distance = edit_distance(name, candidate); distance < least) least = distance, nearest = candidate;
    return nearest;
}

std::string nearest_known(const std::string& name, const std::vector<std::string>& candidates, const char* quotes) {
    std::vector<std::string> near;
    std::vector<std::pair<std::size_t, std::string>> known;  // with their distances
    std::set<std::string> met;
    for (const std::string& candidate : candidates) {
        if (!met.insert(candidate).second) continue;
        known.push_back({edit_distance(name, candidate), candidate});
        if (is_near(name, candidate, known.back().first)) near.push_back(candidate);
    }
    if (!near.empty())
        return fmt::format("; the nearest known one is {}{}{}", quotes[0], shortened(nearest_name(name, near)), quotes[1]);
    if (known.empty()) return "";
    constexpr std::size_t most = 12;
    const std::size_t others = known.size() > most ? known.size() - most : 0;
    if (others > 0)
        std::stable_sort(known.begin(), known.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string> list;
    for (std::size_t i = 0; i < known.size() - others; ++i) list.push_back(listed(known[i].second));
    return fmt::format("; known: {}{}", fmt::join(list, ", "), others > 0 ? fmt::format(" and {} more", others) : "");
}

}  // namespace plumb
