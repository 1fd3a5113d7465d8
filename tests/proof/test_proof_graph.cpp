// What comes on the graph: an iteration to a residual, and host nodes that are kept in files and resumed after the program was
// killed.
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "gi/graph/graph.h"
#include "gi/lend.h"
#include "tests/proof/stages.h"
#include "tools/shared/file_store.h"

namespace {

using namespace plumb;
namespace fs = std::filesystem;

Bundle lent(const char* name, const Image4& image) {
    Bundle b;
    lend(b, name, image);
    return b;
}

// x = b + rho mean(x) by rounds of proof.step, and a node that reads the result.
struct Solve {
    glm::ivec2 size{12, 9};
    float rho = 0.5f;
    double enough = 1e-6;
    int most = 200;
    Image4 source, x, before, sum;
    int steps = 0;
    std::vector<graph::Node> nodes{};

    StageData step_data() {
        StageData d = begin_data<proof::StepKernel>(size, proof::StepView::Uniforms{size.x, size.y, rho, 0});
        lend(d, {{"source", &source}, {"before", &before}});
        return d;
    }

    double residual() const {
        double most_changed = 0;
        for (std::size_t i = 0; i < x.size(); ++i)
            for (int c = 0; c < 3; ++c) most_changed = std::max(most_changed, double(std::abs(x.texels[i][c] - before.texels[i][c])));
        return most_changed;
    }

    explicit Solve(float b = 1) {
        source = x = before = sum = Image4(size.x, size.y);
        sum = Image4(1, 1);
        graph::Node light;
        light.plan.name = light.plan.label = "light";
        light.size = [this] { return size; };
        light.reads = [b](graph::Reads& r) { r.value(b); };
        light.outputs = [this] { return lent("source", source); };
        light.run = [this, b](const RunOptions&, graph::NodeRun&) {
            std::fill(source.texels.begin(), source.texels.end(), glm::vec4(b, 2 * b, 0.25f * b, 1));
        };
        nodes.push_back(light);

        graph::Node start, step;
        start.plan.name = "start";
        start.outputs = [this] { return lent("x", x); };
        start.reads = [this](graph::Reads& r) { r.image(source); };
        start.run = [this](const RunOptions&, graph::NodeRun&) {
            x.texels.assign(source.texels.begin(), source.texels.end());
        };
        step.plan.name = "proof.step";
        step.outputs = [this] { return lent("before", before); };
        step.reads = [this](graph::Reads& r) {
            r.dispatch(stage<proof::StepKernel>(), step_data());
        };
        step.run = [this](const RunOptions& options, graph::NodeRun&) {
            before.texels.assign(x.texels.begin(), x.texels.end());
            run(stage<proof::StepKernel>(), step_data(), options, x);
            ++steps;
        };
        graph::NodePlan plan;
        plan.name = plan.label = "solve", plan.reason = "the light of all bounces";
        graph::Node solve = graph::repeat(plan, start, {step}, {most, enough, [this] { return residual(); }});
        solve.size = [this] { return size; };
        solve.outputs = [this] { return lent("x", x); };
        solve.load = [this](const Bundle& b) { x = image4(at(b, "x")); };
        nodes.push_back(solve);

        graph::Node mean;
        mean.plan.name = mean.plan.label = "mean";
        mean.size = [] { return glm::ivec2(1); };
        mean.reads = [this](graph::Reads& r) { r.image(x); };
        mean.outputs = [this] { return lent("mean", sum); };
        mean.run = [this](const RunOptions&, graph::NodeRun&) {
            glm::vec4 all(0);
            for (const glm::vec4& v : x.texels) all += v;
            sum = Image4(1, 1, all / float(x.size()));
        };
        nodes.push_back(mean);
    }
    std::vector<const graph::Node*> all() const {
        std::vector<const graph::Node*> pointers;
        for (const graph::Node& n : nodes) pointers.push_back(&n);
        return pointers;
    }
};

std::string folder_of(const std::string& name) {
    const fs::path folder = fs::path(PLUMB_BINARY_DIR) / "proof_store" / name;
    fs::remove_all(folder);
    return folder.string();
}

}  // namespace

TEST_CASE("graph: a group runs until its residual is small, and ends in the closed form", "[graph]") {
    Solve s;
    const std::vector<graph::NodeRun> runs = graph::run(s.all(), {});
    // A constant b: every mean is that constant, so x = b / (1 - rho); the change halves every round.
    CHECK(s.sum.texels[0].x == Approx(1 / (1 - 0.5)).epsilon(2e-6));
    CHECK(s.sum.texels[0].y == Approx(2 / (1 - 0.5)).epsilon(2e-6));
    // The change of the larger channel after n rounds is 2^(1 - n) or 0 where it is below an ULP of 4.
    CHECK(s.steps >= 20);
    CHECK(s.steps <= 24);
    CHECK(runs[1].reason.find(std::to_string(s.steps) + " rounds, residual ") != std::string::npos);
    CHECK(runs[1].reads == std::vector<std::string>{"light"});
    CHECK(runs[2].reads == std::vector<std::string>{"solve"});

    // Never enough: it stops after the rounds that it may run, and says so.
    graph::NodePlan plan;
    int rounds = 0;
    graph::Node step;
    step.outputs = [] { return Bundle(); }, step.reads = [](graph::Reads&) {};
    step.run = [&](const RunOptions&, graph::NodeRun&) { ++rounds; };
    graph::Node start = step;
    start.run = [](const RunOptions&, graph::NodeRun&) {};
    for (const double residual : {1.0, std::nan("")}) {
        rounds = 0;
        graph::Node never = graph::repeat(plan, start, {step}, {7, 0.5, [=] { return residual; }});
        graph::NodeRun run;
        never.run({}, run);
        CHECK(rounds == 7);
        CHECK(run.reason.find("more than 0.5") != std::string::npos);
    }
}

TEST_CASE("graph: an iteration is kept while what it reads is the same, and runs again where it is not", "[graph]") {
    Solve s;
    graph::Kept kept;
    graph::RunWith with;
    with.kept = &kept;
    graph::run(s.all(), with);
    const int first = s.steps;
    const std::vector<graph::NodeRun> again = graph::run(s.all(), with);
    CHECK(s.steps == first);
    for (const graph::NodeRun& run : again) CHECK(run.kept);
    // Another rho is a member of the step's block: the light is kept, what reads it is not.
    s.rho = 0.25f;
    const std::vector<graph::NodeRun> other = graph::run(s.all(), with);
    CHECK(s.steps > first);
    CHECK(other[0].kept);
    CHECK_FALSE(other[1].kept);
    CHECK_FALSE(other[2].kept);
    CHECK(s.sum.texels[0].x == Approx(1 / (1 - 0.25)).epsilon(2e-6));
    // What somebody else writes into memory that no node made is content: it counts.
    graph::Node stranger;
    stranger.plan.name = stranger.plan.label = "stranger";
    stranger.size = [] { return glm::ivec2(1); };
    Image4 foreign(2, 2), made(1, 1);
    stranger.reads = [&](graph::Reads& r) { r.image(foreign); };
    stranger.outputs = [&] { return lent("made", made); };
    int ran = 0;
    stranger.run = [&](const RunOptions&, graph::NodeRun&) { ++ran; };
    for (const float value : {1.0f, 1.0f, 2.0f}) {
        foreign.texels[3].y = value;
        static graph::Kept memory;
        with.kept = &memory;
        graph::run({&stranger}, with);
    }
    CHECK(ran == 2);
}

TEST_CASE("graph: two outputs of one node are two things to read, and after an exception nothing is kept", "[graph]") {
    Image4 a(4, 4, glm::vec4(1)), b(4, 4, glm::vec4(2)), copy(4, 4);
    bool second = false, fails = false;
    graph::Node both, reader, later;
    both.plan.name = both.plan.label = "both", reader.plan.name = reader.plan.label = "reader";
    later.plan.name = later.plan.label = "later";
    both.size = reader.size = later.size = [] { return glm::ivec2(4); };
    both.reads = later.reads = [](graph::Reads& r) { r.value(1); };
    both.outputs = [&] {
        Bundle bundle;
        lend(bundle, "a", a), lend(bundle, "b", b);
        return bundle;
    };
    both.run = [](const RunOptions&, graph::NodeRun&) {};
    reader.reads = [&](graph::Reads& r) { r.image(second ? b : a); };
    reader.outputs = [&] { return lent("copy", copy); };
    reader.run = [&](const RunOptions&, graph::NodeRun&) { copy.texels = (second ? b : a).texels; };
    later.outputs = [] { return Bundle(); };
    later.run = [&](const RunOptions&, graph::NodeRun&) {
        if (fails) throw InputError("later: no");
    };
    graph::Kept kept;
    graph::RunWith with;
    with.kept = &kept;
    graph::run({&both, &reader}, with);
    second = true;
    const auto runs = graph::run({&both, &reader}, with);
    CHECK(runs[0].kept);
    CHECK_FALSE(runs[1].kept);
    CHECK(copy.texels[5].x == 2);
    fails = true;
    CHECK_THROWS_AS(graph::run({&both, &reader, &later}, with), InputError);
    CHECK(kept.empty());
}

TEST_CASE("graph: what a host node made lies in a file, and is believed only as it was written", "[graph]") {
    const std::string folder = folder_of("believed");
    auto run_with = [&](float b, int& steps) {
        Solve s(b);
        cli::FileStore store(folder, "bake", {std::uint64_t(1) << 30, 1});
        graph::RunWith with;
        with.store = &store;
        const auto runs = graph::run(s.all(), with);
        steps = s.steps;
        CHECK(s.sum.texels[0].x == Approx(2 * b).epsilon(2e-6));
        return runs;
    };
    int steps = 0;
    CHECK_FALSE(run_with(1, steps)[1].kept);
    CHECK(steps > 0);
    CHECK(run_with(1, steps)[1].kept);
    CHECK(steps == 0);
    CHECK_FALSE(run_with(2, steps)[1].kept);  // other light, other key
    REQUIRE(std::distance(fs::directory_iterator(folder), fs::directory_iterator()) == 2);
    // One byte of each file is changed: both are made anew, and the note says so.
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(200);
        file.put('!');
    }
    CHECK_FALSE(run_with(1, steps)[1].kept);
    CHECK(run_with(1, steps)[1].kept);
}

TEST_CASE("graph: a run that was killed goes on where it was", "[graph]") {
    const std::string folder = folder_of("killed");
    // Five host nodes, each twice the one before; the child is killed while the fourth runs.
    struct Chain {
        std::vector<Image4> made = std::vector<Image4>(5);
        std::vector<graph::Node> nodes{};
        int ran = 0;
        explicit Chain(int killed_in) {
            for (int i = 0; i < 5; ++i) {
                graph::Node node;
                node.plan.name = node.plan.label = "host " + std::to_string(i);
                node.size = [] { return glm::ivec2(64, 64); };
                node.reads = [=, this](graph::Reads& r) {
                    r.value(i);
                    if (i > 0) r.image(made[std::size_t(i - 1)]);
                };
                node.outputs = [=, this] { return lent("made", made[std::size_t(i)]); };
                node.load = [=, this](const Bundle& b) { made[std::size_t(i)] = image4(at(b, "made")); };
                node.run = [=, this](const RunOptions&, graph::NodeRun&) {
                    if (i == killed_in) ::kill(::getpid(), SIGKILL);
                    made[std::size_t(i)] = i == 0 ? Image4(64, 64, glm::vec4(1)) : made[std::size_t(i - 1)];
                    for (glm::vec4& v : made[std::size_t(i)].texels) v *= 2.0f;
                    ++ran;
                };
                nodes.push_back(node);
            }
        }
        std::vector<graph::NodeRun> run(const std::string& folder) {
            cli::FileStore store(folder, "bake", {std::uint64_t(1) << 30, 1});
            store.pin();
            std::vector<const graph::Node*> all;
            for (const graph::Node& n : nodes) all.push_back(&n);
            graph::RunWith with;
            with.store = &store;
            return graph::run(all, with);
        }
    };
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        Chain(3).run(folder);
        ::_exit(0);  // not reached
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == SIGKILL);

    Chain resumed(-1);
    const std::vector<graph::NodeRun> runs = resumed.run(folder);
    REQUIRE(runs.size() == 5);
    for (int i = 0; i < 5; ++i) CHECK(runs[std::size_t(i)].kept == (i < 3));
    CHECK(resumed.ran == 2);
    CHECK(resumed.made[4].texels[100].x == 32);
    Chain third(-1);
    third.run(folder);
    CHECK(third.ran == 0);
    CHECK(third.made[4].texels[100].x == 32);
}

TEST_CASE("graph: a store keeps to its limit, but for what is pinned", "[graph]") {
    const std::string folder = folder_of("limit");
    auto bundle = [](float value) {
        Bundle b;
        add(b, "made", Image4(32, 32, glm::vec4(value)));  // 16 KiB
        return b;
    };
    cli::FileStore store(folder, "bake", {40000, 1});
    for (int i = 0; i < 5; ++i) store.keep(graph::Key(i + 1), bundle(float(i)), "test");
    auto count = [&] { return std::distance(fs::directory_iterator(folder), fs::directory_iterator()); };
    CHECK(count() == 2);
    CHECK(store.find(5));
    CHECK_FALSE(store.find(1));
    cli::FileStore pinned(folder, "bake", {40000, 1});
    pinned.pin();
    for (int i = 0; i < 5; ++i) pinned.keep(graph::Key(i + 11), bundle(float(i)), "test");
    for (int i = 0; i < 5; ++i) CHECK(pinned.find(graph::Key(i + 11)));
    // Another kind has a limit of its own, and another program's keys are others.
    cli::FileStore other(folder, "sweep", {40000, 1}), program(folder, "bake", {40000, 2});
    CHECK_FALSE(other.find(11));
    CHECK_FALSE(program.find(11));
    // What cannot be kept is a note.
    cli::FileStore nowhere("/dev/null/no", "bake", {40000, 1});
    nowhere.keep(1, bundle(1), "the bake");
    REQUIRE(nowhere.notes().size() == 1);
    CHECK(nowhere.notes()[0].find("the bake is not kept") != std::string::npos);
}
