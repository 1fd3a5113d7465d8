#include "gi/parity/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/nearest_known.h"
#include "core/packet_outcomes.h"
#include "core/parallel.h"
#include "gi/parity/pair.h"
#include "gi/parity/stored.h"

namespace plumb::parity {

namespace {

struct Judged {
    Verdict verdict = Verdict::equal;
    WorstPixel worst;
    bool unwritten = false;
};

class Judge {
  public:
    Judge(const StageBinding& binding, const StageData& data, const std::vector<Dumped>& dumped,
          const JudgeOptions& options)
        : binding_(binding), data_(data), options_(options), stage_(binding.bind(data)),
          packets_(dynamic_cast<const PacketOutcomes*>(stage_.get())) {
        stage_->run(options.run, options.profile, expected_);
        for (const Slot& slot : binding.outputs) components_ += slot.channels;
        for (const Dumped& d : dumped) pairs_.push_back(pair(d));
        if (pairs_.empty()) throw InputError(data.label + ": no output was dumped");
        if (!options.covered.empty() && options.covered.size() != pixels())
            throw InputError(data.label + ": where something is seen has another size");
        quantise_expected();
        find_images();
        find_flags();
    }

    const std::vector<Pair>& pairs() const { return pairs_; }

    bool judged(glm::ivec2 pixel) const { return seen(pixel) && stage_->writes(pixel); }
    bool left_out(glm::ivec2 pixel) const { return !seen(pixel) && stage_->writes(pixel); }

    bool expects_nothing(glm::ivec2 pixel) const {
        return reads_nothing(index(pixel)) || std::all_of(pairs_.begin(), pairs_.end(), [&](const Pair& p) {
                   return p.expects_nothing(index(pixel));
               });
    }

    // At none of the pixels that are judged.
    bool reads_nothing() const {
        for (std::size_t i = 0; i < pixels(); ++i)
            if (judged(place(i)) && !reads_nothing(i)) return false;
        return true;
    }

    // Where the dump is the same at every pixel that was judged: "0" or "NaN"; else "".
    std::string one_value() const {
        bool zero = true, nan = true;
        for (const Pair& p : pairs_)
            for (int c = 0; c < p.channels; ++c)
                for (std::size_t i = 0; i < pixels() && p.compared(c) && !(c == 3 && p.w_is_flag) && (zero || nan); ++i) {
                    if (!judged(place(i))) continue;
                    const double got = p.got(i, c);
                    zero = zero && got == 0, nan = nan && got != got;
                }
        return zero ? "0" : nan ? "NaN" : "";
    }

    // What needs no bound; false where it does.
    bool at_sight(glm::ivec2 pixel, Judged& j) const {
        const std::size_t at = index(pixel);
        if (const Pair* p = unwritten(at)) return j = never_written(*p, at, pixel), true;
        if (same_bits(at)) return true;
        j.worst.pixel = pixel;
        if (not_a_number(at, j.worst)) return j.verdict = Verdict::wrong, true;
        if (const WorstPixel w = rounded_alike(at); w.excess <= 1) {
            j.verdict = Verdict::within_bound, j.worst = w;
            j.worst.pixel = pixel, j.worst.verdict = j.verdict;
            return true;
        }
        return false;
    }

    // Of pixels that at_sight() left, at most PacketOutcomes::most: few of them are quicker one by one.
    void operator()(std::span<const glm::ivec2> pixels, Judged* j) const {
        constexpr std::size_t few = 3;
        std::vector<Outcome> outcomes[PacketOutcomes::most];
        if (packets_ && pixels.size() > few && options_.choices_a_pixel == 0)
            packets_->outcomes(pixels, options_.profile, options_.run.isa, outcomes);
        else
            for (std::size_t i = 0; i < pixels.size(); ++i) find_outcomes(pixels[i], outcomes[i]);
        for (std::size_t i = 0; i < pixels.size(); ++i) j[i] = nearest_of(pixels[i], outcomes[i]);
    }

  private:
    std::size_t index(glm::ivec2 pixel) const {
        return std::size_t(pixel.y) * std::size_t(data_.size.x) + std::size_t(pixel.x);
    }
    std::size_t pixels() const { return std::size_t(data_.size.x) * std::size_t(data_.size.y); }
    glm::ivec2 place(std::size_t i) const {
        return {int(i % std::size_t(data_.size.x)), int(i / std::size_t(data_.size.x))};
    }

    void find_outcomes(glm::ivec2 pixel, std::vector<Outcome>& outcomes) const {
        const std::size_t at = index(pixel);
        std::vector<float> got(std::size_t(components_), std::numeric_limits<float>::quiet_NaN());
        for (const Pair& p : pairs_)
            for (int c = 0; c < p.channels; ++c)
                if (p.compared(c)) got[std::size_t(p.first + c)] = float(p.got(at, c));
        const int n = options_.choices_a_pixel;
        std::span<const std::int32_t> choices;
        if (n > 0) choices = {options_.choices.data() + at * std::size_t(n), std::size_t(n)};
        stage_->outcomes(pixel, options_.profile, got, choices, outcomes);
    }

    // Looks for a legal outcome that is near enough.
    Judged nearest_of(glm::ivec2 pixel, const std::vector<Outcome>& outcomes) const {
        const std::size_t at = index(pixel);
        Judged j;
        j.worst.pixel = pixel;
        j.verdict = Verdict::wrong;
        j.worst.excess = std::numeric_limits<double>::infinity();
        for (const Outcome& outcome : outcomes) {
            bool decided = !outcome.ambiguous;
            const WorstPixel w = farthest(at, outcome, decided);
            const Verdict verdict =
                !(w.excess <= 1) ? Verdict::wrong : decided ? Verdict::within_bound : Verdict::ambiguous;
            const bool first = &outcome == &outcomes.front();
            if (first || verdict < j.verdict || (verdict == j.verdict && w.excess < j.worst.excess)) {
                j.verdict = verdict, j.worst = w;
                j.worst.pixel = pixel;
            }
        }
        if (outcomes.empty()) not_legal(at, j.worst);
        j.worst.verdict = j.verdict;
        return j;
    }

    // The output of which nothing was written at the pixel; a filling that is what was expected counts as written.
    const Pair* unwritten(std::size_t at) const {
        for (const Pair& p : pairs_)
            if (p.unwritten(at) == 2 || (p.unwritten(at) == 1 && !same_bits(at))) return &p;
        return nullptr;
    }

    Judged never_written(const Pair& p, std::size_t at, glm::ivec2 pixel) const {
        int c = 0;
        while (!p.compared(c)) ++c;
        return {Verdict::wrong,
                {pixel, Verdict::wrong, p.slot->name, c, p.ours(at, c), std::numeric_limits<double>::quiet_NaN(), 0,
                 std::numeric_limits<double>::infinity()},
                true};
    }

    bool seen(glm::ivec2 pixel) const { return options_.covered.empty() || options_.covered[index(pixel)]; }

    // What the stage reads at the pixel itself: images of the frame's size. Of those that may be missing alone nothing follows.
    void find_images() {
        bool needed = false;
        for (const Slot& slot : binding_.inputs) {
            const Array* image = slot.frame && slot.kind == SlotKind::image ? find(data_.inputs, slot.name) : nullptr;
            const std::size_t bytes = pixels() * std::size_t(slot.channels) * sizeof(float);
            if (!image || slot.dtype != DType::f32 || image->bytes.size() != bytes) continue;
            images_.push_back({image, slot.channels});
            needed = needed || !slot.optional;
        }
        if (!needed) images_.clear();
    }
    bool reads_nothing(std::size_t at) const {
        return !images_.empty() && std::all_of(images_.begin(), images_.end(), [&](const auto& image) {
            const auto* texel = reinterpret_cast<const float*>(image.first->bytes.data()) + at * std::size_t(image.second);
            return std::all_of(texel, texel + image.second, [](float v) { return v == 0; });
        });
    }

    // A w that is 1 wherever something may be written is a flag.
    void find_flags() {
        for (Pair& p : pairs_) {
            bool others = false;
            for (int c = 0; c < 3; ++c) others |= p.compared(c);
            p.w_is_flag = others && p.channels == 4 && p.slot->dtype == DType::f32;
            for (std::size_t i = 0; i < pixels() && p.w_is_flag; ++i)
                if (judged(place(i)) && p.ours(i, 3) != 1) p.w_is_flag = false;
        }
    }

    Pair pair(const Dumped& d) {
        std::vector<std::string> names;
        int first = 0;
        for (const Slot& slot : binding_.outputs) {
            if (slot.name != d.output) {
                names.push_back(slot.name), first += slot.channels;
                continue;
            }
            Shape shape = d.array.shape;
            // A list is one of items, in the order of the domain.
            const bool list = slot.kind == SlotKind::storage_buffer && !shape.empty() && shape[0] == std::int64_t(pixels());
            if (list) shape.erase(shape.begin()), shape.insert(shape.begin(), {data_.size.y, data_.size.x});
            const bool fits = (shape.size() == 2 || shape.size() == 3) && shape[0] == data_.size.y &&
                              shape[1] == data_.size.x && (d.array.dtype == DType::f32 || d.array.dtype == DType::i32);
            if (!fits)
                throw InputError(fmt::format("{}: output \"{}\" is {} {}: expected {} x {} pixels of f32 or i32",
                                             data_.label, d.output, dtype_name(d.array.dtype), shape_text(shape),
                                             data_.size.x, data_.size.y));
            Pair p{&slot, &d, plumb::at(expected_, slot.name).bytes.data(), slot.channels,
                   shape.size() == 3 ? int(shape[2]) : 1, first};
            if (slot.dtype == DType::i32) p.nothing = -1;  // as make_outputs() has it
            if (slot.kind == SlotKind::depth) p.nothing = data_.reversed_z ? 0 : 1;
            if (!d.unwritten.empty() && d.unwritten.size() != pixels())
                throw InputError(fmt::format("{}: output \"{}\": what was written of it has another size", data_.label,
                                             d.output));
            if (!d.rounding.bytes.empty() && (d.rounding.dtype != DType::f32 || d.rounding.shape != d.array.shape))
                throw InputError(fmt::format("{}: output \"{}\": its rounding is {}, expected {}", data_.label, d.output,
                                             shape_text(d.rounding.shape), shape_text(shape)));
            bool any = false;
            for (int c = 0; c < p.channels; ++c) any |= p.compared(c);
            if (!any)
                throw InputError(fmt::format("{}: output \"{}\": none of its components was dumped", data_.label, d.output));
            return p;
        }
        throw InputError(fmt::format("{}: {} has no output \"{}\"{}", data_.label, binding_.info.name, d.output,
                                     nearest_known(d.output, names, "\"\"")));
    }

    // Ours is rounded as the device's target rounds it.
    void quantise_expected() {
        for (Pair& p : pairs_) {
            if (p.slot->dtype != DType::f32 || is_exact(p.dumped->stored) || !p.dumped->rounding.bytes.empty()) continue;
            Array& array = const_cast<Array&>(plumb::at(expected_, p.slot->name));
            float* values = reinterpret_cast<float*>(array.bytes.data());
            parallel_bands(data_.size.y, 16, options_.run, [&](int first, int last) {
                for (std::size_t i = std::size_t(first) * data_.size.x; i < std::size_t(last) * data_.size.x; ++i) {
                    float* texel = values + i * std::size_t(p.channels);
                    glm::vec4 v(0, 0, 0, 1);
                    for (int c = 0; c < p.channels; ++c) v[c] = texel[c];
                    quantise(p.dumped->stored, v, options_.profile.half_store);
                    for (int c = 0; c < p.channels; ++c) texel[c] = v[c];
                }
            });
        }
    }

    bool same_bits(std::size_t at) const {
        for (const Pair& p : pairs_)
            for (int c = 0; c < p.channels; ++c)
                if (p.compared(c) && !(p.got(at, c) == p.ours(at, c) &&
                                       std::signbit(p.got(at, c)) == std::signbit(p.ours(at, c))))
                    return false;
        return true;
    }

    // A component that is not a number on either side.
    bool not_a_number(std::size_t at, WorstPixel& worst) const {
        for (const Pair& p : pairs_)
            for (int c = 0; c < p.channels; ++c) {
                const double ours = p.ours(at, c), got = p.got(at, c);
                if (!p.compared(c) || (ours == ours && got == got)) continue;
                worst = {worst.pixel, Verdict::wrong, p.slot->name, c, ours, got, 0,
                         std::numeric_limits<double>::infinity()};
                return true;
            }
        return false;
    }

    // No outcome can be told: the component that differs most.
    void not_legal(std::size_t at, WorstPixel& worst) const {
        double most = -1;
        for (const Pair& p : pairs_)
            for (int c = 0; c < p.channels; ++c) {
                if (!p.compared(c) || !(std::abs(p.got(at, c) - p.ours(at, c)) > most)) continue;
                most = std::abs(p.got(at, c) - p.ours(at, c));
                worst.output = p.slot->name, worst.channel = c;
                worst.expected = p.ours(at, c), worst.got = p.got(at, c);
            }
    }

    // How far a value is from the middle of a range, in halves of it: at most 1 inside.
    static double excess_of(double got, const StoredRange& range) {
        if (got == range.low && got == range.high) return 0;
        const double middle = 0.5 * (range.low + range.high), allowed = 0.5 * (range.high - range.low);
        if (!std::isfinite(middle)) return got >= range.low && got <= range.high ? 0 : HUGE_VAL;
        if (got >= range.low && got <= range.high) return std::min(std::abs(got - middle) / allowed, 1.0);
        return allowed > 0 ? std::max(std::abs(got - middle) / allowed, std::nextafter(1.0, 2.0)) : HUGE_VAL;
    }

    // Where a dump says by how much its values were rounded: our own value, which is legal, rounded as the dump may have
    // been. Spares the bound; excess above 1 says nothing.
    WorstPixel rounded_alike(std::size_t at) const {
        WorstPixel worst;
        worst.excess = -1;
        for (const Pair& p : pairs_)
            for (int c = 0; c < p.channels; ++c) {
                if (!p.compared(c)) continue;
                const double ours = p.ours(at, c), got = p.got(at, c);
                StoredRange range{ours, ours};
                if (!p.dumped->rounding.bytes.empty()) range = p.stored(at, c, ours, ours, 0, options_.profile);
                const double excess = excess_of(got, range);
                if (excess > worst.excess)
                    worst = {{}, Verdict::equal, p.slot->name, c, ours, got, 0.5 * (range.high - range.low), excess};
            }
        return worst;
    }

    // The component that is farthest outside of its bound. `decided` becomes false where a bound says nothing.
    WorstPixel farthest(std::size_t at, const Outcome& outcome, bool& decided) const {
        WorstPixel worst;
        worst.excess = -1;
        bool open = false;  // the worst so far is one of which nothing is known
        for (const Pair& p : pairs_) {
            // Some formats round all components of a texel together.
            double largest = 0;
            for (int c = 0; c < p.channels; ++c)
                largest = std::max(largest, std::abs(outcome.values[std::size_t(p.first + c)].shadow));
            for (int c = 0; c < p.channels; ++c) {
                if (!p.compared(c)) continue;
                const BoundedValue& v = outcome.values[std::size_t(p.first + c)];
                const double got = p.got(at, c);
                if (!std::isfinite(v.bound)) {
                    decided = false;
                    if (worst.excess <= 1 && !open)
                        open = true, worst = {{}, Verdict::equal, p.slot->name, c, v.shadow, got, v.bound, std::max(worst.excess, 0.0)};
                    continue;
                }
                const StoredRange range = p.stored(at, c, v.shadow - v.bound, v.shadow + v.bound, largest,
                                                   options_.profile);
                const double excess = excess_of(got, range);
                if (!(excess <= (open ? std::max(worst.excess, 1.0) : worst.excess)))
                    worst = {{}, Verdict::equal, p.slot->name, c, v.shadow, got, 0.5 * (range.high - range.low), excess};
            }
        }
        return worst;
    }

    const StageBinding& binding_;
    const StageData& data_;
    const JudgeOptions& options_;
    std::unique_ptr<BoundStage> stage_;
    const PacketOutcomes* packets_;  // null: it computes one at a time
    Bundle expected_;
    std::vector<Pair> pairs_;
    std::vector<std::pair<const Array*, int>> images_;  // with the components of a texel
    int components_ = 0;
};

// Wrong before ambiguous before within bound; then by how far.
bool worse(const WorstPixel& a, const WorstPixel& b) {
    if (a.verdict != b.verdict) return a.verdict > b.verdict;
    if (a.excess != b.excess) return a.excess > b.excess;
    return a.pixel.y != b.pixel.y ? a.pixel.y < b.pixel.y : a.pixel.x < b.pixel.x;
}

void keep_worst(std::vector<WorstPixel>& worst, int most) {
    if (int(worst.size()) <= most) return;
    std::partial_sort(worst.begin(), worst.begin() + most, worst.end(), worse);
    worst.resize(std::size_t(most));
}

double share_of(std::int64_t count, std::int64_t pixels) { return pixels > 0 ? double(count) / double(pixels) : 0; }

// "; all that was written is 0".
std::string one_value_text(const std::string& value) {
    return value.empty() ? "" : "; all that was written is " + value;
}

std::string unwritten_text(const Judge& judge, const StageVerdict& v) {
    if (v.unwritten == v.pixels) return "nothing was written" + absent_outputs(judge.pairs());
    const std::int64_t others = v.count[int(Verdict::wrong)] - v.unwritten;
    return fmt::format("{} of {} pixels were never written, in row{} {}{}{}", v.unwritten, v.pixels,
                       v.unwritten_rows[0] == v.unwritten_rows[1] ? "" : "s", v.unwritten_rows[0],
                       v.unwritten_rows[0] == v.unwritten_rows[1] ? "" : fmt::format(" to {}", v.unwritten_rows[1]),
                       others > 0 ? fmt::format("; {} more {} wrong", others, others == 1 ? "is" : "are") : "");
}

std::string ambiguous_text(double all, double nonzero, double most) {
    return fmt::format("{:.3g} % of the pixels{} are ambiguous, more than {:.3g} %: the comparison decides too little",
                       100 * (all > most ? all : nonzero), all > most ? "" : " that are not 0", 100 * most);
}

void conclude(const Judge& judge, const JudgeOptions& options, StageVerdict& v) {
    for (int i = 0; i < verdicts; ++i)
        if (v.count[std::size_t(i)] > 0) v.verdict = Verdict(i);
    const std::int64_t wrong = v.count[int(Verdict::wrong)], ambiguous = v.count[int(Verdict::ambiguous)];
    const double all = share_of(ambiguous, v.pixels);
    const double nonzero = share_of(v.nonzero_count[int(Verdict::ambiguous)], v.nonzero);
    v.passed = wrong == 0 && !(all > options.max_ambiguous) && !(nonzero > options.max_ambiguous);
    v.decided = !v.passed || v.nonzero > 0;
    if (v.pixels == 0 && v.left_out > 0)
        v.reason = fmt::format("nothing is seen at any of its {} pixels, and all are left out: nothing to judge. Is the "
                               "coverage the wrong way around?", v.left_out);
    else if (v.pixels == 0)
        v.reason = "this dispatch writes no pixel: nothing to judge";
    else if (v.unwritten > 0)
        v.reason = unwritten_text(judge, v);
    else if (wrong > 0)
        v.reason = fmt::format("{} of {} pixels are wrong{}", wrong, v.pixels, one_value_text(judge.one_value()));
    else if (!v.passed)
        v.reason = ambiguous_text(all, nonzero, options.max_ambiguous);
    else if (v.nonzero == 0)
        v.reason = fmt::format("all that is {} is 0, at each of its {} pixels: nothing to judge. Is something in its "
                               "inputs or uniforms wrong, a matrix or a light?",
                               judge.reads_nothing() ? "read" : "expected", v.pixels);
}

}  // namespace

struct ComparedPairs::Owner {
    Judge judge;
};

ComparedPairs::ComparedPairs(const StageBinding& binding, const StageData& data, const std::vector<Dumped>& dumped,
                             const JudgeOptions& options)
    : owner_(new Owner{Judge(binding, data, dumped, options)}) {}
ComparedPairs::~ComparedPairs() = default;
const std::vector<Pair>& ComparedPairs::all() const { return owner_->judge.pairs(); }

const char* verdict_name(Verdict verdict) {
    constexpr const char* names[] = {"equal", "within_bound", "ambiguous", "wrong"};
    return names[int(verdict)];
}

StageVerdict judge(const StageBinding& binding, const StageData& data, const std::vector<Dumped>& dumped,
                   const JudgeOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    const Judge judge(binding, data, dumped, options);
    StageVerdict v;
    v.stage = data.stage, v.label = data.label, v.id = data.id;
    v.map = Image<std::uint8_t>(data.size.x, data.size.y, 255);

    // Each row counts for itself, so that the order of the worst depends on no thread.
    struct Row {
        std::array<std::int64_t, verdicts> count{}, nonzero{};
        std::int64_t unwritten = 0, left_out = 0;
        std::vector<WorstPixel> worst;
    };
    std::vector<Row> rows(std::size_t(data.size.y));
    std::atomic<bool> enough = false;
    const auto enter = [&](glm::ivec2 pixel, const Judged& j) {
        Row& row = rows[std::size_t(pixel.y)];
        v.map(pixel.x, pixel.y) = std::uint8_t(j.verdict);
        ++row.count[std::size_t(j.verdict)];
        if (!judge.expects_nothing(pixel)) ++row.nonzero[std::size_t(j.verdict)];
        row.unwritten += j.unwritten;
        if (j.verdict == Verdict::equal) return;
        if (options.until_wrong && j.verdict == Verdict::wrong) enough = true;
        row.worst.push_back(j.worst);
        if (int(row.worst.size()) >= 8 * options.worst + 64) keep_worst(row.worst, options.worst);
    };
    parallel_bands(data.size.y, 1, options.run, [&](int first, int last) {
        std::array<glm::ivec2, PacketOutcomes::most> waiting;
        std::array<Judged, PacketOutcomes::most> judged;
        std::size_t count = 0;
        const auto judge_waiting = [&] {
            judge({waiting.data(), count}, judged.data());
            for (std::size_t i = 0; i < count; ++i) enter(waiting[i], judged[i]);
            count = 0;
        };
        for (int y = first; y < last; ++y)
            for (int x = 0; x < data.size.x; ++x) {
                rows[std::size_t(y)].left_out += judge.left_out({x, y});
                if (enough || !judge.judged({x, y})) continue;
                if (Judged j; judge.at_sight({x, y}, j)) {
                    enter({x, y}, j);
                } else {
                    waiting[count++] = {x, y};
                    if (count == waiting.size()) judge_waiting();
                }
            }
        if (!enough) judge_waiting();
    });
    for (std::size_t y = 0; y < rows.size(); ++y) {
        const Row& row = rows[y];
        for (std::size_t i = 0; i < verdicts; ++i) {
            v.count[i] += row.count[i], v.pixels += row.count[i];
            v.nonzero_count[i] += row.nonzero[i], v.nonzero += row.nonzero[i];
        }
        v.left_out += row.left_out;
        if (row.unwritten > 0) {
            if (v.unwritten == 0) v.unwritten_rows[0] = int(y);
            v.unwritten += row.unwritten, v.unwritten_rows[1] = int(y);
        }
        v.worst.insert(v.worst.end(), row.worst.begin(), row.worst.end());
    }
    std::sort(v.worst.begin(), v.worst.end(), worse);
    keep_worst(v.worst, options.worst);
    conclude(judge, options, v);
    v.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return v;
}

}  // namespace plumb::parity
