#include "gi/parity/side_by_side.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <tuple>

namespace plumb::parity {

namespace {

constexpr std::uint64_t as_far_as_can_be = std::numeric_limits<std::uint64_t>::max();

// Floats in their order as integers: neighbours differ by 1, and -0 by 1 from 0.
std::int64_t ordered(float v) {
    std::int32_t bits;
    std::memcpy(&bits, &v, sizeof bits);
    return bits >= 0 ? bits : -std::int64_t(bits & 0x7fffffff) - 1;
}

// The device writes floats; ours are floats and integers.
std::uint64_t ulp_between(double a, double b) {
    const float x = float(a), y = float(b);
    if (std::isnan(x) && std::isnan(y)) return 0;
    if (std::isnan(x) || std::isnan(y)) return as_far_as_can_be;
    return std::uint64_t(std::abs(ordered(x) - ordered(y)));
}

void compare(TwoValues& line) {
    if (!line.ours || !line.theirs || line.ours->size() != line.theirs->size()) {
        line.same = false, line.ulp = as_far_as_can_be;
        return;
    }
    for (std::size_t c = 0; c < line.ours->size(); ++c) {
        const double a = (*line.ours)[c], b = (*line.theirs)[c];
        const std::uint64_t ulp = ulp_between(a, b);
        line.ulp = std::max(line.ulp, ulp);
        line.same = line.same && (ulp == 0 || (a == 0 && b == 0));
    }
}

// A value's name, sample and how many of these came before it.
using Key = std::tuple<std::string, int, int>;

std::vector<Key> keys_of(const std::vector<TapValue>& values) {
    std::map<std::pair<std::string, int>, int> met;
    std::vector<Key> keys;
    for (const TapValue& v : values) keys.push_back({v.name, v.sample, met[{v.name, v.sample}]++});
    return keys;
}

std::map<Key, std::size_t> places_of(const std::vector<Key>& keys) {
    std::map<Key, std::size_t> places;
    for (std::size_t i = 0; i < keys.size(); ++i) places[keys[i]] = i;
    return places;
}

}  // namespace

SideBySide side_by_side(const std::vector<TapValue>& ours, const std::vector<TapValue>& theirs,
                        const std::vector<std::string>& named) {
    const std::vector<Key> our_keys = keys_of(ours), their_keys = keys_of(theirs);
    const std::map<Key, std::size_t> our_places = places_of(our_keys), their_places = places_of(their_keys);
    SideBySide out;
    std::size_t next = 0;  // of theirs
    auto add_theirs_alone = [&](std::size_t end) {
        for (; next < end; ++next) {
            const TapValue& v = theirs[next];
            if (!our_places.count(their_keys[next])) out.lines.push_back({v.name, v.sample, "", {}, v.value});
        }
    };
    for (std::size_t i = 0; i < ours.size(); ++i) {
        const TapValue& v = ours[i];
        TwoValues line{v.name, v.sample, v.equation, v.value, {}};
        if (const auto place = their_places.find(our_keys[i]); place != their_places.end()) {
            add_theirs_alone(place->second);
            line.theirs = theirs[place->second].value;
        } else {
            line.compared = std::find(named.begin(), named.end(), v.name) != named.end();
        }
        out.lines.push_back(std::move(line));
    }
    add_theirs_alone(theirs.size());

    for (std::size_t i = 0; i < out.lines.size(); ++i) {
        TwoValues& line = out.lines[i];
        if (!line.compared) continue;
        compare(line);
        ++out.compared;
        out.signs += line.same && line.ulp > 0;
        if (!line.same && !out.parts_at) out.parts_at = i;
    }
    return out;
}

}  // namespace plumb::parity
