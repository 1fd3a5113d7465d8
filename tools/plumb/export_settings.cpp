#include "tools/plumb/export_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gi/frame/frame_graph.h"
#include "tools/plumb/case_pattern.h"

namespace plumb::cli {

namespace {

// A parameter that two settings differ in, as the command line names it.
struct Difference {
    std::string name, asked, running;
};

std::vector<Difference> differences(frame::Settings asked, frame::Settings running) {
    std::vector<Difference> all;
    if (asked.method != running.method)
        all.push_back({"render.method", frame::method_name(asked.method), frame::method_name(running.method)});
    for (const std::string& table : frame::method_tables()) {
        const std::vector<Field> a = frame::table_fields(asked, table, table), b = frame::table_fields(running, table, table);
        for (std::size_t i = 0; i < a.size(); ++i)
            if (value_text(a[i]) != value_text(b[i])) all.push_back({table + "." + a[i].name, value_text(a[i]), value_text(b[i])});
    }
    return all;
}

// The words of the command line that set it; "" where it is the scene's.
std::string said(const SceneOptions& given, const std::string& name) {
    if (name == "render.method" && !given.method.empty()) return "--method " + given.method;
    for (const std::string& text : given.sets) {
        const Assignment a = parse_assignment(text);
        if (a.table + "." + a.key == name) return "--set " + text;
    }
    return "";
}

std::vector<std::string> stages_of(const frame::Settings& settings) {
    Scene scene;
    scene.lights.resize(1);
    const frame::FrameGraph graph(scene, settings, Geometry{});
    std::vector<std::string> names;
    for (const frame::PlannedNode& node : graph.nodes())
        if (node.listed && std::find(names.begin(), names.end(), node.plan.name) == names.end()) names.push_back(node.plan.name);
    return names;
}

// "; with it rsm.disc_continuous runs": what runs as asked and not where `stage` does.
std::string instead(const frame::Settings& asked, const frame::Settings& running) {
    const std::vector<std::string> others = stages_of(running);
    std::vector<std::string> names = stages_of(asked);
    std::erase_if(names, [&](const std::string& name) { return std::count(others.begin(), others.end(), name) > 0; });
    if (names.empty()) return "";
    return fmt::format("; with it {} {}", fmt::join(names, ", "), names.size() == 1 ? "runs" : "run");
}

}  // namespace

std::vector<std::string> replaced_settings(const frame::Settings& asked, const frame::Settings& running,
                                           const std::string& stage, const SceneOptions& given) {
    std::vector<std::string> notes;
    for (const Difference& d : differences(asked, running)) {
        if (const std::string words = said(given, d.name); !words.empty())
            throw InputError(fmt::format("--stage {}: runs with {} = {}, not with {}{}", stage, d.name, d.running, words,
                                         instead(asked, running)));
        notes.push_back(fmt::format("{}: runs with {} = {}, in place of the scene's {}", stage, d.name, d.running, d.asked));
    }
    return notes;
}

void require_whole_rows(const frame::Settings& settings) {
    const rsm::GatherParams& rsm = settings.rsm;
    if (settings.method != frame::Method::rsm || !rsm.own || rsm.texels != rsm::Texels::whole || rsm.gather == rsm::Gather::all) return;
    for (std::size_t k = 0; k < rsm.own->rows.size(); ++k)
        for (const double d : {rsm.own->rows[k].x, rsm.own->rows[k].y})
            if (d != std::floor(d))
                throw InputError(texels_fault(rsm.own->path, k, d, true));
}

}  // namespace plumb::cli
