#include "tools/mutants/generic_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <thread>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/parity/stages.h"
#include "tools/mutants/bench.h"
#include "tools/mutants/survivors.h"

namespace plumb::mutants {
namespace {

constexpr double least_found = 0.95;

struct Outcome {
    Fate fate = Fate::found;
    double ms = 0;
    const Survivor* entry = nullptr;  // of the list, for what survived
};

// Of a stage, or of all.
struct Tally {
    int sites = 0, found = 0;
    std::array<int, sorts> listed{};
    std::array<int, fates> unlisted{};
    double ms = 0;

    void add(const Outcome& o) {
        ++sites, ms += o.ms;
        if (o.fate == Fate::found) ++found;
        else if (o.entry) ++listed[std::size_t(o.entry->sort)];
        else ++unlisted[std::size_t(o.fate)];
    }
    // What neither is equivalent nor out of reach.
    int findable() const {
        return sites - listed[int(Sort::equivalent)] - listed[int(Sort::unreached)] - unlisted[int(Fate::unreached)];
    }
    double share() const { return findable() > 0 ? double(found) / findable() : 1; }
    int surprises() const { return sites - found - listed[0] - listed[1] - listed[2]; }
};

std::vector<const StageBinding*> wanted_stages(const GenericOptions& options) {
    std::vector<const StageBinding*> out;
    for (const std::string& name : options.stages) out.push_back(&parity::find_binding(name, "--stage"));
    if (out.empty())
        for (const StageBinding& b : parity::bindings()) out.push_back(&b);
    return out;
}

// Deals out mutants so that a thread stays with a stage, whose data it has on its device.
class Queue {
  public:
    Queue(const GenericMutants& all, const std::vector<GenericMutant>& chosen) {
        for (std::size_t i = chosen.size(); i-- > 0;) left_[all.stage(chosen[i])].push_back(i);
    }
    // False where nothing is left. `stage` is the thread's, "" at first.
    bool take(std::string& stage, std::size_t& mutant) {
        const std::lock_guard lock(mutex_);
        auto list = left_.find(stage);
        if (list == left_.end()) {
            list = std::max_element(left_.begin(), left_.end(), [&](const auto& a, const auto& b) {
                return std::pair(!held_.count(a.first), a.second.size()) < std::pair(!held_.count(b.first), b.second.size());
            });
            if (list == left_.end()) return false;
            stage = list->first, held_.insert(stage);
        }
        mutant = list->second.back();
        list->second.pop_back();
        if (list->second.empty()) left_.erase(list);
        return true;
    }
    void drop_all() {
        const std::lock_guard lock(mutex_);
        left_.clear();
    }

  private:
    std::mutex mutex_;
    std::map<std::string, std::vector<std::size_t>> left_;  // the next one last
    std::set<std::string> held_;
};

class Run {
  public:
    Run(const GenericOptions& options, const GenericMutants& all, std::vector<GenericMutant> chosen,
        const std::vector<Survivor>& survivors)
        : options_(options), all_(all), chosen_(std::move(chosen)), survivors_(survivors), outcomes_(chosen_.size()) {}

    // Each bench on a thread of its own.
    void judge_all(std::vector<Bench>& benches) {
        Queue queue(all_, chosen_);
        std::exception_ptr failure;
        std::mutex mutex;
        std::vector<std::jthread> threads;
        for (Bench& bench : benches)
            threads.emplace_back([&] {
                try {
                    std::string stage;
                    for (std::size_t i = 0; queue.take(stage, i);) judge(bench, i);
                } catch (...) {
                    const std::lock_guard lock(mutex);
                    queue.drop_all(), failure = std::current_exception();
                }
            });
        threads.clear();
        if (failure) std::rethrow_exception(failure);
    }

    // Whether all is as the list says.
    bool report(double seconds) const {
        std::map<std::string, Tally> of_stage;
        Tally sum;
        std::vector<bool> used(survivors_.size());
        for (std::size_t i = 0; i < chosen_.size(); ++i) {
            of_stage[all_.stage(chosen_[i])].add(outcomes_[i]), sum.add(outcomes_[i]);
            if (outcomes_[i].entry) used[std::size_t(outcomes_[i].entry - survivors_.data())] = true;
        }
        const bool whole = options_.sample == 0 && options_.stages.empty();
        int stale = 0;
        for (std::size_t i = 0; whole && i < used.size(); ++i) {
            if (used[i]) continue;
            ++stale;
            std::fprintf(stderr, "%s: fits no survivor\n", survivors_[i].place.c_str());
        }
        if (options_.json)
            print_json(of_stage, sum, seconds);
        else
            print(of_stage, sum, seconds);
        return sum.surprises() == 0 && stale == 0 && (!whole || sum.share() >= least_found);
    }

  private:
    void judge(Bench& bench, std::size_t i) {
        const auto start = std::chrono::steady_clock::now();
        Outcome& o = outcomes_[i];
        o.fate = bench(chosen_[i]);
        o.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        if (const std::size_t n = ++judged_; n % 200 == 0) std::fprintf(stderr, "%zu of %zu\n", n, chosen_.size());
        if (o.fate == Fate::found) return;
        for (const Survivor& s : survivors_)
            if (!o.entry && s.matches(all_.site(chosen_[i]))) o.entry = &s;
    }

    void print(const std::map<std::string, Tally>& of_stage, const Tally& sum, double seconds) const {
        for (std::size_t i = 0; i < chosen_.size(); ++i) {
            if (outcomes_[i].fate == Fate::found) continue;
            const Site& site = all_.site(chosen_[i]);
            const Place& p = site.place;
            fmt::print("{:11} {:10} {} {} {}.{} {}:{} {}: {}\n", outcomes_[i].entry ? sort_name(outcomes_[i].entry->sort) : "SURVIVED",
                       fate_name(outcomes_[i].fate), all_.stage(chosen_[i]), change_name(site.change), site.at, site.part, p.file, p.line, p.function, p.text);
        }
        fmt::print("\n| stage | sites | found | equivalent | unreached | missed | not listed | share found | ms a mutant |\n"
                   "|---|---|---|---|---|---|---|---|---|\n");
        const auto row = [](const std::string& name, const Tally& t) {
            fmt::print("| {} | {} | {} | {} | {} | {} | {} | {:.1f} % | {:.0f} |\n", name, t.sites, t.found, t.listed[0], t.listed[1],
                       t.listed[2], t.surprises(), 100 * t.share(), t.ms / std::max(t.sites, 1));
        };
        for (const StageBinding& b : parity::bindings())
            if (const auto at = of_stage.find(b.info.name); at != of_stage.end()) row(at->first, at->second);
        row("all", sum);
        fmt::print("\n{} sites, {} found, {} survivors that no list names; {:.1f} s\n", sum.sites, sum.found, sum.surprises(), seconds);
    }

    static std::string quoted(const std::string& text) {
        std::string out = "\"";
        for (const char c : text) {
            if (c == '"' || c == '\\') out += '\\';
            out += std::uint8_t(c) < 32 ? ' ' : c;
        }
        return out + "\"";
    }
    void print_json(const std::map<std::string, Tally>& of_stage, const Tally& sum, double seconds) const {
        const auto row = [](const Tally& t) {
            return fmt::format("{{\"sites\": {}, \"found\": {}, \"equivalent\": {}, \"unreached\": {}, \"missed\": {}, "
                               "\"not_listed\": {}, \"share_found\": {:.6f}, \"ms\": {:.1f}}}",
                               t.sites, t.found, t.listed[0], t.listed[1], t.listed[2], t.surprises(), t.share(), t.ms);
        };
        fmt::print("{{\"seconds\": {:.1f}, \"all\": {},\n \"stages\": {{", seconds, row(sum));
        const char* comma = "\n  ";
        for (const auto& [name, tally] : of_stage) fmt::print("{}{}: {}", comma, quoted(name), row(tally)), comma = ",\n  ";
        fmt::print("}},\n \"survivors\": [");
        comma = "\n  ";
        for (std::size_t i = 0; i < chosen_.size(); ++i) {
            const Outcome& o = outcomes_[i];
            if (o.fate == Fate::found) continue;
            const Site& site = all_.site(chosen_[i]);
            fmt::print("{}{{\"stage\": {}, \"file\": {}, \"line\": {}, \"function\": {}, \"text\": {}, \"change\": \"{}\", "
                       "\"part\": {}, \"fate\": \"{}\", \"sort\": \"{}\", \"reason\": {}}}",
                       comma, quoted(all_.stage(chosen_[i])), quoted(site.place.file), site.place.line,
                       quoted(site.place.function), quoted(site.place.text), change_name(site.change), site.part,
                       fate_name(o.fate), o.entry ? sort_name(o.entry->sort) : "", quoted(o.entry ? o.entry->reason : ""));
            comma = ",\n  ";
        }
        fmt::print("]}}\n");
    }

    const GenericOptions& options_;
    const GenericMutants& all_;
    const std::vector<GenericMutant> chosen_;
    const std::vector<Survivor>& survivors_;
    std::vector<Outcome> outcomes_;
    std::atomic<std::size_t> judged_ = 0;
};

int list_sites(const GenericMutants& all, const std::vector<GenericMutant>& chosen) {
    for (const GenericMutant& m : chosen) {
        const Site& site = all.site(m);
        fmt::print("{} {} {} {}:{} {}: {}\n", all.stage(m), change_name(site.change), site.part, site.place.file,
                   site.place.line, site.place.function, site.place.text);
    }
    return 0;
}

}  // namespace

std::uint64_t seed_of(const std::string& seed, const std::string& source) {
    std::string word = seed;
    if (word == "commit") {
        word = "0";
        const std::string command = "git -C '" + source + "' rev-parse HEAD 2>/dev/null";
        if (FILE* git = popen(command.c_str(), "r")) {
            char line[64] = {};
            if (std::fgets(line, sizeof line, git)) word = std::string("0x") + std::string(line).substr(0, 12);
            pclose(git);
        }
    }
    try {
        return std::stoull(word, nullptr, 0);
    } catch (const std::exception&) {
        throw InputError("--seed: " + seed + ": expected a number, or commit");
    }
}

int run_generic(const GenericOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    const TwinCompiler compiler(options.glslang, options.source);
    const GenericMutants all = generic_mutants(wanted_stages(options), compiler, options.source);
    std::vector<GenericMutant> chosen =
        options.sample > 0 ? sample(all, std::size_t(options.sample), seed_of(options.seed, options.source)) : all.mutants;
    if (options.list) return list_sites(all, chosen);

    std::vector<std::unique_ptr<vulkan::Device>> devices;
    try {
        for (int i = 0; i < thread_count(options.threads); ++i)
            devices.push_back(std::make_unique<vulkan::Device>(vulkan::DeviceOptions{options.device, false}));
    } catch (const vulkan::Error& e) {
        fmt::print("SKIPPED: {}\n", e.what());
        return 0;
    }
    const DeviceProfile& profile = find_profile(options.profile, "--profile");
    const std::vector<Survivor> survivors = read_survivors(options.survivors);
    const std::vector<Dispatch> data = dispatches(options.source);
    std::vector<Bench> benches;
    benches.reserve(devices.size());
    for (const auto& device : devices) benches.emplace_back(*device, all, data, profile);
    const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    std::fprintf(stderr, "%zu of %zu mutants, %.1f s\n", chosen.size(), all.mutants.size(), seconds());
    Run run(options, all, std::move(chosen), survivors);
    run.judge_all(benches);
    return run.report(seconds()) ? 0 : 1;
}

}  // namespace plumb::mutants
