// plumb_mutants: is the judge of GPU buffers to be trusted? Plants errors in the twins, which it must find, and legal
// changes, which it must let pass, and counts. Exit code 1 for a miss or a false alarm.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <future>
#include <map>
#include <thread>

#include "core/error.h"
#include "core/parallel.h"
#include "tools/mutants/generic_run.h"
#include "tools/mutants/trial.h"
#include "tools/vulkan/twins.h"

using namespace plumb;
using namespace plumb::mutants;

namespace {

struct Options {
    std::string lists = PLUMB_SOURCE_DIR "/tests/parity/mutants", source = PLUMB_SOURCE_DIR, glslang = PLUMB_GLSLANG;
    std::string device = "llvmpipe", profile = "ideal";
    std::vector<std::string> only, stages;
    bool list = false, sensitivity = false;
    int threads = 0, least_wrong = 0, least_legal = 0, least_a_stage = 0, share = 1;
    bool generic = false;
    GenericOptions of_generic;
};

bool wanted(const Options& options, const std::string& stage) {
    return options.stages.empty() ||
           std::find(options.stages.begin(), options.stages.end(), stage) != options.stages.end();
}
bool wanted(const Options& options, const Mutant& mutant) {
    const bool named = options.only.empty() ||
                       std::any_of(options.only.begin(), options.only.end(), [&](const std::string& word) {
                           return mutant.name.find(word) != std::string::npos;
                       });
    return named && wanted(options, mutant.stage) && (mutant.kind == Kind::scale) == options.sensitivity;
}

// How many mutants of each kind got each verdict, in all and a stage.
struct Matrix {
    using Counts = std::array<std::array<int, parity::verdicts>, 2>;
    std::vector<std::string> stages;
    std::map<std::string, Counts> of_stage;
    Counts all{};

    void add(const Mutant& mutant, parity::Verdict verdict) {
        if (of_stage.count(mutant.stage) == 0) stages.push_back(mutant.stage), of_stage[mutant.stage] = {};
        ++of_stage[mutant.stage][std::size_t(mutant.kind)][std::size_t(verdict)];
        ++all[std::size_t(mutant.kind)][std::size_t(verdict)];
    }
    static int sum(const std::array<int, parity::verdicts>& row) { return row[0] + row[1] + row[2] + row[3]; }

    void print() const {
        fmt::print("\n| stage | planted | mutants | equal | within_bound | ambiguous | wrong |\n|---|---|---|---|---|---|---|\n");
        for (const std::string& stage : stages) print(stage, of_stage.at(stage));
        print("all", all);
    }
    static void print(const std::string& stage, const Counts& counts) {
        for (const Kind kind : {Kind::wrong, Kind::legal}) {
            const auto& row = counts[std::size_t(kind)];
            fmt::print("| {} | {} | {} | {} | {} | {} | {} |\n", stage, kind_name(kind), sum(row), row[0], row[1], row[2],
                       row[3]);
        }
    }
};

std::string described(const Trial& t) {
    if (t.verdict == parity::Verdict::equal) return fmt::format("the same bits in {} dispatches", t.runs);
    const parity::WorstPixel& w = t.worst;
    return fmt::format("{}: {} of {} wrong; {},{} {}[{}]: {:.9g} for {:.9g}, {:.3g} bounds off; {:.2f} % ambiguous",
                       t.dispatch, t.wrong_pixels, t.pixels, w.pixel.x, w.pixel.y, w.output, w.channel, w.got, w.expected,
                       w.excess, 100 * t.ambiguous);
}

// Whether the judge said of it what it had to.
bool right(const Mutant& mutant, const Trial& trial) {
    return mutant.kind == Kind::wrong ? trial.verdict == parity::Verdict::wrong : trial.passed;
}

// Whether the lists hold as many as they are to, sampled or not.
bool enough(const Options& options, const std::vector<Mutant>& listed) {
    bool ok = true;
    const auto at_least = [&](const std::string& what, int n, int least) {
        if (n >= least) return;
        fmt::print("TOO FEW: {} {}, expected {}\n", n, what, least);
        ok = false;
    };
    std::map<std::string, int> wrong;
    int legal = 0, all = 0;
    for (const Mutant& m : listed) {
        int& of_stage = wrong[m.stage];
        if (m.kind == Kind::wrong) ++of_stage, ++all;
        legal += m.kind == Kind::legal;
    }
    at_least("wrong mutants", all, options.least_wrong);
    at_least("legal variants", legal, options.least_legal);
    for (const auto& [stage, n] : wrong) at_least("wrong mutants of " + stage, n, options.least_a_stage);
    return ok;
}

// Of each stage's mutants of a kind, one in `share`: of as many seeds that follow each other, all.
std::vector<Mutant> sampled(const std::vector<Mutant>& listed, std::uint64_t share, std::uint64_t seed) {
    std::vector<Mutant> some;
    std::map<std::pair<std::string, Kind>, std::uint64_t> of_stage;
    for (const Mutant& m : listed)
        if ((of_stage[{m.stage, m.kind}]++ + seed) % share == 0) some.push_back(m);
    return some;
}

// Calls one(judge, i) for i = 0 .. n - 1, each judge on a thread of its own, and tell(i, result) in order.
template <class Result>
void on_all(std::vector<Judge>& judges, std::size_t n, const std::function<Result(Judge&, std::size_t)>& one,
            const std::function<void(std::size_t, const Result&)>& tell) {
    std::vector<std::promise<Result>> promises(n);
    std::atomic<std::size_t> next = 0;
    std::vector<std::jthread> threads;
    for (Judge& judge : judges)
        threads.emplace_back([&, n] {
            for (std::size_t i; (i = next++) < n;) {
                try {
                    promises[i].set_value(one(judge, i));
                } catch (...) {
                    next = n;
                    promises[i].set_exception(std::current_exception());
                }
            }
        });
    for (std::size_t i = 0; i < n; ++i) tell(i, promises[i].get_future().get());
}

// The twins themselves must pass, or nothing that follows means anything.
bool try_unmutated(const Options& options, std::vector<Judge>& judges, const std::vector<Dispatch>& all) {
    std::vector<std::string> stages;
    for (const Dispatch& d : all)
        if (std::find(stages.begin(), stages.end(), d.data.stage) == stages.end() && wanted(options, d.data.stage))
            stages.push_back(d.data.stage);
    bool ok = true;
    on_all<Trial>(
        judges, stages.size(), [&](Judge& judge, std::size_t i) { return judge.unmutated(stages[i]); },
        [&](std::size_t i, const Trial& trial) {
            fmt::print("{:12} unmutated {}: {}\n", parity::verdict_name(trial.verdict), stages[i], described(trial));
            // Ambiguous it may be: a layer behind our own depths is, where a device's differ in their last bits.
            ok = ok && trial.verdict != parity::Verdict::wrong;
        });
    return ok;
}

bool try_all(std::vector<Judge>& judges, const std::vector<Mutant>& mutants) {
    Matrix matrix;
    int misses = 0, alarms = 0;
    const auto tell = [&](std::size_t i, const Trial& trial) {
        const Mutant& mutant = mutants[i];
        matrix.add(mutant, trial.verdict);
        const bool ok = right(mutant, trial);
        if (!ok) ++(mutant.kind == Kind::wrong ? misses : alarms);
        fmt::print("{:12} {} {}{}: {}\n", parity::verdict_name(trial.verdict), kind_name(mutant.kind), mutant.name,
                   ok ? "" : mutant.kind == Kind::wrong ? " MISSED" : " FALSE ALARM", described(trial));
        std::fflush(stdout);
    };
    on_all<Trial>(
        judges, mutants.size(),
        [&](Judge& judge, std::size_t i) { return judge(mutants[i], mutants[i].kind == Kind::wrong); }, tell);
    matrix.print();
    fmt::print("\n{} misses, {} false alarms\n", misses, alarms);
    return misses == 0 && alarms == 0;
}

void measure_sensitivity(std::vector<Judge>& judges, const std::vector<Mutant>& mutants) {
    fmt::print("\n| what is multiplied by 1 + e | smallest e that is wrong |\n|---|---|\n");
    on_all<double>(
        judges, mutants.size(), [&](Judge& judge, std::size_t i) { return smallest_error(judge, mutants[i]); },
        [&](std::size_t i, const double& e) {
            fmt::print("| {} | {} |\n", mutants[i].name, e > 0 ? fmt::format("{:.1e}", e) : "above 0.1");
            std::fflush(stdout);
        });
}

int run(const Options& options) {
    if (options.glslang.empty()) {
        fmt::print("SKIPPED: built without glslangValidator (glslang-tools)\n");
        return 0;
    }
    if (options.generic) {
        GenericOptions generic = options.of_generic;
        generic.glslang = options.glslang, generic.source = options.source, generic.device = options.device;
        generic.profile = options.profile, generic.stages = options.stages, generic.threads = options.threads;
        generic.list = options.list;
        if (std::getenv("PLUMB_FULL")) generic.sample = 0;
        return run_generic(generic);
    }
    std::vector<Mutant> mutants;
    for (Mutant& mutant : read_mutants(options.lists))
        if (wanted(options, mutant)) mutants.push_back(std::move(mutant));
    if (options.list) {
        for (const Mutant& m : mutants) fmt::print("{} {} {}\n", kind_name(m.kind), m.name, m.file);
        return 0;
    }

    const int share = std::getenv("PLUMB_FULL") ? 1 : options.share;
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::unique_ptr<vulkan::Device>> devices;
    try {
        vulkan::find_twin("raster/gbuffer.vert");  // vertex stages are embedded
        for (int i = 0; i < thread_count(options.threads); ++i)
            devices.push_back(std::make_unique<vulkan::Device>(vulkan::DeviceOptions{options.device, false}));
    } catch (const vulkan::Error& e) {
        fmt::print("SKIPPED: {}\n", e.what());
        return 0;
    }
    const DeviceProfile& profile = find_profile(options.profile, "--profile");
    const TwinCompiler compiler(options.glslang, options.source);
    const std::vector<Dispatch> all = dispatches(options.source);
    std::vector<Judge> judges;
    for (const auto& device : devices) judges.emplace_back(*device, compiler, all, profile);

    bool ok = enough(options, mutants);
    ok = try_unmutated(options, judges, all) && ok;
    if (options.sensitivity)
        measure_sensitivity(judges, mutants);
    else
        ok = try_all(judges, sampled(mutants, std::uint64_t(share), seed_of(options.of_generic.seed, options.source))) && ok;
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    fmt::print("{} on {} in {:.1f} s\n", ok ? "as it should be" : "FAILED", devices.front()->name(), seconds.count());
    return ok ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
    Options o;
    CLI::App app("Plants errors and legal changes in the twins, and holds the judge's verdicts against what they are.");
    app.add_option("--lists", o.lists, "folder of the lists");
    app.add_option("--source", o.source, "the project's root, where the twins lie");
    app.add_option("--device", o.device, "part of the name of a Vulkan device");
    app.add_option("--profile", o.profile, "what the judge knows of the device");
    app.add_option("--only", o.only, "mutants with this in their names");
    app.add_option("--stage", o.stages, "mutants of this stage");
    app.add_option("--threads", o.threads, "0: all processors");
    app.add_option("--least-wrong", o.least_wrong, "fail below so many wrong mutants");
    app.add_option("--least-a-stage", o.least_a_stage, "fail where a stage has fewer wrong mutants");
    app.add_option("--least-legal", o.least_legal, "fail below so many legal variants");
    app.add_flag("--list", o.list, "print the list and do nothing");
    app.add_flag("--sensitivity", o.sensitivity, "instead: the smallest relative error that is found, place by place");
    CLI::Option* generic = app.add_flag("--generic", o.generic, "instead: every place of the twins' SPIR-V, changed in every way");
    app.add_option("--sample", o.of_generic.sample, "so many of each stage; 0, or with PLUMB_FULL set: all")->needs(generic);
    app.add_option("--share", o.share, "of the lists' mutants one in so many, of every stage; with PLUMB_FULL set: all")->check(CLI::Range(1, 1000))->excludes(generic);
    app.add_option("--seed", o.of_generic.seed, "of the sample: a number, or \"commit\" for the one that is checked out");
    app.add_option("--survivors", o.of_generic.survivors, "list of those that need not be found")->needs(generic);
    app.add_flag("--json", o.of_generic.json, "print all of it as JSON")->needs(generic);
    CLI11_PARSE(app, argc, argv);
    // lavapipe takes longer to optimise a shader than to run it on a panel, and no shader comes again.
    setenv("GALLIVM_PERF", "nopt", 0);
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
    try {
        return run(o);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "plumb_mutants: %s\n", e.what());
        return 1;
    }
}
