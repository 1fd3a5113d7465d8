// plumb validate: one verdict per GPU pass, from its dumped inputs and outputs.
#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "core/error.h"
#include "gi/parity/verdict.h"
#include "gi/rsm/sampled.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/manifest.h"
#include "tools/plumb/output_forms.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/diagnosis_dumps.h"
#include "tools/plumb/diagnosis_mutants.h"
#include "tools/plumb/memory_need.h"
#include "tools/plumb/stage_case.h"
#include "tools/plumb/validate_init.h"
#include "tools/plumb/validate_refill.h"
#include "tools/plumb/validate_stale.h"
#include "tools/plumb/verdict_picture.h"
#include "tools/plumb/verdict_report.h"
#include "tools/shared/options.h"
#include "tools/shared/outputs.h"
#include "tools/shared/process_memory.h"

namespace plumb::cli {

namespace {

struct ValidateOptions {
    Common common;
    std::string manifest, junit, html, profile, folder, init;
    std::optional<double> max_ambiguous;
    std::string mutants;  // a device that runs mutants of twins
    bool refill = false, without_diagnosis = false;

    bool pictures() const { return !folder.empty() || !html.empty(); }
};

glm::ivec2 explained_pixel(const StageReport& report) {
    for (const parity::LargeError& error : report.diagnosis.wrong.largest)
        if (error.expected != 0) return error.pixel;
    return report.verdict.worst.front().pixel;
}

// One row: the verdict; where not all is equal how our kernel comes to its value at the worst pixel; and the pictures.
// `guesses`: at what is wrong, of what this command alone knows.
StageReport report_on(const StageCase& stage, const ValidateOptions& given, const parity::JudgeOptions& options,
                      const std::function<std::vector<parity::Hypothesis>()>& guesses) {
    StageReport report{parity::judge(*stage.binding, stage.data, stage.dumped, options), stage.notes, "", {}, {}, {}, {}};
    const parity::StageVerdict& verdict = report.verdict;
    const bool written = verdict.unwritten < verdict.pixels;
    const bool differs = verdict.verdict != parity::Verdict::equal && !verdict.worst.empty() && written;
    if (given.pictures()) report.map = verdict_picture(verdict, {});
    if (!differs) return report;
    const std::unique_ptr<BoundStage> bound = stage.binding->bind(stage.data);
    if (!given.without_diagnosis && verdict.verdict == parity::Verdict::wrong)
        report.diagnosis = parity::diagnose(*stage.binding, stage.data, stage.dumped, options, verdict, guesses());
    report.explained = explained_pixel(report);
    report.explanation = bound->explain(report.explained, options.profile);
    if (!given.pictures()) return report;
    report.map = verdict_picture(verdict, report.diagnosis);
    Bundle expected;
    bound->run(options.run, options.profile, expected);
    report.error = error_picture(verdict, stage.dumped, expected);
    if (given.html.empty()) return report;
    report.outputs = output_pictures(*stage.binding, stage.dumped, expected);
    report.samples = sample_plot(*stage.binding, stage.data, report.explained, report.explanation);
    return report;
}

void write_picture(Outputs& outputs, const std::string& name, const Image<std::uint32_t>& image) {
    if (image.empty()) return;
    const std::vector<unsigned char> png = io::encode_png(name, image);
    outputs.write(name, [&](const std::string& path) {
        io::write_file(path, {{reinterpret_cast<const char*>(png.data()), png.size()}});
    });
}

// Stages of one id are told apart by their numbers.
void write_pictures(const ValidationReport& report, Outputs& outputs) {
    std::vector<std::string> taken;
    for (const StageReport& stage : report.stages) {
        std::string name = stage.verdict.id;
        for (int i = 2; std::find(taken.begin(), taken.end(), name) != taken.end(); ++i)
            name = fmt::format("{}-{}", stage.verdict.id, i);
        taken.push_back(name);
        write_picture(outputs, name + ".verdict.png", stage.map);
        write_picture(outputs, name + ".error.png", stage.error);
    }
    outputs.commit();
}

int run_validate(const ValidateOptions& given) {
    parity::JudgeOptions options;
    options.run = given.common.run_options();
    const io::Manifest manifest = io::read_manifest(given.manifest);
    const bool named = !given.profile.empty();
    options.profile =
        find_profile(named ? given.profile : manifest.profile, named ? "--profile" : io::shown(given.manifest));
    if (manifest.subpixel_bits > 0 && options.profile.name == "ideal")
        options.profile.subpixel_bits = manifest.subpixel_bits;
    options.max_ambiguous = given.max_ambiguous.value_or(manifest.max_ambiguous);

    require_memory("validate " + io::shown(given.manifest), bytes_to_validate(manifest, given.pictures()), memory_there(),
                   "expected smaller pictures");
    // A folder that cannot be written to is found before the work, not after it.
    std::unique_ptr<Outputs> outputs;
    if (!given.folder.empty()) outputs = std::make_unique<Outputs>(given.folder);
    ValidationReport report{manifest, options.profile.name, options.max_ambiguous, {}};
    const std::unique_ptr<TwinMutants> mutants =
        given.mutants.empty() ? nullptr : std::make_unique<TwinMutants>(given.mutants);
    const CaseReader reader(manifest, options.profile);
    for (const io::ManifestStage& stage : manifest.stages) {
        StageCase one = reader.read(stage);
        options.choices = std::move(one.choices);
        options.choices_a_pixel = one.choices_a_pixel;
        options.covered = std::move(one.covered);
        const auto guesses = [&] {
            std::vector<parity::Hypothesis> all = other_dumps(manifest, stage, *one.binding);
            if (mutants && !rsm::is_sampled(*one.binding) && !is_formed(*one.binding))
                for (parity::Hypothesis& h : mutants->of(*one.binding, one.data)) all.push_back(std::move(h));
            return all;
        };
        try {
            report.stages.push_back(report_on(one, given, options, guesses));
            StageReport& made = report.stages.back();
            made.stale = find_stale(manifest, stage, made.notes);
        } catch (const InputError& error) {
            throw InputError(stage.place + ": " + error.what());
        }
    }
    if (report.stages.empty()) throw InputError(io::shown(given.manifest), "", "names no [[stage]]");

    if (outputs) write_pictures(report, *outputs);
    if (!given.junit.empty()) io::write_text(given.junit, validation_junit(report));
    if (!given.html.empty()) io::write_text(given.html, validation_html(report));
    std::fputs((given.common.json ? json_text(validation_json(report)) : validation_text(report)).c_str(), stdout);
    return report.passed() ? success : disagreement;
}

}  // namespace

void add_validate(CLI::App& program, Action& action) {
    auto given = std::make_shared<ValidateOptions>();
    CLI::App* command =
        program.add_subcommand("validate", "judge every GPU pass by its dumped inputs and outputs");
    CLI::Option* manifest =
        command->add_option("manifest", given->manifest, "TOML or JSON that says what was dumped: io/README.md")
            ->type_name("MANIFEST");
    command->add_option("--init", given->init, "write FOLDER/manifest.toml from the names of the dumps in it")
        ->excludes(manifest)
        ->type_name("FOLDER");
    command->add_flag("--refill", given->refill, "judge nothing: fill the outputs of an export anew, before the next run\n"
                      "of a renderer, so that what it does not write is told")
        ->needs(manifest);
    command->add_option("--junit", given->junit, "also write JUnit XML, a test case a stage")
        ->check(some_word())
        ->type_name("FILE");
    command->add_option("--html", given->html, "also write a page with pictures and the values of the worst pixels")
        ->check(some_word())
        ->type_name("FILE");
    command->add_option("--profile", given->profile, "how the device rounds; the manifest's otherwise")
        ->check(some_word())
        ->type_name("P");
    command->add_option("--max-ambiguous", given->max_ambiguous,
                        "share of a stage's pixels, and of those that are not 0, that may be\n"
                        "ambiguous; the manifest's otherwise")
        ->check(number_within(0, 1))
        ->type_name("S");
    command->add_flag("--no-diagnosis", given->without_diagnosis,
                      "do not run the kernel again under guesses at what is wrong");
    command->add_option("--mutants", given->mutants,
                        "also run the twins of what is wrong with a change each, on a Vulkan device of that name or index in\n"
                        "`plumb devices`, where no other guess explains it")
        ->check(some_word())
        ->type_name("DEVICE");
    command->add_option("-o,--output", given->folder, "also write pictures of verdicts and errors")
        ->check(some_word())
        ->type_name("DIR");
    add_common(*command, given->common);
    command->footer(
        "Each stage is judged from its own dumped inputs, so that errors do not add up. A pixel is equal, within_bound\n"
        "(another rounding, within what the profile grants each operation), ambiguous (a comparison fell inside the\n"
        "bound) or wrong, as is one that was never written. Exit code 1 if any is wrong, or too many are ambiguous, or if\n"
        "there was nothing to judge, or if the inputs are not those that were exported.");
    command->callback([given, &action] {
        action = [=] {
            if (!given->init.empty()) return init_manifest(given->init, given->common.json);
            if (given->manifest.empty()) throw InputError("validate: expected MANIFEST, or --init FOLDER");
            return given->refill ? refill(given->manifest, given->common.json) : run_validate(*given);
        };
    });
}

}  // namespace plumb::cli
