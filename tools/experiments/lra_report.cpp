// plumb experiment lra: text, JSON, CSV and page of what was measured.
#include <fmt/format.h>

#include "core/parallel.h"
#include "tools/experiments/lra.h"
#include "tools/page/markup.h"
#include "tools/shared/machine_load.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

namespace {

std::string where(const Lra& r) { return fmt::format("{}, {} threads, {}; load of the machine before: {:.1f}", r.processor, r.threads, r.isa, r.load); }

std::string subject(const LraRequest& r) {
    return fmt::format("city of about {} triangles, its bounding sphere scaled to {} m; maps of {} x {}; {} samples; frames' sides divided by {}; medians of {}", r.triangles, lra_half_width, r.map, r.map,
                       r.samples, r.divide, r.repeats);
}

std::string list(const std::vector<std::string>& lines) {
    std::string text = "<ul>";
    for (const std::string& line : lines) text += "<li>" + page::escaped(line) + "</li>";
    return text + "</ul>\n";
}

}  // namespace

Lra measure_lra(const LraRequest& request, const RunOptions& options, const LraTell& tell) {
    Lra result{request, {}, processor_name(), "", thread_count(options.threads), machine_load()};
    LraWorld world(request);
    result.sheets = lra_still_tables(world, options, tell);
    for (IprSheet& sheet : lra_moving_tables(world, options, tell)) result.sheets.push_back(std::move(sheet));
    result.isa = isa_name(last_dispatched_isa());
    return result;
}

std::vector<std::string> lra_not_run() {
    std::vector<std::string> lines;
    for (const LraAlgorithm& a : lra_algorithms())
        if (a.sets.empty()) lines.push_back(fmt::format("{} has no stage in this program: rows of table 7.1 with it are not run, and \"all algorithms\" of the other tables are those without it; the thesis' numbers have it.", a.name));
    return lines;
}

std::vector<std::string> lra_guesses() {
    return {
        "The model: the thesis' is a diorama of Rome with 2 million vertices and 4 million triangles; ours, `city`, has as many, in another order, with another depth complexity.",
        "Lights' maps: the thesis' orthographic projection of +-35 m, 0.1 to 75 m, is had by scaling the model to a bounding sphere of 35 m; its spots of 90 degrees, 0.1 to 100 m, stand 50 m away. "
        "Ours fit near and far to the model; with a share of it the maps are as wide as what is drawn.",
        "Camera: 45 degrees from top to bottom, from above, as near as the whole model fits into a square; the thesis says that almost all of it is seen.",
        "Mirrors: all materials mirror a tenth, and keep nine tenths of their colour; the thesis' specular maps are not said. Rays of 64 steps of 0.1 m, by camera and lights.",
        "Which algorithms run in tables 7.2 to 7.6: all, since 100 % of table 7.2 is all of table 7.1.",
        "Targets of 16-bit floats (layout lra), 200 samples within 0.08 of a map's side, 64 samples of SSAO by camera and lights, hard shadows: radii are not said.",
        "The thesis measures frames a second of a GeForce RTX 2060 SUPER, waiting for a display of 60; ours are milliseconds of stages on processor cores. What can be compared is how they grow.",
        "\"Lights at rest\" are a frame's stages but its maps, which are kept (LRA 6.2.2); the camera's are drawn anew, as the thesis does.",
        "Processor time: of all threads, a whole frame with all of its maps; other programs on the machine delay it least.",
        "Fragments: of the camera, all triangles, two-sided, without alpha masks; \"that pass\": the depth test in file order, as they are drawn.",
    };
}

std::string lra_text(const Lra& result) {
    std::string text = where(result) + "\n" + subject(result.request) + "\n";
    for (const std::string& line : lra_not_run()) text += line + "\n";
    for (const IprSheet& sheet : result.sheets) text += sheet_text(sheet);
    text += "\nGuesses\n";
    for (const std::string& line : lra_guesses()) text += "- " + line + "\n";
    return text;
}

page::Json lra_json(const Lra& result) {
    page::Json sheets = page::Json::array();
    for (const IprSheet& sheet : result.sheets) sheets.push_back(sheet_json(sheet));
    const LraRequest& r = result.request;
    return {{"version", 1}, {"processor", result.processor}, {"isa", result.isa}, {"threads", result.threads}, {"load_before", result.load}, {"triangles", r.triangles}, {"map", r.map},
            {"samples", r.samples}, {"divide", r.divide}, {"repeats", r.repeats}, {"not_run", lra_not_run()}, {"sheets", sheets}, {"guesses", lra_guesses()}};
}

std::string lra_csv(const Lra& result) {
    std::string text = "scene,table,setting,of,quantity,value\n";
    for (const IprSheet& sheet : result.sheets) text += sheet_csv("city", sheet);
    return text;
}

std::string lra_html(const Lra& result, const std::string& command) {
    page::Page page("Screen and light space: the thesis' tables again");
    page.paragraph("Tables 7.1 to 7.6 of Haragas 2023 (LRA) on a city of as many triangles, and what the thesis calls surprising, by counting: covered pixels, fragments with and without a depth test, samples, "
                   "texels and maps.");
    page.paragraph(subject(result.request) + ".");
    for (const std::string& line : lra_not_run()) page.paragraph(line);
    for (const IprSheet& sheet : result.sheets) show_sheet(page, "LRA", sheet);
    page.heading("Guesses");
    page.raw(list(lra_guesses()));
    page.heading("How it was measured");
    page.paragraph(where(result) + ". All rows of a table in turns, each from new memory; the second frame of a turn counts.");
    page.raw("<p><code>" + page::escaped(command) + "</code></p>\n");
    return page.html();
}

}  // namespace plumb::cli
