// plumb batch: the steps of ISR appendix E, gather, pov and compare, over lists of views.
//
// A step's files are written under temporary names and renamed; a record of their hashes is written last (DIR/made).
// What a record vouches for is not made again. A view that fails is reported in its row and stops nothing.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/compare_pictures.h"
#include "core/content_hasher.h"
#include "core/error.h"
#include "core/parallel.h"
#include "gi/compose/compose.h"
#include "io/file.h"
#include "io/image_file.h"
#include "tools/experiments/isr.h"
#include "tools/plumb/cli.h"
#include "tools/shared/announce.h"
#include "tools/shared/batch_pov.h"
#include "tools/shared/outputs.h"
#include "tools/shared/sweep.h"
#include "tools/shared/sweep_subject.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct BatchOptions {
    Common common;
    std::vector<std::string> lists, sets;
    std::string folder, steps = "gather,pov,compare", size = "1024x768", model = "pov", preset = "physical", truths;
    int samples = 256, jobs = 1;
};

struct Steps {
    bool gather = false, pov = false, compare = false;
};
Steps parse_steps(const std::string& text) {
    Steps steps;
    for (std::size_t from = 0; from <= text.size();) {
        const std::size_t end = std::min(text.find(',', from), text.size());
        const std::string word = text.substr(from, end - from);
        if (word == "gather")
            steps.gather = true;
        else if (word == "pov")
            steps.pov = true;
        else if (word == "compare")
            steps.compare = true;
        else
            throw InputError(fmt::format("--steps {}: unknown step \"{}\": expected gather, pov, compare",
                                         io::printable(text), io::printable(word)));
        from = end + 1;
    }
    return steps;
}

// One view's way through the steps.
struct Row {
    std::string name, failed;                 // failed: "gather: why"
    bool gathered = false, modelled = false;  // made by this run, not kept
    std::optional<IsrMeasure> direct, isr;
};

class Batch {
  public:
    Batch(const BatchOptions& given, BatchScenes& scenes)
        : given_(given),
          size_(parse_size("--size", given.size, least_side)),
          scenes_(scenes),
          records_(given.folder),
          options_(given.common.run_options()),
          truths_(given.truths.empty() ? given.folder + "/truth" : given.truths, given.samples) {
        preset_ = given.preset == "published" ? io::PovPreset::published : io::PovPreset::physical;
        for (const BatchView& v : scenes.views()) rows_.push_back({v.name, "", false, false, {}, {}});
    }

    // Of one core, about, a million pixels; POV-Ray's radiosity (physical) takes most. What is kept from before is not made again.
    double expected_seconds(const Steps& steps) const {
        constexpr double gather = 5, pov = 900, path = 1.6, compare = 6;
        const double model = given_.model == "pov" ? pov * thread_count(options_.threads) / given_.jobs : path * given_.samples;
        return 1e-6 * size_.x * size_.y * double(rows_.size()) * (gather * steps.gather + model * steps.pov + compare * steps.compare);
    }

    void run(const Steps& steps) {
        announce(fmt::format("batch: {} views of {} x {}", rows_.size(), size_.x, size_.y), expected_seconds(steps), options_);
        if (steps.gather) each("gather", [&](std::size_t i) { gather(i); });
        if (steps.pov && given_.model == "pov") render_scripts();
        if (steps.pov && given_.model == "path") each("pov", [&](std::size_t i) { trace(i); });
        if (steps.compare) each("compare", [&](std::size_t i) { compare(i); });
        show_progress("");
    }
    const std::vector<Row>& rows() const { return rows_; }
    const std::vector<std::string>& notes() const { return truths_.notes(); }

  private:
    const BatchView& view(std::size_t i) const { return scenes_.views()[i]; }

    void each(const char* step, const std::function<void(std::size_t)>& work) {
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            if (!rows_[i].failed.empty()) continue;
            show_progress(fmt::format("{}: {} of {}", step, i + 1, rows_.size()));
            try {
                work(i);
            } catch (const InputError& e) {
                rows_[i].failed = fmt::format("{}: {}", step, e.what());
            }
        }
    }

    // The model of POV-Ray shows a texture as its mean: all pictures of such a view do.
    Scene scene_of(std::size_t i) {
        const Scene& scene = scenes_.scene(view(i), size_);
        return given_.model == "pov" ? io::pov_scene(scene) : scene;
    }
    std::uint64_t gather_key(std::size_t i) {
        ContentHasher key;
        key.add(program_hash(), scenes_.content(view(i), size_));
        key.add(given_.model), key.add(given_.preset);
        for (const std::string& set : given_.sets) key.add(set);
        return key.hash;
    }

    void write_exr(Outputs& outputs, const std::string& name, const Image4& image) {
        outputs.write(name, [&](const std::string& path) {
            io::write_exr(path, image.width, image.height,
                          {{"color", {"R", "G", "B"}, reinterpret_cast<const float*>(image.data()), 4}});
        });
    }
    // As the view's list says, else as the scene does: a model's exposure is not known yet.
    Image4 shown(std::size_t i, const Scene& scene, const Image4& radiance) {
        const double own = isr_settings(scene, "direct", {}).tonemap.exposure;
        return isr_display(radiance, scenes_.listed(view(i)).exposure.value_or(own), options_);
    }

    void gather(std::size_t i) {
        const std::string& name = rows_[i].name;
        const std::uint64_t key = gather_key(i);
        if (records_.find(name + ".gather", key)) return;
        const Scene scene = scene_of(i);
        const frame::Frame direct = isr_frame(scene, isr_settings(scene, "direct", {}), options_),
                           isr = isr_frame(scene, isr_settings(scene, "isr", given_.sets), options_);
        Outputs outputs(given_.folder);
        std::vector<std::string> files;
        for (const auto& [kind, image] : {std::pair("dl", &direct.radiance), std::pair("isr", &isr.radiance)}) {
            const Image4 display = shown(i, scene, *image);
            files.push_back(fmt::format("{}.{}.png", name, kind));
            outputs.write(files.back(), [&](const std::string& path) {
                io::write_png(path, size_.x, size_.y, compose::to_bytes(display).data());
            });
            files.push_back(fmt::format("{}.{}.exr", name, kind));
            write_exr(outputs, files.back(), *image);
        }
        if (given_.model == "pov") {
            io::PovOptions pov;
            pov.size = size_, pov.preset = preset_;
            files.push_back(name + ".pov");
            outputs.write(files.back(), [&](const std::string& path) { io::write_pov(path, scene, pov); });
        }
        outputs.commit();
        records_.keep(name + ".gather", key, files);
        rows_[i].gathered = true;
    }

    std::string file(std::size_t i, const char* ending) const { return given_.folder + "/" + rows_[i].name + ending; }
    void require_file(std::size_t i, const char* ending, const char* step) const {
        std::error_code error;
        if (!std::filesystem::exists(file(i, ending), error))
            throw InputError(fmt::format("{} is missing: expected --steps {} before", rows_[i].name + ending, step));
    }

    // Scripts are independent of each other: --jobs of them run side by side, one thread each.
    void render_scripts() {
        std::atomic<std::size_t> next{0};
        auto work = [&] {
            for (std::size_t i = next++; i < rows_.size(); i = next++) {
                if (!rows_[i].failed.empty()) continue;
                try {
                    render_script(i);
                } catch (const std::exception& e) {
                    rows_[i].failed = fmt::format("pov: {}", e.what());
                }
            }
        };
        show_progress("POV-Ray");
        std::vector<std::thread> threads;
        for (int t = 1; t < given_.jobs; ++t) threads.emplace_back(work);
        work();
        for (std::thread& t : threads) t.join();
    }

    void render_script(std::size_t i) {
        require_file(i, ".pov", "gather");
        const std::string& name = rows_[i].name;
        ContentHasher key;
        key.add(records_.hash_of(name + ".pov"), std::int32_t(size_.x), std::int32_t(size_.y));
        if (records_.find(name + ".model", key.hash)) return;
        // povray writes where it is told and leaves half a picture when it is cut; a picture counts once it is moved.
        const std::string part = file(i, ".part.exr"), log = file(i, ".log");
        const double seconds = run_povray(file(i, ".pov"), part, size_, log);
        read_radiance(part, size_);
        std::filesystem::rename(part, file(i, ".model.exr"));
        std::error_code error;
        std::filesystem::remove(log, error);
        records_.keep(name + ".model", key.hash, {name + ".model.exr"}, {{"seconds", seconds}});
        rows_[i].modelled = true;
    }

    void trace(std::size_t i) {
        const std::string& name = rows_[i].name;
        ContentHasher key;
        key.add(truth_version, scenes_.content(view(i), size_), std::int32_t(given_.samples));
        if (records_.find(name + ".model", key.hash)) return;
        const reference::KeptEstimate truth = truths_.of(scenes_, view(i), size_, options_);
        Outputs outputs(given_.folder);
        write_exr(outputs, name + ".model.exr", truth.estimate.mean);
        outputs.commit();
        records_.keep(name + ".model", key.hash, {name + ".model.exr"}, {{"seconds", truth.ms * 1e-3}});
        rows_[i].modelled = true;
    }

    void compare(std::size_t i) {
        require_file(i, ".dl.exr", "gather"), require_file(i, ".isr.exr", "gather");
        require_file(i, ".model.exr", "pov");
        const Image4 direct = read_radiance(file(i, ".dl.exr"), size_), isr = read_radiance(file(i, ".isr.exr"), size_),
                     radiance = read_radiance(file(i, ".model.exr"), size_);
        const double exposure = scenes_.listed(view(i)).exposure.value_or(isr_exposure(radiance));
        const IsrModel model = isr_model(radiance, exposure, options_);
        const Image4 direct_display = isr_display(direct, exposure, options_),
                     isr_shown = isr_display(isr, exposure, options_);
        rows_[i].direct = isr_compare(model, direct_display, direct, {}, options_);
        rows_[i].isr = isr_compare(model, direct_display, isr, {}, options_);

        // The pictures that the numbers are of, at the model's exposure, and the negative difference of the last two.
        const compare::Picture negative =
            compare::difference(isr_rgb(isr_shown), isr_rgb(model.display), compare::Difference::negative);
        Image4 difference(size_.x, size_.y);
        for (std::size_t p = 0; p < difference.size(); ++p)
            difference.texels[p] = {negative.data[3 * p], negative.data[3 * p + 1], negative.data[3 * p + 2], 1};
        Outputs outputs(given_.folder);
        const Image4* const pictures[] = {&direct_display, &isr_shown, &model.display, &difference};
        const char* const endings[] = {"_01.png", "_02.png", "_03.png", ".difference.png"};  // appendix E's names
        for (std::size_t p = 0; p < 4; ++p)
            outputs.write(rows_[i].name + endings[p], [&](const std::string& path) {
                io::write_png(path, size_.x, size_.y, compose::to_bytes(*pictures[p]).data());
            });
        outputs.commit();
    }

    const BatchOptions& given_;
    glm::ivec2 size_;
    BatchScenes& scenes_;
    BatchRecords records_;
    RunOptions options_;
    BatchTruths truths_;
    io::PovPreset preset_ = io::PovPreset::physical;
    std::vector<Row> rows_;
};

double gain_of(const Row& row) { return compare::gain(row.direct->mean_error, row.isr->mean_error).value_or(0); }
std::string number_text(const std::optional<double>& v) { return v ? fmt::format("{}", *v) : ""; }

// A line a view: what failed has its reason in place of numbers.
std::string csv_of(const std::vector<Row>& rows) {
    std::string text =
        "view,correlation_dl,mean_error_dl,correlation_isr,mean_error_isr,quality,gain_percent,improved_percent,"
        "worse_percent,correlation,mean,failed\n";
    for (const Row& r : rows) {
        std::string failed = r.failed;
        std::replace(failed.begin(), failed.end(), '"', '\'');
        if (!r.isr) {
            text += fmt::format("{},,,,,,,,,,,\"{}\"\n", r.name, failed);
            continue;
        }
        const bool c = r.isr->pearson && r.direct->pearson && *r.isr->pearson > *r.direct->pearson;
        text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},\n", r.name, number_text(r.direct->pearson),
                            r.direct->mean_error, number_text(r.isr->pearson), r.isr->mean_error,
                            compare::quality(r.isr->mean_error, r.direct->mean_error), 100 * gain_of(r),
                            100 * r.isr->improved, 100 * r.isr->worse, c ? "OK" : "failed",
                            r.isr->mean_error < r.direct->mean_error ? "OK" : "failed");
    }
    return text;
}

// As appendix E prints: correlation and mean error of each, and the means at the end.
std::string text_of(const std::vector<Row>& rows) {
    std::vector<std::vector<std::string>> cells;
    double c0 = 0, c1 = 0, m0 = 0, m1 = 0;
    int views = 0, correlated = 0;
    for (const Row& r : rows) {
        if (!r.isr) {
            if (!r.failed.empty()) cells.push_back({r.name, "", "", "", "", r.failed});
            continue;
        }
        ++views, m0 += r.direct->mean_error, m1 += r.isr->mean_error;
        const bool both = r.direct->pearson && r.isr->pearson;
        if (both) ++correlated, c0 += *r.direct->pearson, c1 += *r.isr->pearson;
        auto four = [](const std::optional<double>& v) { return v ? fmt::format("{:.6f}", *v) : "-"; };
        cells.push_back({r.name, four(r.direct->pearson), four(r.direct->mean_error), four(r.isr->pearson),
                         four(r.isr->mean_error), both && *r.isr->pearson > *r.direct->pearson ? "c:OK" : "c:failed",
                         r.isr->mean_error < r.direct->mean_error ? "m:OK" : "m:failed"});
    }
    for (auto& row : cells) row.resize(7);
    std::string text =
        cells.empty() ? "" : format_table({{"view"}, {"c DL"}, {"m DL"}, {"c ISR"}, {"m ISR"}, {""}, {""}}, cells);
    if (correlated > 0) text += fmt::format("{:.6f} vs. {:.6f}\n", c0 / correlated, c1 / correlated);
    if (views > 0) text += fmt::format("{:.6f} vs. {:.6f}\n", m0 / views, m1 / views);
    return text;
}

int run_batch(const BatchOptions& given) {
    const Steps steps = parse_steps(given.steps);
    BatchScenes scenes(given.lists);
    Batch batch(given, scenes);
    io::make_folder(given.folder);
    batch.run(steps);

    int gathered = 0, modelled = 0, failed = 0;
    for (const Row& r : batch.rows()) gathered += r.gathered, modelled += r.modelled, failed += !r.failed.empty();
    std::string text = text_of(batch.rows());
    if (steps.compare) {
        Outputs outputs(given.folder);
        outputs.write("res.csv", [&](const std::string& path) { io::write_text(path, csv_of(batch.rows())); });
        outputs.write("res.txt", [&](const std::string& path) { io::write_text(path, text); });
        outputs.commit();
    }
    if (given.common.json) {
        Json views = Json::array();
        for (const Row& r : batch.rows()) {
            Json view = {{"name", r.name},
                         {"failed", r.failed.empty() ? Json(nullptr) : Json(r.failed)},
                         {"gathered", r.gathered},
                         {"modelled", r.modelled}};
            if (r.isr) {
                view["mean_error"] = {{"dl", r.direct->mean_error}, {"isr", r.isr->mean_error}};
                auto pearson = [](const IsrMeasure& m) { return m.pearson ? Json(*m.pearson) : Json(nullptr); };
                view["correlation"] = {{"dl", pearson(*r.direct)}, {"isr", pearson(*r.isr)}};
                view["quality"] = compare::quality(r.isr->mean_error, r.direct->mean_error);
                view["gain"] = gain_of(r);
                view["improved"] = r.isr->improved, view["worse"] = r.isr->worse;
            }
            views.push_back(view);
        }
        text = json_text({{"views", views}, {"gathered", gathered}, {"modelled", modelled}, {"failed", failed}});
    } else {
        text += fmt::format("{} views: {} gathered, {} models made, {} failed\n", batch.rows().size(), gathered,
                            modelled, failed);
        for (const std::string& note : batch.notes()) text += "note: " + note + "\n";
    }
    std::fputs(text.c_str(), stdout);
    return failed > 0 ? disagreement : success;
}

}  // namespace

void add_batch(CLI::App& program, Action& action) {
    auto given = std::make_shared<BatchOptions>();
    CLI::App* command =
        program.add_subcommand("batch", "render the views of camera lists and their models, and compare");
    command->add_option("list", given->lists, "camera lists (plumb cameras)")
        ->required()
        ->check(some_word())
        ->type_name("LIST");
    command->add_option("-o,--output", given->folder, "folder for all files")
        ->required()
        ->check(some_word())
        ->type_name("DIR");
    command->add_option("--steps", given->steps, "gather, pov, compare; all three otherwise")->type_name("S,S");
    command->add_option("--size", given->size, "pixels of a view; 1024x768 otherwise")->type_name("WxH");
    command->add_option("--model", given->model, "who renders the model: pov (POV-Ray) or path (the path tracer)")
        ->check(CLI::IsMember({"pov", "path"}).description(""))
        ->type_name("MODEL");
    command->add_option("--preset", given->preset, "of POV-Ray's radiosity: physical, or published as ISR's table 1")
        ->check(CLI::IsMember({"physical", "published"}).description(""))
        ->type_name("PRESET");
    command->add_option("--samples", given->samples, "paths a pixel of model path; 256 otherwise")
        ->check(CLI::Range(16, 65536).description(""))
        ->type_name("N");
    command->add_option("--truths", given->truths, "folder of truths that are kept; DIR/truth otherwise")
        ->type_name("DIR");
    command->add_option("--set", given->sets, "table.key=value of the ISR picture; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    command->add_option("--jobs", given->jobs, "processes of POV-Ray side by side; 1 otherwise")
        ->check(CLI::Range(1, 256).description(""))
        ->type_name("N");
    add_common(*command, given->common);
    command->footer(
        "What exists and was made of the same inputs is not made again. Exit code 1: a view failed; its row says why.");
    command->callback([given, &action] { action = [=] { return run_batch(*given); }; });
}

}  // namespace plumb::cli
