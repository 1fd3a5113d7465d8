// The rare side of core/bounded.h: what is undecided.
#include "core/bounded.h"

#include "core/device_profile.h"

namespace plumb {

constinit thread_local BoundedState bounded_state;

PrecisionScope::PrecisionScope(const Precision& p) : saved_(bounded_state) {
    BoundedState& s = bounded_state;
    s.add = p.add * ulp_ratio, s.multiply = p.multiply * ulp_ratio;
    s.divide = (p.divide + p.multiply) * ulp_ratio, s.sqrt = p.sqrt * ulp_ratio;
    s.exp2 = p.exp2 * ulp_ratio, s.exp2_slope = p.exp2_slope * ulp_ratio;
    s.log2 = p.log2 * ulp_ratio, s.log2_absolute = p.log2_absolute;
    s.flushed = p.flushes_denormals ? 0x1p-126 : 0;
    s.underflow = p.flushes_denormals ? 0x1p-126 : 0x1p-149;
}

PrecisionScope::~PrecisionScope() {
    Decisions* decisions = bounded_state.decisions;
    bounded_state = saved_;
    bounded_state.decisions = decisions;
}

bool Decisions::next_path() {
    while (!path_.empty() && path_.back().taken + 1 == path_.back().options) path_.pop_back();
    if (path_.empty()) return false;
    ++path_.back().taken;
    return true;
}

std::vector<int> Decisions::options() const {
    std::vector<int> n;
    for (std::size_t i = 0; i < at_; ++i) n.push_back(path_[i].options);
    return n;
}

void Decisions::part_at(std::size_t decision, int option) {
    // Their numbers of options do not matter: nobody asks for the path after this one.
    path_.assign(decision, {0, 1});
    path_.push_back({option, option + 1});
}

int Decisions::choose(int options) {
    if (at_ == path_.size()) path_.push_back({0, options});
    return path_[at_++].taken;
}

bool Decisions::flipped(std::int32_t slot) {
    std::int8_t& answer = slots_[std::size_t(slot - 1)];
    if (answer == unasked) answer = std::int8_t(choose(2));
    return answer != 0;
}

bool Decisions::take_prescribed(std::int32_t& choice) {
    if (next_prescribed_ >= prescribed.size()) return false;
    choice = prescribed[next_prescribed_++];
    return true;
}

namespace {

// More options than that are not followed one by one.
constexpr double most_options = 8;

bool enumerable(double first, double last) {
    const Decisions* d = bounded_state.decisions;
    return d && !d->widen && last - first < most_options && first >= -0x1p31 && last < 0x1p31;
}

// The float kernel's own option first, then the others, upwards.
double next_option(double first, double last, double own) {
    const int option = bounded_state.decisions->choose(int(last - first) + 1);
    if (own < first || own > last) return first + option;
    if (option == 0) return own;
    return first + (first + (option - 1) < own ? option - 1 : option);
}

}  // namespace

Bounded undecided_select(BoundedMask m, const Bounded& a, const Bounded& b) {
    if (m.slot > 0) return m.resolved() ? a : b;
    const Bounded &own = m.value ? a : b, &other = m.value ? b : a;
    Bounded r = own;
    r.ambiguous = a.ambiguous || b.ambiguous;
    if (!bounded_state.decisions) {
        r.ambiguous = true;
        return r;
    }
    // Widens to the hull of both.
    r.additions = 0, r.blend = false;
    const double reach = abs(own.shadow - other.shadow) + other.bound;
    if (!(reach <= r.bound)) r.bound = reach == reach ? reach : __builtin_inf();
    return r;
}

std::int32_t undecided_index(double first, double last, std::int32_t own) {
    if (enumerable(first, last)) return std::int32_t(next_option(first, last, own));
    if (bounded_state.decisions) bounded_state.decisions->ambiguous = true;
    return own;
}

Bounded undecided_floor(const Bounded& a, double first, double last) {
    if (enumerable(first, last)) {
        const double chosen = next_option(first, last, floor(double(a.value)));
        return within_ends(float(chosen), chosen, chosen, chosen, a.ambiguous);
    }
    const double own = floor(a.shadow);
    if (bounded_state.decisions) return within_ends(floor(a.value), own, first, last, a.ambiguous);
    return Bounded::within(floor(a.value), own, 0, true);
}

std::int32_t chosen(const Bounded& x) {
    const double first = floor(x.low()), last = floor(x.high());
    const std::int32_t own = number<float>::truncate_to_index(floor(x.value));
    Decisions* d = bounded_state.decisions;
    std::int32_t choice;
    if (!d || !d->take_prescribed(choice)) return decided_index(first, last, own);
    if (first <= choice && choice <= last) return choice;
    d->illegal = true;
    return own;
}

}  // namespace plumb
