#include "gi/parity/diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <map>

#include "core/error.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "gi/parity/pair.h"

namespace plumb::parity {

namespace {

// Wrong pixels of a glance, one of which a guess has to explain; pixels of a first look, of a second one at the guesses
// that came through it, and of the last one.
constexpr std::size_t glance_wrong = 16, first_wrong = 64, first_right = 32, second_wrong = 384, second_right = 128,
                      last_pixels = 65536;
// Guesses that come through the first look; and wrong pixels below which one alike is found for anything: a ratio, an
// output to leave aside, the cause of a place.
constexpr std::size_t second_guesses = 12, last_guesses = 6, cluster_pixels = 16, clusters_told = 4;
constexpr double last_look_ms = 2000;  // of a processor, a guess

// Of all threads: what else the machine does is not in it.
double processor_ms() { return 1e3 * double(std::clock()) / CLOCKS_PER_SEC; }

// `count` of them: one of each of as many equal parts, by a hash, so that no column of a picture is preferred.
std::vector<glm::ivec2> some_of(const std::vector<glm::ivec2>& all, std::size_t count) {
    if (all.size() <= count) return all;
    std::vector<glm::ivec2> some;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t first = i * all.size() / count, last = (i + 1) * all.size() / count;
        const auto hash = pixel_hash<std::int32_t>(std::int32_t(i), std::int32_t(count), 0, 0);
        some.push_back(all[first + std::uint32_t(hash.x) % (last - first)]);
    }
    return some;
}

// The data with arrays that lie where they lay: what changes one copies that one.
StageData lent_data(const StageData& data) {
    StageData lent = data;
    for (std::size_t i = 0; i < data.inputs.arrays.size(); ++i) {
        const Bytes& bytes = data.inputs.arrays[i].bytes;
        lent.inputs.arrays[i].bytes = Bytes::lent(bytes.data(), bytes.size());
    }
    return lent;
}

// Pixels that guesses are tried on, with what the kernel as it is may make of them, which all guesses about results
// share.
struct Look {
    std::vector<glm::ivec2> pixels;
    std::vector<std::vector<Outcome>> outcomes = {};
};

struct Guess {
    Hypothesis hypothesis;
    std::size_t wrong = 0, right = 0;  // that agree, of the look
};

class Diagnoser {
  public:
    Diagnoser(const StageBinding& binding, const StageData& data, const std::vector<Dumped>& dumped,
              const JudgeOptions& options, const StageVerdict& verdict)
        : binding_(binding),
          data_(data),
          options_(options),
          verdict_(verdict),
          stage_(binding.bind(data)),
          compared_(binding, data, dumped, options),
          pairs_(compared_.all()) {
        for (const Slot& slot : binding.outputs) components_ += slot.channels;
        std::vector<std::uint8_t> wrong(verdict.map.size());
        for (std::size_t i = 0; i < wrong.size(); ++i) {
            const std::uint8_t v = verdict.map.texels[i];
            if (v >= verdicts || !written(i)) continue;
            wrong[i] = v == std::uint8_t(Verdict::wrong);
            (wrong[i] ? wrong_ : right_).push_back(place(i));
        }
        found_.wrong = wrong_pixels(pairs_, data.size, wrong, options.worst);
    }

    Diagnosis run(const std::vector<Hypothesis>& more) {
        const auto start = std::chrono::steady_clock::now();
        if (!wrong_.empty()) {
            std::vector<Guess> guesses = first_look(more);
            second_look(guesses);
            last_look(guesses);
        }
        found_.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        return std::move(found_);
    }

  private:
    std::size_t index(glm::ivec2 p) const { return std::size_t(p.y) * std::size_t(data_.size.x) + std::size_t(p.x); }
    glm::ivec2 place(std::size_t i) const {
        return {int(i % std::size_t(data_.size.x)), int(i / std::size_t(data_.size.x))};
    }
    bool inside(glm::ivec2 p) const { return p.x >= 0 && p.y >= 0 && p.x < data_.size.x && p.y < data_.size.y; }
    bool written(std::size_t i) const {
        return std::all_of(pairs_.begin(), pairs_.end(), [i](const Pair& p) { return p.unwritten(i) == 0; });
    }

    // ---- One pixel under one guess

    // Whether the dump may hold what was made.
    bool holds(std::size_t at, const std::vector<BoundedValue>& values, double slack) const {
        for (const Pair& p : pairs_) {
            double largest = 0;
            for (int c = 0; c < p.channels; ++c)
                largest = std::max(largest, std::abs(values[std::size_t(p.first + c)].shadow));
            for (int c = 0; c < p.channels; ++c) {
                if (!p.compared(c)) continue;
                const BoundedValue& v = values[std::size_t(p.first + c)];
                const double bound = v.bound + slack * largest;
                if (!std::isfinite(bound) || !std::isfinite(v.shadow)) return false;
                const StoredRange range =
                    p.stored(at, c, v.shadow - bound, v.shadow + bound, largest, options_.profile);
                const double got = p.got(at, c);
                if (!(got >= range.low && got <= range.high)) return false;
            }
        }
        return true;
    }

    // What outputs hold at a pixel, as the one outcome.
    std::vector<Outcome> own_outcome(const Bundle& outputs, std::size_t at) const {
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

    std::vector<Outcome> outcomes(const BoundStage& stage, glm::ivec2 ours, std::size_t at) const {
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

    bool agrees(const Hypothesis& h, const std::vector<Outcome>& outcomes, glm::ivec2 pixel, double slack) const {
        std::vector<BoundedValue> values;
        for (const Outcome& outcome : outcomes) {
            if (outcome.ambiguous) continue;
            values = outcome.values;
            if (h.result) h.result(pixel, values);
            if (holds(index(pixel), values, slack)) return true;
        }
        return false;
    }
    // `outputs`: what the stage's float kernel made, or null.
    bool agrees(const BoundStage& stage, const Hypothesis& h, const Bundle* outputs, glm::ivec2 pixel,
                double slack) const {
        const glm::ivec2 ours = h.place ? h.place(pixel) : pixel;
        if (!inside(ours) || !stage.writes(ours)) return false;
        const std::size_t at = index(pixel);
        if (outputs && agrees(h, own_outcome(*outputs, index(ours)), pixel, slack)) return true;
        return agrees(h, outcomes(stage, ours, at), pixel, slack);
    }

    template <class Each>
    void each_of(std::size_t count, const Each& each) const {
        RunOptions quiet = options_.run;
        quiet.progress = {};
        parallel_bands(int(count), 8, quiet, [&](int first, int last) {
            for (int i = first; i < last; ++i) each(std::size_t(i));
        });
    }

    Look look(std::vector<glm::ivec2> pixels) const {
        Look l{std::move(pixels)};
        l.outcomes.resize(l.pixels.size());
        each_of(l.pixels.size(),
                [&](std::size_t i) { l.outcomes[i] = outcomes(*stage_, l.pixels[i], index(l.pixels[i])); });
        return l;
    }

    std::vector<std::uint8_t> agreement(const Hypothesis& h, const Look& look, double slack) const {
        if (h.change || h.place || h.outputs) return agreement(h, look.pixels, false, slack);
        std::vector<std::uint8_t> agree(look.pixels.size());
        each_of(agree.size(), [&](std::size_t i) { agree[i] = agrees(h, look.outcomes[i], look.pixels[i], slack); });
        return agree;
    }
    // A byte a pixel; empty where the kernel cannot serve such data. `whole`: with the float kernel's own result, which
    // spares most bounds where many pixels are asked.
    std::vector<std::uint8_t> agreement(const Hypothesis& h, const std::vector<glm::ivec2>& pixels, bool whole,
                                        double slack) const {
        if (h.outputs) return agreement_of_outputs(h, pixels, slack);
        StageData data = lent_data(data_);
        std::unique_ptr<BoundStage> own;
        try {
            if (h.change) {
                if (!h.change(data)) return {};
                own = binding_.bind(data);
            }
        } catch (const InputError&) {
            return {};
        }
        const BoundStage& stage = own ? *own : *stage_;
        Bundle outputs;
        if (whole) stage.run(options_.run, options_.profile, outputs);
        std::vector<std::uint8_t> agree(pixels.size());
        each_of(agree.size(),
                [&](std::size_t i) { agree[i] = agrees(stage, h, whole ? &outputs : nullptr, pixels[i], slack); });
        return agree;
    }

    std::vector<std::uint8_t> agreement_of_outputs(const Hypothesis& h, const std::vector<glm::ivec2>& pixels,
                                                   double slack) const {
        Bundle outputs;
        if (!h.outputs(outputs)) return {};
        std::vector<std::uint8_t> agree(pixels.size());
        each_of(agree.size(),
                [&](std::size_t i) { agree[i] = agrees(h, own_outcome(outputs, index(pixels[i])), pixels[i], slack); });
        return agree;
    }

    // ---- All guesses, then some, then few

    std::vector<double> constant_ratios() const {
        std::vector<double> all;
        auto note = [&](const std::vector<Ratios>& ratios) {
            for (const Ratios& r : ratios) {
                const double m = r.quartiles[1];
                if (!r.constant() || r.counted < std::int64_t(cluster_pixels)) continue;
                if (std::none_of(all.begin(), all.end(),
                                 [m](double x) { return std::abs(x - m) <= 1e-3 * std::abs(m); }))
                    all.push_back(m);
            }
        };
        note(found_.wrong.ratios);
        for (std::size_t i = 0; i < std::min(clusters_told, found_.wrong.clusters.size()); ++i)
            note(ratios_of(pairs_, data_.size.x, found_.wrong.clusters[i].members));
        return all;
    }

    // Wrong pixels, with some of each large cluster among them.
    std::vector<glm::ivec2> wrong_sample(std::size_t count) const {
        std::vector<glm::ivec2> sample = some_of(wrong_, count);
        const std::vector<Cluster>& clusters = found_.wrong.clusters;
        for (std::size_t i = 0; i < std::min(clusters_told, clusters.size()) && clusters.size() > 1; ++i)
            for (const glm::ivec2 p : some_of(clusters[i].members, count / 8)) sample.push_back(p);
        return sample;
    }

    // Keeps those that explain something: of all wrong pixels, less what they break, or of one cluster.
    std::vector<Guess> first_look(const std::vector<Hypothesis>& more) {
        std::vector<Hypothesis> all = result_hypotheses(binding_, data_, constant_ratios());
        for (std::vector<Hypothesis> list :
             {input_hypotheses(binding_, data_), uniform_hypotheses(binding_, data_), more})
            for (Hypothesis& h : list) all.push_back(std::move(h));
        std::stable_partition(all.begin(), all.end(), [](const Hypothesis& h) { return !h.aside; });
        if (wrong_.size() < cluster_pixels) std::erase_if(all, [](const Hypothesis& h) { return h.aside; });

        const std::vector<glm::ivec2> right = some_of(right_, first_right);
        std::vector<glm::ivec2> pixels = wrong_sample(first_wrong);
        const std::size_t wrong = pixels.size();
        pixels.insert(pixels.end(), right.begin(), right.end());
        const Look glance = look(wrong_sample(glance_wrong)), seen = look(std::move(pixels));
        std::vector<Guess> kept;
        for (Hypothesis& h : all) {
            const std::vector<std::uint8_t> any = agreement(h, glance, h.slack);
            if (any.empty()) continue;
            ++found_.tried;
            if (std::count(any.begin(), any.end(), 1) == 0) continue;
            const std::vector<std::uint8_t> agree = agreement(h, seen, h.slack);
            Guess g{std::move(h)};
            for (std::size_t i = 0; i < agree.size(); ++i) (i < wrong ? g.wrong : g.right) += agree[i];
            if (8 * g.wrong >= wrong) kept.push_back(std::move(g));
        }
        // By what they explain of what is wrong, and as many again by that less what they break.
        const double broken_weight = double(wrong) / double(std::max<std::size_t>(right.size(), 1));
        std::stable_sort(kept.begin(), kept.end(), [&](const Guess& a, const Guess& b) {
            const double share = double(right_.size()) / double(wrong_.size());
            auto net = [&](const Guess& g) {
                return double(g.wrong) + std::min(share, 4.0) * broken_weight * double(g.right);
            };
            return net(a) > net(b);
        });
        if (kept.size() > second_guesses) {
            std::stable_sort(kept.begin() + second_guesses, kept.end(),
                             [](const Guess& a, const Guess& b) { return a.wrong > b.wrong; });
            kept.resize(std::min(kept.size(), 2 * second_guesses));
        }
        return kept;
    }

    void second_look(std::vector<Guess>& guesses) {
        std::vector<glm::ivec2> pixels = wrong_sample(second_wrong);
        const std::size_t clusters_first = some_of(wrong_, second_wrong).size();
        const std::size_t wrong = pixels.size();
        const std::vector<glm::ivec2> right = some_of(right_, second_right);
        pixels.insert(pixels.end(), right.begin(), right.end());
        std::vector<std::vector<std::uint8_t>> agree;
        const double start = processor_ms();
        for (Guess& g : guesses) {
            agree.push_back(agreement(g.hypothesis, pixels, false, g.hypothesis.slack));
            g.wrong = g.right = 0;
            for (std::size_t i = 0; i < agree.back().size(); ++i) {
                if (i < clusters_first) g.wrong += agree.back()[i];
                if (i >= wrong) g.right += agree.back()[i];
            }
        }
        ms_a_pixel_ = guesses.empty() ? 0 : (processor_ms() - start) / double(guesses.size() * pixels.size());
        clusters(guesses, agree, clusters_first, pixels);

        // The share of all pixels that would agree.
        const double of_wrong = double(wrong_.size()) / double(std::max<std::size_t>(clusters_first, 1));
        const double of_right = double(right_.size()) / double(std::max<std::size_t>(right.size(), 1));
        std::erase_if(guesses, [&](const Guess& g) {
            return !(of_wrong * double(g.wrong) + of_right * double(g.right) >=
                     double(right_.size()) + 0.45 * double(wrong_.size()));
        });
        std::stable_sort(guesses.begin(), guesses.end(), [&](const Guess& a, const Guess& b) {
            return of_wrong * double(a.wrong) + of_right * double(a.right) >
                   of_wrong * double(b.wrong) + of_right * double(b.right);
        });
        if (guesses.size() > last_guesses) guesses.resize(last_guesses);
    }

    // Of the largest clusters each the guess that explains the most of its pixels.
    void clusters(const std::vector<Guess>& guesses, const std::vector<std::vector<std::uint8_t>>& agree,
                  std::size_t at, const std::vector<glm::ivec2>& pixels) {
        const std::vector<Cluster>& all = found_.wrong.clusters;
        if (all.size() < 2) return;
        for (std::size_t i = 0; i < std::min(clusters_told, all.size()); ++i) {
            const std::size_t count = some_of(all[i].members, second_wrong / 8).size();
            ClusterCause c{
                all[i].pixels,       all[i].low, all[i].high, ratios_of(pairs_, data_.size.x, all[i].members), "",
                std::int64_t(count), 0};
            for (std::size_t g = 0; g < guesses.size() && all[i].members.size() >= cluster_pixels; ++g) {
                std::int64_t n = 0;
                for (std::size_t k = at; k < at + count && k < std::min(agree[g].size(), pixels.size()); ++k)
                    n += agree[g][k];
                if (2 * n >= std::int64_t(count) && n > c.agree) c.agree = n, c.text = guesses[g].hypothesis.text;
            }
            found_.clusters.push_back(std::move(c));
            at += count;
        }
    }

    void last_look(std::vector<Guess>& guesses) {
        std::vector<glm::ivec2> pixels;
        for (std::size_t i = 0; i < verdict_.map.size(); ++i)
            if (verdict_.map.texels[i] < verdicts && written(i)) pixels.push_back(place(i));
        std::size_t most = last_pixels;
        while (most > 1024 && double(most) * ms_a_pixel_ > last_look_ms) most /= 2;
        pixels = some_of(pixels, most);

        std::map<double, std::int64_t> without;
        std::vector<Cause> causes;
        for (const Guess& g : guesses) {
            const Hypothesis& h = g.hypothesis;
            if (!without.count(h.slack)) without[h.slack] = agree_without(pixels, h.slack);
            const std::vector<std::uint8_t> agree = agreement(h, pixels, true, h.slack);
            Cause c{
                h.text, std::int64_t(pixels.size()), std::count(agree.begin(), agree.end(), 1), without[h.slack], {},
                h.aside};
            const std::int64_t left = c.pixels - c.without;
            if (left > 0 && 2 * (c.agree - c.without) >= left) causes.push_back(std::move(c));
        }
        std::stable_sort(causes.begin(), causes.end(), [](const Cause& a, const Cause& b) {
            return a.aside != b.aside && a.agree == b.agree ? b.aside : a.agree > b.agree;
        });
        for (std::size_t i = 3; i < causes.size(); ++i)
            if (causes[i].agree == causes[2].agree) causes[2].alike.push_back(causes[i].text);
        if (causes.size() > 3) causes.resize(3);
        found_.causes = std::move(causes);
    }

    // Of the kernel as it is.
    std::int64_t agree_without(const std::vector<glm::ivec2>& pixels, double slack) const {
        std::vector<glm::ivec2> wrong;
        for (const glm::ivec2 p : pixels)
            if (verdict_.map.texels[index(p)] == std::uint8_t(Verdict::wrong)) wrong.push_back(p);
        std::int64_t agree = std::int64_t(pixels.size() - wrong.size());
        if (slack > 0)
            for (const std::uint8_t a : agreement({"as it is"}, wrong, false, slack)) agree += a;
        return agree;
    }

    const StageBinding& binding_;
    const StageData& data_;
    const JudgeOptions& options_;
    const StageVerdict& verdict_;
    std::unique_ptr<BoundStage> stage_;
    const ComparedPairs compared_;
    const std::vector<Pair>& pairs_;
    int components_ = 0;
    std::vector<glm::ivec2> wrong_, right_;
    double ms_a_pixel_ = 0;
    Diagnosis found_;
};

}  // namespace

Diagnosis diagnose(const StageBinding& binding, const StageData& data, const std::vector<Dumped>& dumped,
                   const JudgeOptions& options, const StageVerdict& verdict, const std::vector<Hypothesis>& more) {
    if (verdict.verdict != Verdict::wrong || verdict.unwritten == verdict.pixels) return {};
    return Diagnoser(binding, data, dumped, options, verdict).run(more);
}

}  // namespace plumb::parity
