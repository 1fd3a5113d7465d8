#include "gi/parity/diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <map>
#include <utility>

#include "core/hash.h"
#include "core/host_math.h"
#include "gi/parity/pair.h"
#include "gi/parity/trial.h"

namespace plumb::parity {

namespace {

// Wrong pixels of a glance, one of which a guess has to explain; pixels of a first look, of a second one at the guesses
// that came through it, and of the last one.
constexpr std::size_t glance_wrong = 16, first_wrong = 64, first_right = 32, second_wrong = 384, second_right = 128,
                      last_pixels = 65536;
// Guesses that come through the first look; and wrong pixels below which one alike is found for anything: a ratio, an
// output to leave aside, the cause of a place.
constexpr std::size_t second_guesses = 12, last_guesses = 8, cluster_pixels = 16, clusters_told = 4;
constexpr double last_look_ms = 2000;  // of a processor, a guess
constexpr double explains = 0.99;      // of what is wrong: all of it

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
          verdict_(verdict),
          compared_(binding, data, dumped, options),
          pairs_(compared_.all()),
          trial_(binding, data, options, verdict, pairs_) {
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
    bool written(std::size_t i) const {
        return std::all_of(pairs_.begin(), pairs_.end(), [i](const Pair& p) { return p.unwritten(i) == 0; });
    }

    // ---- All guesses, then some, then few

    // got / expected of components, where it is one number of all wrong pixels, or of a place.
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
    // The same of x, y and z, each of its own.
    std::vector<SeenRatio> vector_ratios() const {
        std::vector<SeenRatio> all;
        for (const Ratios& r : found_.wrong.ratios) {
            if (!r.constant() || r.counted < std::int64_t(cluster_pixels) || r.channel > 2) continue;
            if (all.empty() || all.back().output != r.output) all.push_back({r.output, {}});
            if (std::size_t(r.channel) == all.back().ratio.size()) all.back().ratio.push_back(r.quartiles[1]);
        }
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
        std::vector<Hypothesis> near = result_hypotheses(binding_, data_, constant_ratios()), far;
        for (std::vector<Hypothesis> list : {vector_hypotheses(binding_, data_, vector_ratios()),
                                             input_hypotheses(binding_, data_), uniform_hypotheses(binding_, data_)})
            for (Hypothesis& h : list) near.push_back(std::move(h));
        for (const Hypothesis& h : more) (h.outputs ? far : near).push_back(h);
        std::stable_partition(near.begin(), near.end(), [](const Hypothesis& h) { return !h.aside && !h.fitted; });
        if (wrong_.size() < cluster_pixels) std::erase_if(near, [](const Hypothesis& h) { return h.aside; });

        const std::vector<glm::ivec2> right = some_of(right_, first_right);
        std::vector<glm::ivec2> pixels = wrong_sample(first_wrong);
        const std::size_t wrong = pixels.size();
        pixels.insert(pixels.end(), right.begin(), right.end());
        const Look glance = trial_.look(wrong_sample(glance_wrong)), seen = trial_.look(std::move(pixels));
        trial_.find_local(seen);
        std::vector<Guess> kept;
        try_all(near, glance, seen, wrong, kept);
        if (!explained(kept, wrong, right.size())) {
            std::vector<Hypothesis> slow = std::exchange(far, far_hypotheses(binding_, data_));
            for (Hypothesis& h : fitted(glance, seen)) far.push_back(std::move(h));
            try_all(far, glance, seen, wrong, kept);
            try_all(slow, glance, seen, wrong, kept);
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

    // Whether a mistake by name explains what is wrong, and breaks nothing.
    static bool explained(const std::vector<Guess>& guesses, std::size_t wrong, std::size_t right) {
        return std::any_of(guesses.begin(), guesses.end(), [&](const Guess& g) {
            return !g.hypothesis.aside && !g.hypothesis.fitted && double(g.wrong) >= explains * double(wrong) &&
                   g.right + 1 >= right;
        });
    }

    // The first `wrong` pixels that were seen are wrong, the others right.
    void try_all(std::vector<Hypothesis>& all, const Look& glance, const Look& seen, std::size_t wrong,
                 std::vector<Guess>& kept) {
        for (Hypothesis& h : all) {
            // What runs elsewhere takes its time a run, not a pixel, and none is left that explains it.
            if (h.outputs && explained(kept, wrong, seen.pixels.size() - wrong)) continue;
            if (!h.outputs) {
                const std::vector<std::uint8_t> any = trial_.agreement(h, glance);
                if (any.empty()) continue;
                ++found_.tried;
                if (std::count(any.begin(), any.end(), 1) == 0) continue;
            }
            const std::vector<std::uint8_t> agree = trial_.agreement(h, seen);
            if (agree.empty()) continue;
            if (h.outputs) ++found_.tried;
            Guess g{std::move(h)};
            for (std::size_t i = 0; i < agree.size(); ++i) (i < wrong ? g.wrong : g.right) += agree[i];
            if (8 * g.wrong >= wrong) kept.push_back(std::move(g));
        }
    }

    // ---- Numbers that are looked for

    std::vector<Hypothesis> fitted(const Look& glance, const Look& seen) {
        const double as_it_is = trial_.distance({"as it is"}, glance);
        std::vector<Hypothesis> all;
        for (const Family& family : families(binding_, data_)) {
            double best = 1, least = as_it_is;
            for (int k = -24; k <= 24; ++k) {
                const double by = host::exp2(k / 6.0), off = trial_.distance(family.at(by), glance);
                if (off < least) least = off, best = by;
            }
            if (least < 0.7 * as_it_is) all.push_back(family.at(refined(family, best, seen)));
        }
        return all;
    }
    // Between steps of a sixth of an octave, then of a fourth of these, and so on; in the middle of what is equally near.
    double refined(const Family& family, double best, const Look& look) {
        double step = 1 / 6.0;
        for (int round = 0; round < 7; ++round, step /= 4) {
            double least = HUGE_VAL, first = 0, last = 0;
            for (int j = -4; j <= 4; ++j) {
                const double at = 0.25 * step * j, off = trial_.distance(family.at(best * host::exp2(at)), look);
                if (off < least) least = off, first = at;
                if (off == least) last = at;
            }
            best *= host::exp2(0.5 * (first + last));
        }
        return best;
    }

    void second_look(std::vector<Guess>& guesses) {
        std::vector<glm::ivec2> pixels = wrong_sample(second_wrong);
        const std::size_t clusters_first = some_of(wrong_, second_wrong).size();
        const std::size_t wrong = pixels.size();
        const std::vector<glm::ivec2> right = some_of(right_, second_right);
        pixels.insert(pixels.end(), right.begin(), right.end());
        const double start = processor_ms();
        const Look seen = trial_.look(pixels);
        ms_a_pixel_ = (processor_ms() - start) / double(pixels.size());
        std::vector<std::vector<std::uint8_t>> agree;
        for (Guess& g : guesses) {
            agree.push_back(trial_.agreement(g.hypothesis, seen));
            g.wrong = g.right = 0;
            for (std::size_t i = 0; i < agree.back().size(); ++i) {
                if (i < clusters_first) g.wrong += agree.back()[i];
                if (i >= wrong) g.right += agree.back()[i];
            }
        }
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

        // Where few of all pixels are asked, the float kernel would run for nothing.
        const bool many = 8 * pixels.size() >= verdict_.map.size();
        std::map<double, std::int64_t> without;
        std::vector<Cause> causes;
        for (const Guess& g : guesses) {
            const Hypothesis& h = g.hypothesis;
            if (!without.count(h.slack)) without[h.slack] = agree_without(pixels, h.slack);
            const std::vector<std::uint8_t> agree =
                many ? trial_.agreement_of_many(h, pixels) : trial_.agreement(h, {pixels});
            Cause c{h.text,  std::int64_t(pixels.size()), std::count(agree.begin(), agree.end(), 1), without[h.slack], {},
                    h.aside, h.fitted};
            const std::int64_t left = c.pixels - c.without;
            if (left > 0 && 2 * (c.agree - c.without) >= left) causes.push_back(std::move(c));
        }
        std::stable_sort(causes.begin(), causes.end(), [](const Cause& a, const Cause& b) {
            if (rank(a) != rank(b)) return rank(a) < rank(b);
            return a.aside != b.aside && a.agree == b.agree ? b.aside : a.agree > b.agree;
        });
        for (std::size_t i = 3; i < causes.size(); ++i)
            if (causes[i].agree == causes[2].agree) causes[2].alike.push_back(causes[i].text);
        if (causes.size() > 3) causes.resize(3);
        found_.causes = std::move(causes);
    }

    // Mistakes that explain all that is wrong come first, numbers that were fitted and what leaves something aside then,
    // and then what explains a part.
    static int rank(const Cause& c) {
        const bool all = double(c.agree - c.without) >= explains * double(c.pixels - c.without);
        return !all ? 3 : c.fitted ? 1 : c.aside ? 2 : 0;
    }

    // Of the kernel as it is.
    std::int64_t agree_without(const std::vector<glm::ivec2>& pixels, double slack) {
        std::vector<glm::ivec2> wrong;
        for (const glm::ivec2 p : pixels)
            if (verdict_.map.texels[index(p)] == std::uint8_t(Verdict::wrong)) wrong.push_back(p);
        std::int64_t agree = std::int64_t(pixels.size() - wrong.size());
        Hypothesis as_it_is{"as it is"};
        as_it_is.slack = slack;
        if (slack > 0)
            for (const std::uint8_t a : trial_.agreement(as_it_is, {wrong})) agree += a;
        return agree;
    }

    const StageBinding& binding_;
    const StageData& data_;
    const StageVerdict& verdict_;
    const ComparedPairs compared_;
    const std::vector<Pair>& pairs_;
    Trial trial_;
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
