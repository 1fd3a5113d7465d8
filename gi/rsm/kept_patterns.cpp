#include "gi/rsm/kept_patterns.h"

#include <algorithm>

#include "core/content_hasher.h"
#include "core/fields.h"

namespace plumb::rsm {

namespace {

std::uint64_t key_of(const GatherParams& params, int map_size, std::uint32_t seed) {
    ContentHasher h;
    GatherParams copy = params;
    for (const Field& f : fields(copy)) std::visit([&](const auto* value) { h.add(*value); }, f.value);
    h.add(map_size, seed, bool(params.own));
    if (params.own) h.add(params.own->name), h.add_all(params.own->rows);
    return h.hash;
}

}  // namespace

std::shared_ptr<const Pattern> KeptPatterns::of(const GatherParams& params, int map_size, std::uint32_t seed) {
    const std::uint64_t key = key_of(params, map_size, seed);
    auto found = std::find_if(made_.begin(), made_.end(), [&](const auto& m) { return m.first == key; });
    if (found == made_.end()) {
        made_.emplace_back(key, std::make_shared<const Pattern>(pattern_of(params, map_size, seed)));
        if (made_.size() > most) made_.erase(made_.begin());
        return made_.back().second;
    }
    std::rotate(found, found + 1, made_.end());
    return made_.back().second;
}

}  // namespace plumb::rsm
