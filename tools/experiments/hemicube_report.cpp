// plumb experiment hemicube: text, JSON, CSV and page of what was measured.
#include <fmt/format.h>

#include "core/parallel.h"
#include "tools/experiments/hemicube.h"
#include "tools/page/markup.h"

namespace plumb::cli {

namespace {

std::string where(const Hemicube& r) { return fmt::format("{}, {} threads, {}; load of the machine before: {:.1f}", r.processor, r.threads, r.isa, r.load); }

}  // namespace

std::vector<std::string> hemicube_guesses() {
    return {
        "The box: the text gives its vertices and triangles alone. Five walls of (n + 1)^2 vertices and a ceiling of (n + 3)^2, cut by its lamp's lines, have them for n = 10, "
        "20, 40 and 50. Its side (2 m), reflectances (0.75; red, green) and the lamp's size (0.4 m) are ours.",
        "The lamp's colour (100.4, 96.8, 90.0) is plate C.10's; that C.9 has it, too, is a guess.",
        "Plate C.10: sizes and places of the sphere and the torus, and their meshes: 2,742 vertices, as 203 s and 58 s suggest if C.9 has 774 and a vertex takes as long in both.",
        "Hemicube and passes of plates C.9 and C.10: the benchmark's first test has 64 and 10.",
        "Plates C.1 to C.8: the models that appendix B loads; camera, lamp and highlights are ours (appendix B's lamp shines straight down).",
        "By what the sums of texels are divided is not said: ours by the maps' sum, so that a closed room keeps its energy.",
        "The thesis' figures 5.5 to 5.7 are curves whose numbers the text does not give: they stand beside ours as what it says of them.",
    };
}

std::string hemicube_text(const Hemicube& result) {
    std::string text = where(result) + "\n";
    for (const IprSheet& sheet : result.sheets) text += sheet_text(sheet);
    text += "\nGuesses\n";
    for (const std::string& line : hemicube_guesses()) text += "- " + line + "\n";
    return text;
}

page::Json hemicube_json(const Hemicube& result) {
    page::Json sheets = page::Json::array();
    for (const IprSheet& sheet : result.sheets) sheets.push_back(sheet_json(sheet));
    return {{"version", 1}, {"processor", result.processor}, {"isa", result.isa}, {"threads", result.threads}, {"sheets", sheets}, {"guesses", hemicube_guesses()}};
}

std::string hemicube_csv(const Hemicube& result) {
    std::string text = "scene,table,setting,of,quantity,value\n";
    for (const IprSheet& sheet : result.sheets) text += sheet_csv("hemicube", sheet);
    return text;
}

std::string hemicube_html(const Hemicube& result, const std::string& command) {
    page::Page page("Hemicube radiosity: the thesis' experiments again");
    page.paragraph("The benchmark (5.8) and the plates (appendix C) of the thesis of hemicubes drawn by shaders, and what its choices cost. Each row has an error, which the thesis has "
                   "not: mean |error|, bias, and rms with the truth's noise taken out, of the luminance of irradiance, against path tracing, in % of its mean.");
    page.paragraph("\"Published way\" is ours, too: five faces drawn and summed for some elements, one pass, on this machine. The thesis' machines were a Pentium 4 with an X600 and "
                   "two Xeons with a Quadro FX 3000.");
    for (const IprSheet& sheet : result.sheets) show_sheet(page, "HEM", sheet);
    page.heading("Guesses");
    std::string list = "<ul>";
    for (const std::string& line : hemicube_guesses()) list += "<li>" + page::escaped(line) + "</li>";
    page.raw(list + "</ul>\n");
    page.heading("How it was measured");
    page.paragraph(where(result) + ".");
    page.raw("<p><code>" + page::escaped(command) + "</code></p>\n");
    return page.html();
}

}  // namespace plumb::cli
