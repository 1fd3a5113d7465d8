#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/stability/allowed.h"
#include "gi/stability/moved_inputs.h"
#include "gi/stability/stability.h"

namespace plumb::stability {

namespace {

// The larger one; not a number where either is none.
double worse(double a, double b) { return b > a || b != b ? b : a; }

// One component of the outputs, and the float that run() wrote there.
struct Component {
    const Slot* slot;
    int channel;
};

std::vector<Component> components_of(const StageBinding& binding) {
    std::vector<Component> out;
    for (const Slot& slot : binding.outputs)
        if (slot.dtype == DType::f32 && slot.kind != SlotKind::depth)
            for (int c = 0; c < slot.channels; ++c) out.push_back({&slot, c});
    return out;
}

// One pixel that is looked at.
struct Look {
    glm::ivec2 pixel{0};
    DecisionTape tape;
    std::vector<Followed> own;     // of the inputs as they are
    std::vector<double> change;    // by component: sum over inputs of |f(moved) - f|
    std::vector<double> of_input;  // the worst pattern of the input that is being moved
    std::int64_t flips = 0;
};

struct Evaluation {
    const StageBinding& binding;
    const StageData& data;
    const Effort& effort;
    const std::vector<Component> components = components_of(binding);
    Bundle outputs{};
    std::vector<Look> looks{};

    float written(glm::ivec2 pixel, std::size_t component) const {
        const Component& c = components[component];
        const auto i = std::size_t(pixel.y) * std::size_t(data.size.x) + std::size_t(pixel.x);
        float x;
        std::memcpy(
            &x,
            at(outputs, c.slot->name).bytes.data() + 4 * (i * std::size_t(c.slot->channels) + std::size_t(c.channel)),
            4);
        return x;
    }

    void pick_pixels(const BoundStage& stage);
    void record(const BoundStage& stage, Look& look) const;
    void follow(const BoundStage& stage, Look& look) const;
    void measure_condition(const BoundStage& stage);
    void move_given(const BoundStage& stage, Look& look) const;

    template <class Body>
    void each_look(const Body& body) {
        RunOptions quiet = effort.run;
        quiet.progress = nullptr;
        parallel_bands(int(looks.size()), 1, quiet, [&](int first, int last) {
            for (int i = first; i < last; ++i) body(looks[std::size_t(i)]);
        });
    }
};

// Pixels in the order of a hash: those that are not finite before others, and of those that are all 0 one in eight,
// while there are others.
void Evaluation::pick_pixels(const BoundStage& stage) {
    struct Candidate {
        std::uint32_t hash;
        glm::ivec2 pixel;
    };
    std::vector<Candidate> lit, dark;
    for (int y = 0; y < data.size.y; ++y)
        for (int x = 0; x < data.size.x; ++x) {
            if (!stage.writes({x, y})) continue;
            bool finite = true, zero = true;
            for (std::size_t c = 0; c < components.size(); ++c) {
                const float v = written({x, y}, c);
                finite = finite && is_float(v), zero = zero && v == 0;
            }
            const auto hash = std::uint32_t(pcg3d(x, y, 1).x) >> 1 | (finite ? 0x80000000u : 0);
            (zero ? dark : lit).push_back({hash, {x, y}});
        }
    auto by_hash = [](const Candidate& a, const Candidate& b) { return a.hash < b.hash; };
    std::stable_sort(lit.begin(), lit.end(), by_hash);
    std::stable_sort(dark.begin(), dark.end(), by_hash);

    const auto wanted = std::size_t(std::max(effort.pixels, 0));
    const std::size_t of_lit = std::min(lit.size(), wanted - std::min(dark.size(), wanted / 8));
    lit.resize(of_lit);
    dark.resize(std::min(dark.size(), wanted - of_lit));
    for (const std::vector<Candidate>* some : {&lit, &dark})
        for (const Candidate& c : *some) looks.push_back({c.pixel, {}, {}, {}, {}, 0});
}

// Every NaN is the same: kernels store one.
bool same_bits(float a, float b) { return number<float>::bits(a) == number<float>::bits(b) || (a != a && b != b); }

void Evaluation::record(const BoundStage& stage, Look& look) const {
    look.tape.record();
    stage.follow(look.pixel, look.tape, look.own);
    look.flips = look.tape.flips();
    look.change.assign(components.size(), 0);
    if (look.own.size() != components.size())
        throw std::logic_error(fmt::format("{}: follow() gives {} components, not {}", binding.info.name,
                                           look.own.size(), components.size()));
    for (std::size_t c = 0; c < components.size(); ++c)
        if (!same_bits(look.own[c].value, written(look.pixel, c)))
            throw std::logic_error(fmt::format("{}: pixel ({}, {}): {}[{}] is {:.9g} and run() has {:.9g}", data.label,
                                               look.pixel.x, look.pixel.y, components[c].slot->name,
                                               components[c].channel, look.own[c].value, written(look.pixel, c)));
}

// Runs on moved inputs and keeps the largest change. A change that is no number explains no error.
void Evaluation::follow(const BoundStage& stage, Look& look) const {
    std::vector<Followed> moved;
    look.tape.follow();
    stage.follow(look.pixel, look.tape, moved);
    if (!look.tape.at_end())
        throw std::logic_error(data.label + ": a kernel asks for fewer decisions than it has recorded");
    for (std::size_t c = 0; c < components.size(); ++c) {
        const double change = std::abs(moved[c].exact - look.own[c].exact);
        if (is_float(change)) look.of_input[c] = std::max(look.of_input[c], change);
    }
}

void start_input(Look& look) { look.of_input.assign(look.change.size(), 0); }
void end_input(Look& look) {
    for (std::size_t c = 0; c < look.change.size(); ++c) look.change[c] += look.of_input[c];
}

// The values that were handed to this pixel alone.
void Evaluation::move_given(const BoundStage& stage, Look& look) const {
    for (std::size_t g = 0; g < look.tape.given.size(); ++g) {
        const float own = look.tape.given[g];
        start_input(look);
        for (const bool up : {true, false}) {
            look.tape.given[g] = moved(own, up);
            follow(stage, look);
        }
        look.tape.given[g] = own;
        end_input(look);
    }
}

void Evaluation::measure_condition(const BoundStage& stage) {
    each_look([&](Look& look) { move_given(stage, look); });
    StageData copy = data;
    std::vector<float> before;
    for (const Input& input : inputs_of(binding, copy)) {
        for (Look& look : looks) start_input(look);
        for (int way = 0; way < ways_to_move(input, std::max(effort.patterns, 2)); ++way) {
            if (move(input, way, before)) {
                const std::unique_ptr<BoundStage> bound = binding.bind(copy);
                each_look([&](Look& look) { follow(*bound, look); });
            }
            put_back(input, before);
        }
        for (Look& look : looks) end_input(look);
    }
}

// The size that an error is reported relative to: of x, y and z the vector's length.
double scale_of(const Evaluation& e, const Look& look, std::size_t c) {
    const Component& component = e.components[c];
    if (component.slot->channels != 4 || component.channel == 3) return std::abs(look.own[c].exact);
    const Followed* v = &look.own[c - std::size_t(component.channel)];
    return std::sqrt(v[0].exact * v[0].exact + v[1].exact * v[1].exact + v[2].exact * v[2].exact);
}

// Adds one component of one pixel to the cell.
void judge(const Evaluation& e, const Look& look, std::size_t c, Cell& cell, double& digits) {
    const Followed& f = look.own[c];
    auto told = [&](const std::string& what) {
        const Component& component = e.components[c];
        return fmt::format("{}: pixel ({}, {}), {}[{}]: float {:.9g}, double {:.9g}, {}", e.data.label, look.pixel.x,
                           look.pixel.y, component.slot->name, component.channel, f.value, f.exact, what);
    };
    if (!is_float(f.value) || !is_float(f.exact)) {
        if (cell.nonfinite++ == 0) cell.reason = told("no finite float");
        return;
    }
    const double error = std::abs(double(f.value) - f.exact), size = std::abs(f.exact);
    const double explained = std::max({eps * size, look.change[c], least_step});
    const double condition = std::max(1.0, explained / std::max(eps * size, least_step));
    const double used = error / allowed_error(explained, cell.budget);
    const double scale = scale_of(e, look, c), lost = error / half_ulp(scale);
    cell.rel_error = worse(cell.rel_error, error / std::max(scale, least_normal));
    if (!(lost <= digits) && lost > 1)
        cell.most_lost = told(fmt::format("relative error {:.3g} at condition {:.3g}",
                                          error / std::max(scale, least_normal), condition));
    digits = worse(digits, lost);
    if (!(used <= cell.used)) {
        cell.used = used, cell.condition = condition;
        if (cell.nonfinite == 0)
            cell.reason = told(fmt::format("{:.2f} of {:g} {} at condition {:.3g}", used, cell.budget,
                                           by_the_floor(explained, cell.budget) ? "of 2^-126" : "eps condition",
                                           condition));
    }
}

bool verdict(const Cell& cell) {
    return (cell.refused || cell.pixels > 0) && cell.nonfinite == 0 && cell.used <= cell.budget;
}

}  // namespace

Cell evaluate(const StageBinding& binding, const StageData& data, const Effort& effort) {
    Cell cell;
    cell.stage = binding.info.name;
    cell.budget = binding.info.budget.c;
    std::unique_ptr<BoundStage> stage;
    try {
        stage = binding.bind(data);
    } catch (const InputError& e) {
        cell.refused = true, cell.reason = e.what();
        cell.ok = verdict(cell);
        return cell;
    }
    Evaluation e{binding, data, effort};
    stage->run(effort.run, {}, e.outputs);
    e.pick_pixels(*stage);
    e.each_look([&](Look& look) { e.record(*stage, look); });
    e.measure_condition(*stage);

    double digits = 0;
    cell.used = -1;  // so that the first component, however exact, tells its condition
    for (const Look& look : e.looks) {
        for (std::size_t c = 0; c < e.components.size(); ++c) judge(e, look, c, cell, digits);
        cell.flips += look.flips > 0;
        ++cell.pixels;
    }
    cell.used = worse(cell.used, 0);
    cell.digits_lost = digits > 1 ? host::log(digits) / host::log(10.0) : digits - digits;
    cell.ok = verdict(cell);
    return cell;
}

void merge(Cell& into, const Cell& other) {
    if (into.stage.empty()) {
        into = other;
        return;
    }
    // The reason is that of the worse one: what is not finite, else what uses up more, else what was refused.
    const bool worst = into.nonfinite == 0 && (other.nonfinite > 0 || !(other.used <= into.used) ||
                                               (into.pixels == 0 && other.pixels > 0) || into.reason.empty());
    if (worst) into.reason = other.reason;
    if (!(other.used <= into.used)) into.condition = other.condition;
    into.used = worse(into.used, other.used);
    into.rel_error = worse(into.rel_error, other.rel_error);
    if (!(other.digits_lost <= into.digits_lost)) into.most_lost = other.most_lost;
    into.digits_lost = worse(into.digits_lost, other.digits_lost);
    into.nonfinite += other.nonfinite, into.flips += other.flips, into.pixels += other.pixels;
    into.refused = into.refused || other.refused;
    into.ok = verdict(into);
}

}  // namespace plumb::stability
