// plumb experiment isr: the command. isr.h says what it repeats.
#include "tools/experiments/isr.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/parallel.h"
#include "io/file.h"
#include "tools/experiments/experiments.h"
#include "tools/shared/announce.h"
#include "tools/shared/machine_load.h"
#include "tools/shared/outputs.h"
#include "tools/shared/sweep.h"
#include "tools/shared/sweep_subject.h"

namespace plumb::cli {

namespace {

struct IsrOptions {
    IsrRequest request;
    Common common;
    std::string folder, truths, pairing = "none", size, time_size = "1024x768";
};

std::string command_line(const IsrOptions& given) {
    const IsrRequest r, &now = given.request;
    std::string text = "plumb experiment isr -o " + given.folder;
    if (now.pairing) text += " --pairing pov";
    for (const std::string& list : now.lists) text += " --list " + list;
    text += fmt::format(" --size {}x{} --samples {}", now.size.x, now.size.y, now.samples);
    if (given.time_size != "1024x768") text += " --time-size " + given.time_size;
    if (now.views != r.views) text += fmt::format(" --views {}", now.views);
    if (now.pov != r.pov) text += fmt::format(" --pov {}", now.pov);
    if (now.repeats != r.repeats) text += fmt::format(" --repeats {}", now.repeats);
    if (now.beyond_views != r.beyond_views) text += fmt::format(" --beyond-views {}", now.beyond_views);
    if (now.turning_views != r.turning_views) text += fmt::format(" --turning-views {}", now.turning_views);
    if (!given.truths.empty()) text += " --truths " + given.truths;
    if (given.common.threads > 0) text += fmt::format(" --threads {}", given.common.threads);
    if (given.common.isa != "auto") text += " --isa " + given.common.isa;
    return text;
}

IsrResult measure(const IsrOptions& given, const IsrCommon& common, const std::vector<BatchView>& views) {
    IsrResult result;
    result.request = given.request, result.processor = processor_name();
    result.threads = thread_count(common.options.threads), result.load_before = machine_load();
    for (std::size_t i = 0; i < views.size(); ++i) {
        show_progress(fmt::format("{}, {} of {}", views[i].name, i + 1, views.size()));
        result.views.push_back(isr_measure_view(common, views[i]));
    }
    result.best = isr_best(result.views);
    show_progress("times");
    isr_times(common, views, result);
    if (given.request.pov > 0) result.pov = isr_pov(common, views);
    if (given.request.beyond_views > 0) isr_beyond(common, views, result);
    if (given.request.turning_views > 0) result.turning = isr_turning(common, views);
    result.load_after = machine_load();
    return result;
}

int trace_alone(const IsrCommon& common, const std::vector<BatchView>& views) {
    for (std::size_t i = 0; i < views.size(); ++i) {
        show_progress(fmt::format("{}, {} of {}", views[i].name, i + 1, views.size()));
        common.truths.of(common.scenes, views[i], common.request.size, common.options);
    }
    show_progress("");
    std::printf("%zu truths, %d of them traced now\n", views.size(), common.truths.traced());
    return success;
}

// The thesis' pairing alone: everything else is left out.
int pair(const IsrOptions& given, const IsrCommon& common, const std::vector<BatchView>& views) {
    IsrResult result;
    result.request = given.request;
    const std::vector<IsrPairing> pairings = isr_pairing(common, views, given.folder + "/pov");
    show_progress("");
    const std::size_t of = common.scenes.views().size();
    const std::vector<IsrNumber> numbers = isr_pairing_numbers(pairings);
    if (numbers.empty()) throw InputError(fmt::format("--pairing pov: no view could be made: {}", pairings.front().failed));
    const std::string json = json_text(isr_pairing_json(result, pairings, of, numbers)), csv = vrsm_csv(numbers);
    const std::string html = isr_pairing_html(result, pairings, of, numbers, command_line(given));
    Outputs outputs(given.folder);
    outputs.write("pairing.json", [&](const std::string& path) { io::write_text(path, json); });
    outputs.write("pairing.csv", [&](const std::string& path) { io::write_text(path, csv); });
    outputs.write("pairing.html", [&](const std::string& path) { io::write_text(path, html); });
    outputs.commit();
    std::string text = isr_pairing_text(pairings, of, numbers);
    for (const std::string& file : outputs.files()) text += "wrote " + file + "\n";
    std::fputs((given.common.json ? json : text).c_str(), stdout);
    return success;
}

int run_isr(IsrOptions given) {
    if (given.pairing != "none" && given.pairing != "pov")
        throw InputError("--pairing " + io::printable(given.pairing) + ": expected none or pov");
    given.request.pairing = given.pairing == "pov";
    // 5.2.4 has 1024 x 768; without POV-Ray all views of that size would take a day.
    if (given.size.empty()) given.size = given.request.pairing ? "1024x768" : "192x144";
    given.request.size = parse_size("--size", given.size, least_side);
    given.request.time_size = parse_size("--time-size", given.time_size, least_side);
    const RunOptions options = given.common.run_options();
    // Of the folder in which the repository is worked on.
    if (given.request.lists.empty())
        given.request.lists = {"data/cameras/isr_simple.toml", "data/cameras/isr_complex.toml"};
    BatchScenes scenes(given.request.lists);
    BatchTruths truths(given.truths.empty() ? given.folder + "/truth" : given.truths, given.request.samples);
    BatchResults results(given.folder + "/results");
    const IsrCommon common{scenes, truths, results, given.request, options};
    const std::vector<BatchView> views = isr_views_of(scenes, given.request.views);
    if (given.request.pairing) return pair(given, common, views);
    // Of one core: 3.2 us a path of the truths, 40 us a pixel for what is held against them.
    const double pixels = double(views.size()) * given.request.size.x * given.request.size.y;
    announce(fmt::format("experiment isr: {} views, less what is kept in {}", views.size(), io::shown(given.folder)),
             pixels * ((given.request.truth_only ? 1.6e-6 : 3.2e-6) * given.request.samples + (given.request.truth_only ? 0 : 4e-5)), options);
    if (given.request.truth_only) return trace_alone(common, views);

    IsrResult result = measure(given, common, views);
    result.isa = isa_name(last_dispatched_isa());
    const std::vector<IsrNumber> numbers = isr_numbers(result);
    const IsrGallery gallery = isr_gallery(common, views, result);
    show_progress("");
    const std::string json = json_text(isr_json(result, numbers)), csv = vrsm_csv(numbers);
    const std::string html = isr_html(result, numbers, gallery, command_line(given));
    Outputs outputs(given.folder);
    outputs.write("isr.json", [&](const std::string& path) { io::write_text(path, json); });
    outputs.write("isr.csv", [&](const std::string& path) { io::write_text(path, csv); });
    outputs.write("isr.html", [&](const std::string& path) { io::write_text(path, html); });
    outputs.commit();
    std::string text = isr_text(result, numbers);
    for (const std::string& note : truths.notes()) text += "note: " + note + "\n";
    for (const std::string& file : outputs.files()) text += "wrote " + file + "\n";
    std::fputs((given.common.json ? json : text).c_str(), stdout);
    return success;
}

}  // namespace

void add_isr(CLI::App& experiment, Action& action) {
    auto given = std::make_shared<IsrOptions>();
    IsrRequest& request = given->request;
    CLI::App* command = experiment.add_subcommand(
        "isr", "ISR's evaluation: direct light and image-space radiosity against the path tracer and POV-Ray");
    command->add_option("-o,--output", given->folder, "folder for what is written, and for what is kept on the way")
        ->required()
        ->check(some_word())
        ->type_name("DIR");
    command
        ->add_option("--list", request.lists,
                     "a camera list (plumb cameras); may be repeated; the two of data/cameras otherwise")
        ->allow_extra_args(false)
        ->check(some_word())
        ->type_name("FILE");
    command->add_option("--truths", given->truths, "folder of the path traced truths; DIR/truth otherwise")
        ->type_name("DIR");
    command->add_option("--size", given->size, "pixels of a view; 192x144 otherwise, with --pairing 1024x768")->type_name("WxH");
    command
        ->add_option("--pairing", given->pairing,
                     "pov: the thesis' pairing alone, printed ISR and direct light against POV-Ray, reading by reading; none otherwise")
        ->check(some_word())
        ->type_name("P");
    command->add_option("--time-size", given->time_size, "pixels of figure 5.7; 1024x768 otherwise")->type_name("WxH");
    auto number = [&](const char* name, int& value, int least, int most, const char* what) {
        command->add_option(name, value, what)->check(CLI::Range(least, most).description(""))->type_name("N");
    };
    number("--samples", request.samples, 16, 65536, "paths a pixel of the truths; 128 otherwise");
    number("--views", request.views, 1, int(io::max_listed_cameras),
           "so many of each list, spread over it; all otherwise");
    number("--pov", request.pov, 0, 1000, "views that POV-Ray renders as well; none otherwise");
    number("--repeats", request.repeats, 1, 1000, "times each time is taken; 3 otherwise");
    number("--beyond-views", request.beyond_views, 0, 1000, "views for settings beyond the thesis'; 6 otherwise");
    number("--turning-views", request.turning_views, 0, 1000, "views from which the camera turns; 3 otherwise");
    command->add_flag("--truth-only", request.truth_only, "trace the truths and stop");
    add_common(*command, given->common);
    command->footer(
        "Example: plumb experiment isr -o out --list data/cameras/isr_simple.toml --list "
        "data/cameras/isr_complex.toml\n"
        "A run that was cut goes on where it was: truths lie in DIR/truth until you remove them, results in "
        "DIR/results\n"
        "as long as the program is the same.");
    command->callback([given, &action] { action = [=] { return run_isr(*given); }; });
}

}  // namespace plumb::cli
