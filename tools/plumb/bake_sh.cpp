#include "tools/plumb/bake_sh.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/fields.h"
#include "core/nearest_known.h"
#include "gi/probes/probe_radiance.h"
#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/shared/reports.h"

namespace plumb::cli {
namespace {

probes::ShOrder order_of(const std::string& name) {
    const std::vector<std::string> names = probes::sh_order_names();
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end())
        throw InputError(fmt::format("--sh-order {}: unknown{}", io::printable(name), nearest_known(name, names)));
    return probes::ShOrder(at - names.begin());
}

// The shortest decimal of the nearest float: what engines keep.
double number(double x) {
    const std::string text = fmt::format("{}", float(x));
    double shortest = 0;
    std::from_chars(text.data(), text.data() + text.size(), shortest);
    return shortest;
}
Json vector(const glm::dvec3& v) { return {number(v.x), number(v.y), number(v.z)}; }

Json coefficients(const probes::ShForm& form, const std::vector<glm::dvec3>& sh) {
    Json list = Json::array();
    if (!form.by_channel) {
        for (const glm::dvec3& c : sh) list.push_back(vector(c));
        return list;
    }
    for (int channel = 0; channel < 3; ++channel) {
        Json of_channel = Json::array();
        for (const glm::dvec3& c : sh) of_channel.push_back(number(c[channel]));
        list.push_back(of_channel);
    }
    return list;
}

}  // namespace

void add_sh_options(CLI::App& command, ShOptions& options) {
    command.add_option("--export-sh", options.file, "what probes see in the scene's light, as JSON for an engine")
        ->check(some_word())
        ->type_name("FILE");
    command.add_option("--sh-order", options.order, "the engine's coefficients: unity, unreal, threejs, l1, geomerics")
        ->check(some_word())
        ->type_name("NAME");
}

void check_sh(const ShOptions& options, bool part) {
    if (options.file.empty() && options.order.empty()) return;
    if (options.file.empty()) throw InputError("bake: --sh-order is of --export-sh FILE");
    if (options.order.empty()) throw InputError("bake: --export-sh: expected --sh-order as well: unity, unreal, threejs, l1 or geomerics");
    order_of(options.order);
    if (part) throw InputError("bake: --export-sh is for a whole bake, not for a part");
}

void check_sh_degree(const ShOptions& options, int degree) {
    if (!options.file.empty() && degree < 2)
        throw InputError(fmt::format("bake: --export-sh: probes.degree = {}: the coefficients of engines are of degree 2; expected 2 to 7",
                                     degree));
}

void write_sh(const ShOptions& options, const probes::Bake& bake, const Scene& scene, const RunOptions& run) {
    if (options.file.empty()) return;
    const probes::ShOrder order = order_of(options.order);
    const probes::ShForm& form = probes::sh_form(order);
    const probes::ProbeRadiance seen = probes::probe_radiance(bake, scene, run);
    Json list = Json::array();
    for (std::size_t p = 0; p < seen.position.size(); ++p)
        list.push_back({{"position", vector(probes::exported_position(order, seen.position[p]))},
                        {"sh", coefficients(form, probes::exported_sh(order, seen.radiance[p]))}});
    const Json json = {{"version", 1},
                       {"order", form.name},
                       {"scene", scene.name},
                       {"axes", form.axes},
                       {"quantity", form.quantity},
                       {"evaluation", form.evaluation},
                       {"polynomials", form.basis},
                       {"layout", form.by_channel ? "sh[channel][coefficient]" : "sh[coefficient][channel]"},
                       {"rounds", seen.rounds},
                       {"probes", list}};
    io::write_text(options.file, json_text(json));
}

}  // namespace plumb::cli
