#include "tools/bench_raster/experiments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>

#include "core/error.h"
#include "core/parallel.h"
#include "raster/gbuffer.h"
#include "raster/screen_triangle.h"
#include "raster/visibility.h"
#include "raster/workspace.h"
#ifdef PLUMB_WITH_VULKAN
#include "tools/bench_raster/peer.h"
#endif

namespace plumb::bench {
namespace {

// Our side: the G-buffer's three colour targets and depth, in memory that stays.
class Ours {
  public:
    Ours(const Resident& scene, glm::ivec2 size, const RunOptions& options)
        : scene_(scene), view_(scene.view(size)), size_(size), options_(options) {}

    double draw() {
        return clock_ms([&] {
            raster::draw_gbuffer(scene_.geometry, scene_.surfaces, view_, size_, raster::Layout::rgba16f, options_,
                                 out_, {.emission = false, .id = false}, &workspace_);
        });
    }
    // Parts of it, with the memory of the whole: positions in clip space; these and visibility.
    double draw_clip_positions() {
        return clock_ms([&] { raster::clip_positions(scene_.geometry, view_, options_.threads); });
    }
    double draw_visibility() {
        return clock_ms([&] {
            raster::draw_visibility(scene_.geometry, &scene_.surfaces, view_, size_, options_, visible_, &workspace_);
        });
    }
    const raster::GBuffer& picture() const { return out_; }

  private:
    const Resident& scene_;
    View view_;
    glm::ivec2 size_;
    RunOptions options_;
    raster::GBuffer out_;
    raster::VisibilityBuffer visible_;
    raster::Workspace workspace_;
};

#ifdef PLUMB_WITH_VULKAN
struct Rival {
    vulkan::Device device{{.name = "llvmpipe"}};
    std::unique_ptr<Peer> peer;
};
#else
struct Rival {};
#endif

class Session {
  public:
    explicit Session(const Options& options) : options_(options) {
        if (options.against_lavapipe) start_rival();
    }

    // Makes a scene the current one; a scene that is current already costs nothing.
    void use(const std::string& name, std::int64_t triangles) {
        if (scene_ && scene_->name == name && asked_ == triangles) return;
        forget();
        scene_ = std::make_unique<Resident>(load(name, triangles));
        asked_ = triangles;
#ifdef PLUMB_WITH_VULKAN
        if (rival_) rival_->peer = std::make_unique<Peer>(rival_->device, scene_->scene, scene_->geometry);
#endif
    }
    const Resident& scene() const { return *scene_; }

    // Leaves the processors to one side; the scene on the device goes.
    void forget() {
#ifdef PLUMB_WITH_VULKAN
        if (rival_) rival_->peer.reset();
#endif
        scene_.reset();
    }

    Row measure(const std::string& experiment, glm::ivec2 size) {
        Row row = blank(experiment, size);
        Ours ours(*scene_, size, options_.run_options());
        std::vector<std::function<double()>> sides{[&] { return ours.draw(); }};
#ifdef PLUMB_WITH_VULKAN
        if (rival_) {
            rival_->peer->set_view(scene_->view(size), size);
            sides.push_back([&] { return rival_->peer->draw(); });
        }
#endif
        const std::vector<Times> times = interleave(options_.runs, sides);
        row.ours = times[0];
#ifdef PLUMB_WITH_VULKAN
        if (rival_) {
            row.theirs = times[1];
            row.device_ms = rival_->peer->device_ms();
            row.agreement = compare(ours.picture(), rival_->peer->read());
        }
#endif
        return row;
    }

    Row blank(const std::string& experiment, glm::ivec2 size) const {
        Row row;
        row.experiment = experiment;
        row.scene = scene_->name;
        row.triangles = scene_->triangles();
        row.size = size;
        row.threads = thread_count(options_.threads);
        row.isa = isa_name(options_.isa);
        return row;
    }

  private:
    void start_rival() {
#ifdef PLUMB_WITH_VULKAN
        // lavapipe reads its number of threads when the device is made.
        setenv("LP_NUM_THREADS", std::to_string(thread_count(options_.threads)).c_str(), 1);
        try {
            rival_ = std::make_unique<Rival>();
        } catch (const vulkan::Error& error) {
            throw InputError(fmt::format("--against lavapipe: {}", error.what()));
        }
        fmt::print("Peer: {}, LP_NUM_THREADS={}.\n", rival_->device.name(), getenv("LP_NUM_THREADS"));
#else
        throw InputError(
            "--against lavapipe: built without Vulkan: install libvulkan-dev and mesa-vulkan-drivers "
            "(tools/install-deps), then configure again");
#endif
    }

    const Options& options_;
    std::unique_ptr<Rival> rival_;
    std::unique_ptr<Resident> scene_;
    std::int64_t asked_ = 0;
};

void print_header(const std::string& title, const std::string& columns) {
    const auto n = std::count(columns.begin(), columns.end(), '|') + 1;
    std::string rule = "|";
    for (int i = 0; i < n; ++i) rule += "---|";
    fmt::print("\n## {}\n\n| {} |\n{}\n", title, columns, rule);
    std::fflush(stdout);
}

const char* comparison_columns =
    "scene | triangles | pixels | ours, ms (least; processor) | lavapipe, ms (least; processor) | ratio of medians | "
    "of "
    "processor time | % of pixels that differ in coverage, position, normal, albedo";

std::string times_text(const Times& t) {
    return fmt::format("{:.2f} ({:.2f}; {:.1f})", t.median(), t.least(), t.cpu_median());
}

void print_comparison(const Row& row) {
    fmt::print("| {} | {} | {} x {} | {} | ", row.scene, row.triangles, row.size.x, row.size.y, times_text(row.ours));
    if (const auto& a = row.agreement)
        fmt::print("{} | **{:.2f}** | {:.2f} | {:.3f}, {:.3f}, {:.2f}, {:.2f} |\n", times_text(row.theirs), row.ratio(),
                   row.cpu_ratio(), 100 * a->coverage, 100 * a->position, 100 * a->normal, 100 * a->albedo);
    else
        fmt::print("| | | |\n");
    std::fflush(stdout);
    if (row.agreement && !row.agreement->plausible())
        throw std::runtime_error(fmt::format("{}, {} x {}: the two sides draw different pictures: {}", row.scene,
                                             row.size.x, row.size.y, row.agreement->text()));
}

void compare_sides(const Options& options, Session& session, std::vector<Row>& rows) {
    print_header("Against lavapipe", comparison_columns);
    std::vector<glm::ivec2> sizes{{512, 512}, {1024, 1024}, {1920, 1080}};
    if (options.quick) sizes = {{512, 512}};
    for (const std::string& scene : options.scenes) {
        session.use(scene, 0);
        for (const glm::ivec2& size : sizes) {
            rows.push_back(session.measure("compare", size));
            print_comparison(rows.back());
        }
    }
}

void split_phases(const Options& options, Session& session, std::vector<Row>& rows) {
    print_header("Where our processor time goes, ms of all threads together (medians)",
                 "scene | pixels | all | clip positions | visibility without them | resolve and round");
    for (const std::string& scene : options.scenes) {
        session.use(scene, 0);
        const glm::ivec2 size(1024);
        Ours ours(session.scene(), size, options.run_options());
        const std::vector<Times> times =
            interleave(options.runs, {[&] { return ours.draw(); }, [&] { return ours.draw_clip_positions(); },
                                      [&] { return ours.draw_visibility(); }});
        const double all = times[0].cpu_median(), clip = times[1].cpu_median(), visible = times[2].cpu_median();
        fmt::print("| {} | {} x {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n", scene, size.x, size.y, all, clip,
                   visible - clip, all - visible);
        for (std::size_t i = 0; i < 3; ++i) {
            const char* names[] = {"phase all", "phase clip", "phase clip and visibility"};
            rows.push_back(session.blank(names[i], size));
            rows.back().ours = times[i];
        }
    }
}

void compare_threads(const Options& options, Session& session, std::vector<Row>& rows) {
    const int all = thread_count(options.threads);
    print_header(
        "Threads",
        fmt::format(
            "scene | pixels | 1 thread, ms (least) | {} threads, ms (least) | ratio of medians | of processor time",
            all));
    for (const std::string& scene : options.scenes) {
        session.use(scene, 0);
        const glm::ivec2 size(1024);
        RunOptions one = options.run_options();
        one.threads = 1;
        Ours alone(session.scene(), size, one), together(session.scene(), size, options.run_options());
        const std::vector<Times> times =
            interleave(options.runs, {[&] { return alone.draw(); }, [&] { return together.draw(); }});
        fmt::print("| {} | {} x {} | {:.2f} ({:.2f}) | {:.2f} ({:.2f}) | {:.2f} | {:.2f} |\n", scene, size.x, size.y,
                   times[0].median(), times[0].least(), times[1].median(), times[1].least(),
                   times[0].median() / times[1].median(), times[0].cpu_median() / times[1].cpu_median());
        for (int i : {0, 1}) {
            rows.push_back(session.blank("threads", size));
            rows.back().threads = i == 0 ? 1 : all;
            rows.back().ours = times[std::size_t(i)];
        }
    }
}

void vary_triangles(const Options& options, Session& session, std::vector<Row>& rows) {
    print_header("Against triangles", comparison_columns);
    std::vector<std::int64_t> counts{1'000, 10'000, 100'000, 1'000'000, 10'000'000};
    if (options.quick) counts = {10'000, 100'000};
    for (const std::int64_t triangles : counts) {
        const std::string scene = options.scenes.back();
        if (!can_build(scene, triangles)) {
            fmt::print("| {} | {} | | not built from so many | | | | |\n", scene, triangles);
            continue;
        }
        session.use(scene, triangles);
        rows.push_back(session.measure("triangles", glm::ivec2(1024)));
        print_comparison(rows.back());
    }
}

void vary_pixels(const Options& options, Session& session, std::vector<Row>& rows) {
    print_header("Against pixels", comparison_columns);
    session.use(options.scenes.front(), 0);
    std::vector<int> sides{64, 128, 256, 512, 1024, 2048};
    if (options.quick) sides = {128, 256};
    for (int side : sides) {
        rows.push_back(session.measure("pixels", glm::ivec2(side)));
        print_comparison(rows.back());
    }
}

void measure_memory(const Options& options, Session& session) {
    const std::string scene = options.scenes.back();
    const std::int64_t triangles = options.quick ? 100'000 : 10'000'000;
    print_header("Memory",
                 "scene | triangles | pixels | scene, bytes a triangle | while drawing, bytes a triangle more");
    if (!can_build(scene, triangles)) {
        fmt::print("| {} | {} | not built from so many | | |\n", scene, triangles);
        return;
    }
    session.forget();
    const Resident resident = load(scene, triangles);
    const glm::ivec2 size(1024);
    Ours ours(resident, size, options.run_options());
    reset_peak();
    const std::size_t before = resident_bytes();
    ours.draw();
    const double n = double(resident.triangles());
    fmt::print("| {} | {} | {} x {} | {:.1f} | {:.1f} |\n", scene, resident.triangles(), size.x, size.y,
               double(resident.bytes()) / n, double(peak_bytes() - before) / n);
}

}  // namespace

RunOptions Options::run_options() const {
    RunOptions out;
    out.threads = threads;
    out.isa = isa;
    return out;
}

bool Options::wants(const std::string& experiment) const {
    return std::find(what.begin(), what.end(), experiment) != what.end();
}

std::vector<Row> run_experiments(const Options& options) {
    std::vector<Row> rows;
    fmt::print("Ours: {}, {} threads. Medians of {} runs, in turns; three RGBA16F targets and depth.\n",
               isa_name(options.isa), thread_count(options.threads), options.runs);
    Session session(options);
    if (options.wants("compare")) compare_sides(options, session, rows);
    if (options.wants("phases")) split_phases(options, session, rows);
    if (options.wants("threads")) compare_threads(options, session, rows);
    if (options.wants("pixels")) vary_pixels(options, session, rows);
    if (options.wants("triangles")) vary_triangles(options, session, rows);
    if (options.wants("memory")) measure_memory(options, session);
    return rows;
}

void write_csv(const std::string& file, const std::vector<Row>& rows) {
    std::ofstream out(file);
    out << "experiment,scene,triangles,width,height,threads,isa,runs,ours_ms,ours_least_ms,ours_cpu_ms,lavapipe_ms,"
           "lavapipe_least_ms,lavapipe_cpu_ms,lavapipe_device_ms,ratio,differ_coverage,differ_position,differ_normal,"
           "differ_albedo\n";
    for (const Row& r : rows) {
        out << fmt::format("{},{},{},{},{},{},{},{},{:.4f},{:.4f},{:.4f},", r.experiment, r.scene, r.triangles,
                           r.size.x, r.size.y, r.threads, r.isa, r.ours.ms.size(), r.ours.median(), r.ours.least(),
                           r.ours.cpu_median());
        if (r.agreement)
            out << fmt::format("{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.6f},{:.6f},{:.6f},{:.6f}\n", r.theirs.median(),
                               r.theirs.least(), r.theirs.cpu_median(), r.device_ms, r.ratio(), r.agreement->coverage,
                               r.agreement->position, r.agreement->normal, r.agreement->albedo);
        else
            out << ",,,,,,,,\n";
    }
    if (!out.flush()) throw InputError(fmt::format("{}: cannot be written", file));
}

}  // namespace plumb::bench
