#include "gi/parity/trial.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/inexact_inputs.h"
#include "core/parallel.h"

namespace plumb::parity {

namespace {

// A bound above that share of the largest value that was dumped says nothing: all agrees with it.
constexpr double widest_bound = 0x1p-6;
// Branches of two runs that are added up, each with each.
constexpr std::size_t most_sums = 64;

// The data with arrays that lie where they lay: what changes one copies that one.
StageData lent_data(const StageData& data) {
    StageData lent;
    lent.stage = data.stage, lent.label = data.label, lent.id = data.id;
    lent.size = data.size, lent.uniforms = data.uniforms;
    lent.reversed_z = data.reversed_z, lent.tiles = data.tiles;
    for (const Array& a : data.inputs.arrays)
        lent.inputs.arrays.push_back({a.name, a.dtype, a.shape, Bytes::lent(a.bytes.data(), a.bytes.size())});
    return lent;
}

bool same(const std::vector<Outcome>& a, const std::vector<Outcome>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Outcome& x, const Outcome& y) {
        return std::equal(x.values.begin(), x.values.end(), y.values.begin(), y.values.end(),
                          [](const BoundedValue& v, const BoundedValue& w) {
                              return v.shadow == w.shadow && v.bound == w.bound;
                          });
    });
}

// How far an input's numbers may be elsewhere goes with the input: of as many numbers in another shape, that one. Of another
// number of them nothing is known.
void fit_moved(StageData& data) {
    std::erase_if(data.inputs.arrays, [&](Array& moved) {
        if (!moved.name.ends_with(moved_name(""))) return false;
        const Array* input = find(data.inputs, moved.name.substr(0, moved.name.size() - moved_name("").size()));
        if (!input || input->shape == moved.shape) return false;
        if (input->bytes.size() != moved.bytes.size()) return true;
        moved.shape = input->shape;
        return false;
    });
}

}  // namespace

// The stage under a guess: as it is where the guess changes no data.
struct Trial::Changed {
    StageData data;
    std::unique_ptr<BoundStage> own;
    const BoundStage* stage = nullptr;
    bool patched = false;  // the scratch image holds the guess at the look's pixels
};

Trial::Trial(const StageBinding& binding, const StageData& data, const JudgeOptions& options,
             const StageVerdict& verdict, const std::vector<Pair>& pairs)
    : binding_(binding),
      data_(data),
      options_(options),
      verdict_(verdict),
      pairs_(pairs),
      stage_(binding.bind(data)) {
    for (const Slot& slot : binding.outputs) components_ += slot.channels;
    for (const Pair& p : pairs) {
        double largest = 0;
        for (std::size_t i = 0; i < verdict.map.size(); ++i)
            for (int c = 0; c < p.channels; ++c)
                if (const double got = p.compared(c) ? std::abs(p.got(i, c)) : 0; std::isfinite(got))
                    largest = std::max(largest, got);
        largest_.push_back(largest);
    }
}

std::size_t Trial::index(glm::ivec2 p) const { return std::size_t(p.y) * std::size_t(data_.size.x) + std::size_t(p.x); }
bool Trial::inside(glm::ivec2 p) const { return p.x >= 0 && p.y >= 0 && p.x < data_.size.x && p.y < data_.size.y; }

template <class Each>
void Trial::each_of(std::size_t count, const Each& each) const {
    RunOptions quiet = options_.run;
    quiet.progress = {};
    parallel_bands(int(count), 8, quiet, [&](int first, int last) {
        for (int i = first; i < last; ++i) each(std::size_t(i));
    });
}

// ---- One pixel under one guess

// Whether the dump may hold what was made.
bool Trial::holds(std::size_t at, const std::vector<BoundedValue>& values, double slack) const {
    for (const Pair& p : pairs_) {
        double largest = 0;
        for (int c = 0; c < p.channels; ++c)
            largest = std::max(largest, std::abs(values[std::size_t(p.first + c)].shadow));
        for (int c = 0; c < p.channels; ++c) {
            if (!p.compared(c)) continue;
            const BoundedValue& v = values[std::size_t(p.first + c)];
            const double bound = v.bound + slack * largest;
            if (!std::isfinite(bound) || !std::isfinite(v.shadow)) return false;
            const StoredRange range = p.stored(at, c, v.shadow - bound, v.shadow + bound, largest, options_.profile);
            const double got = p.got(at, c);
            if (!(got >= range.low && got <= range.high)) return false;
        }
    }
    return true;
}

// A guess that makes numbers so large that nothing is known of the result explains nothing.
bool Trial::says_something(const std::vector<BoundedValue>& values) const {
    for (std::size_t i = 0; i < pairs_.size(); ++i)
        for (int c = 0; c < pairs_[i].channels; ++c)
            if (pairs_[i].compared(c) &&
                !(values[std::size_t(pairs_[i].first + c)].bound <= widest_bound * largest_[i]))
                return false;
    return true;
}

double Trial::off(std::size_t at, const std::vector<BoundedValue>& values) const {
    double difference = 0, size = 0;
    for (const Pair& p : pairs_)
        for (int c = 0; c < p.channels; ++c) {
            if (!p.compared(c)) continue;
            const double made = values[std::size_t(p.first + c)].shadow, got = p.got(at, c);
            difference += std::abs(made - got), size += std::abs(made) + std::abs(got);
        }
    if (difference == 0) return 0;
    return difference <= size ? difference / size : 1;  // of what is no number, too
}

// What outputs hold at a pixel, as the one outcome.
std::vector<Outcome> Trial::own_outcome(const Bundle& outputs, std::size_t at) const {
    std::vector<Outcome> one(1);
    std::vector<BoundedValue>& values = one[0].values;
    values.reserve(std::size_t(components_));
    for (const Slot& slot : binding_.outputs) {
        const Array& array = plumb::at(outputs, slot.name);
        for (int c = 0; c < slot.channels; ++c) {
            const std::size_t word = at * std::size_t(slot.channels) + std::size_t(c);
            float f;
            std::int32_t n;
            std::memcpy(&f, array.bytes.data() + 4 * word, 4), std::memcpy(&n, array.bytes.data() + 4 * word, 4);
            values.push_back({slot.dtype == DType::f32 ? double(f) : double(n), 0});
        }
    }
    return one;
}

std::vector<Outcome> Trial::outcomes(const BoundStage& stage, glm::ivec2 ours, std::size_t at) const {
    std::vector<float> got(std::size_t(components_), std::nanf(""));
    for (const Pair& p : pairs_)
        for (int c = 0; c < p.channels; ++c)
            if (p.compared(c)) got[std::size_t(p.first + c)] = float(p.got(at, c));
    const std::size_t n = std::size_t(options_.choices_a_pixel);
    std::span<const std::int32_t> choices;
    if (n > 0) choices = {options_.choices.data() + at * n, n};
    std::vector<Outcome> all;
    stage.outcomes(ours, options_.profile, got, choices, all);
    return all;
}

// The colours of both; of all else the first.
std::vector<Outcome> Trial::added(const std::vector<Outcome>& to, const std::vector<Outcome>& more, int sign) const {
    std::vector<Outcome> all;
    for (const Outcome& a : to)
        for (const Outcome& b : more) {
            if (all.size() == most_sums) return all;
            all.push_back(a);
            all.back().ambiguous = a.ambiguous || b.ambiguous;
            std::size_t first = 0;
            for (const Slot& slot : binding_.outputs) {
                for (std::size_t c = first; c < first + std::size_t(std::min(slot.channels, 3)); ++c) {
                    if (slot.dtype != DType::f32) continue;
                    BoundedValue& v = all.back().values[c];
                    v.shadow += sign * b.values[c].shadow;
                    v.bound += b.values[c].bound;
                }
                first += std::size_t(slot.channels);
            }
        }
    return all;
}

bool Trial::agrees(const Hypothesis& h, const std::vector<Outcome>& outcomes, glm::ivec2 pixel) const {
    const bool undecided = verdict_.map.texels[index(pixel)] == std::uint8_t(Verdict::ambiguous);
    std::vector<BoundedValue> values;
    for (const Outcome& outcome : outcomes) {
        if (outcome.ambiguous) {
            if (undecided) return true;
            continue;
        }
        if (h.change && !says_something(outcome.values)) continue;
        values = outcome.values;
        if (h.result) h.result(pixel, values);
        if (holds(index(pixel), values, h.slack)) return true;
    }
    return false;
}

// ---- The stage under a guess

bool Trial::change_texels(const TexelChange& texels, const std::vector<glm::ivec2>& pixels, StageData& data) {
    for (Array& a : data.inputs.arrays) {
        if (a.name != texels.input) continue;
        const float* image = reinterpret_cast<const float*>(std::as_const(a.bytes).data());
        if (scratch_of_ != a.name) {
            scratch_.assign(image, image + a.bytes.size() / sizeof(float));
            scratch_of_ = a.name;
        }
        for (const glm::ivec2 p : pixels) {
            float* texel = scratch_.data() + index(p) * texels.channels;
            std::memcpy(texel, image + index(p) * texels.channels, sizeof(float) * texels.channels);
            texels.change(image, p, texel);
        }
        a.bytes = Bytes::lent(scratch_.data(), a.bytes.size());
        return true;
    }
    return false;
}

void Trial::restore_texels(const TexelChange& texels, const std::vector<glm::ivec2>& pixels) {
    const float* image = reinterpret_cast<const float*>(at(data_.inputs, texels.input).bytes.data());
    for (const glm::ivec2 p : pixels)
        std::memcpy(scratch_.data() + index(p) * texels.channels, image + index(p) * texels.channels,
                    sizeof(float) * texels.channels);
}

// `pixels`: those that are asked, or null for all.
bool Trial::change(const Hypothesis& h, const std::vector<glm::ivec2>* pixels, Changed& to) {
    to.stage = stage_.get();
    if (!h.change) return true;
    to.data = lent_data(data_);
    try {
        if (pixels && local_.count(h.texels.input))
            to.patched = change_texels(h.texels, *pixels, to.data);
        else if (!h.change(to.data))
            return false;
        fit_moved(to.data);
        to.own = binding_.bind(to.data);
    } catch (const InputError&) {
        return false;
    }
    to.stage = to.own.get();
    return true;
}

// Calls each(i, outcomes) for every pixel that the guess makes something of.
template <class Each>
bool Trial::each_outcomes(const Hypothesis& h, const Look& look, const Each& each) {
    if (h.outputs) {
        Bundle outputs;
        if (!h.outputs(look.pixels, outputs)) return false;
        each_of(look.pixels.size(), [&](std::size_t i) { each(i, own_outcome(outputs, index(look.pixels[i]))); });
        return true;
    }
    Changed changed;
    if (!change(h, &look.pixels, changed)) return false;
    const bool shared = !h.change && !h.place && look.outcomes.size() == look.pixels.size();
    each_of(look.pixels.size(), [&](std::size_t i) {
        const glm::ivec2 pixel = look.pixels[i], ours = h.place ? h.place(pixel) : pixel;
        if (shared) return each(i, look.outcomes[i]);
        if (!inside(ours) || !changed.stage->writes(ours)) return;
        std::vector<Outcome> all = outcomes(*changed.stage, ours, index(pixel));
        if (h.added != 0) all = added(outcomes(*stage_, ours, index(pixel)), all, h.added);
        each(i, all);
    });
    if (changed.patched) restore_texels(h.texels, look.pixels);
    return true;
}

// ---- Some pixels under one guess

Look Trial::look(std::vector<glm::ivec2> pixels) const {
    Look l{std::move(pixels)};
    l.outcomes.resize(l.pixels.size());
    each_of(l.pixels.size(), [&](std::size_t i) { l.outcomes[i] = outcomes(*stage_, l.pixels[i], index(l.pixels[i])); });
    return l;
}

// With NaN everywhere else the look's pixels come out as they did. Where a guess leads a kernel to other pixels still,
// these have what was dumped: it may be dropped too early, and is never named for it.
void Trial::find_local(const Look& look) {
    for (const Slot& slot : binding_.inputs) {
        const Array* array = find(data_.inputs, slot.name);
        if (!array || !slot.frame || slot.kind != SlotKind::image || slot.dtype != DType::f32 ||
            array->shape.size() < 2 || array->shape[0] != data_.size.y || array->shape[1] != data_.size.x)
            continue;
        const std::size_t n = array->bytes.size() / sizeof(float), channels = n / verdict_.map.size();
        std::vector<float> nowhere(n, std::nanf(""));
        const float* image = reinterpret_cast<const float*>(array->bytes.data());
        for (const glm::ivec2 p : look.pixels)
            std::copy_n(image + index(p) * channels, channels, nowhere.data() + index(p) * channels);
        StageData data = lent_data(data_);
        for (Array& a : data.inputs.arrays)
            if (a.name == slot.name) a.bytes = Bytes::lent(nowhere.data(), n * sizeof(float));
        try {
            const std::unique_ptr<BoundStage> stage = binding_.bind(data);
            std::vector<std::uint8_t> as_before(look.pixels.size());
            each_of(look.pixels.size(), [&](std::size_t i) {
                as_before[i] = same(outcomes(*stage, look.pixels[i], index(look.pixels[i])), look.outcomes[i]);
            });
            if (std::find(as_before.begin(), as_before.end(), 0) == as_before.end()) local_.insert(slot.name);
        } catch (const InputError&) {
        }
    }
}

std::vector<std::uint8_t> Trial::agreement(const Hypothesis& h, const Look& look) {
    std::vector<std::uint8_t> agree(look.pixels.size());
    const bool served = each_outcomes(h, look, [&](std::size_t i, const std::vector<Outcome>& all) {
        agree[i] = agrees(h, all, look.pixels[i]);
    });
    return served ? agree : std::vector<std::uint8_t>{};
}

std::vector<std::uint8_t> Trial::agreement_of_many(const Hypothesis& h, const std::vector<glm::ivec2>& pixels) {
    if (h.outputs || h.added != 0) return agreement(h, {pixels});
    Changed changed;
    if (!change(h, nullptr, changed)) return {};
    Bundle outputs;
    changed.stage->run(options_.run, options_.profile, outputs);
    std::vector<std::uint8_t> agree(pixels.size());
    each_of(agree.size(), [&](std::size_t i) {
        const glm::ivec2 pixel = pixels[i], ours = h.place ? h.place(pixel) : pixel;
        if (!inside(ours) || !changed.stage->writes(ours)) return;
        agree[i] = agrees(h, own_outcome(outputs, index(ours)), pixel) ||
                   agrees(h, outcomes(*changed.stage, ours, index(pixel)), pixel);
    });
    return agree;
}

double Trial::distance(const Hypothesis& h, const Look& look) {
    std::vector<double> far(look.pixels.size(), 1);
    const bool served = each_outcomes(h, look, [&](std::size_t i, const std::vector<Outcome>& all) {
        for (const Outcome& outcome : all)
            if (!outcome.ambiguous) far[i] = std::min(far[i], off(index(look.pixels[i]), outcome.values));
    });
    double sum = 0;
    for (const double x : far) sum += x;
    return served ? sum : std::numeric_limits<double>::infinity();
}

}  // namespace plumb::parity
