#include "tools/shared/radiosity_report.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "gi/radiosity/kept_rows.h"
#include "io/file.h"

namespace plumb::cli {

namespace {

constexpr std::uint64_t most_of_rows = std::uint64_t(16) << 30;  // bytes in the cache
constexpr std::size_t most_points = 256;                         // of a convergence curve

// JSON has no infinity.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json curve_json(const std::vector<radiosity::CurvePoint>& curve) {
    Json points = Json::array();
    const std::size_t n = curve.size(), some = std::min(n, most_points);
    for (std::size_t k = 0; k < some; ++k) {
        const radiosity::CurvePoint& p = curve[some == n ? k : k * (n - 1) / (some - 1)];
        points.push_back({{"products", p.products}, {"residual", number(p.residual)}, {"step", number(p.step)}, {"error", number(p.error)},
                          {"power", number(p.power)}});
    }
    return points;
}

Json solution_json(const radiosity::Solved& solved) {
    const radiosity::Solution& s = solved.solution;
    return {{"solver", solver_name(solved.solver)},
            {"reason", solved.reason},
            {"products", s.products},
            {"radius", {{"value", s.radius.value}, {"low", s.radius.low}, {"high", s.radius.high}, {"products", s.radius.products}, {"settled", s.radius.settled}}},
            {"residual", number(s.residual)},
            {"row_residual", number(s.row_residual)},
            {"error", number(s.error)},
            {"tolerance", double(solved.tolerance)},
            {"converged", s.converged},
            {"why", s.why},
            {"curve", curve_json(s.curve)}};
}

Json audit_json(const radiosity::Audit& a) {
    return {{"emitted", a.emitted},
            {"incident", a.incident},
            {"absorbed", a.absorbed},
            {"escaped", a.escaped},
            {"not_arrived", a.not_arrived},
            {"not_reciprocal", a.not_reciprocal},
            {"unsolved", a.unsolved},
            {"unbalanced", a.unbalanced},
            {"row_sums", {{"least", a.least_row}, {"mean", a.mean_row}, {"largest", a.largest_row}, {"largest_at", a.largest_row_at}, {"of_nothing", a.rows_of_nothing}}},
            {"reciprocity", {{"defect_rms", a.defect_rms}, {"exchange_rms", a.exchange_rms}, {"defect_worst", a.defect_worst}, {"worst_i", a.worst_i},
                             {"worst_j", a.worst_j}, {"pairs", a.pairs}, {"all_pairs", a.all_pairs}}},
            {"gather_off", a.gather_off}};
}

}  // namespace

std::unique_ptr<FileStore> row_files(const frame::Settings& settings, bool no_cache) {
    const std::string folder = no_cache || settings.method != frame::Method::radiosity ? "" : cache_folder();
    if (folder.empty()) return nullptr;
    auto files = std::make_unique<FileStore>(folder, "rows", FileStore::Limits{.max_bytes = most_of_rows, .made = "computed"});
    files->pin();
    return files;
}

// ---- Before ---------------------------------------------------------------------------------------------------------

RadiosityPlan plan_radiosity(const Scene& scene, const frame::Settings& settings, const RunOptions& options) {
    const radiosity::RadiosityParams& p = settings.radiosity;
    RadiosityPlan plan;
    plan.memory = std::uint64_t(p.memory_mb) * 1'000'000;
    try {
        const radiosity::Elements elements = radiosity::elements_of(scene, radiosity::element_params(p), options);
        plan.elements = elements.count(), plan.triangles = int(elements.of.size());
        plan.rows = radiosity::plan_rows(plan.elements, p.size, plan.memory, !cache_folder().empty());
        plan.row_seconds = radiosity::row_seconds(plan.elements, elements.of.size(), p.size);
        plan.solver = radiosity::solver_for(elements, p);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", io::shown(scene.name), error.what()));
    }
    return plan;
}

Json radiosity_plan_json(const RadiosityPlan& plan) {
    return {{"elements", plan.elements},
            {"triangles", plan.triangles},
            {"mesh_seconds", plan.mesh_seconds},
            {"rows", {{"expected_bytes", plan.rows.expected}, {"most_bytes", plan.rows.most}, {"memory_bytes", plan.memory}, {"in_memory", plan.rows.fits}, {"seconds", plan.row_seconds}}},
            {"solver", solver_name(plan.solver.solver)},
            {"reason", plan.solver.reason},
            {"products", number(plan.solver.products)},
            {"seconds", number(plan.solver.seconds)}};
}

std::string radiosity_plan_text(const RadiosityPlan& plan) {
    return fmt::format("\nradiosity: {} elements of {} triangles, split, cut and refined in {:.2g} s, which a frame takes again; form factors of about {:.1f} MB, {:.1f} at most{}; where they are not kept, {:.2g} s on one core\nsolver {}: {}\n", plan.elements,
                       plan.triangles, plan.mesh_seconds, 1e-6 * double(plan.rows.expected), 1e-6 * double(plan.rows.most),
                       plan.rows.fits ? "" : fmt::format(": what is beyond memory_mb, {:.1f}, is read from disk for each product", 1e-6 * double(plan.memory)),
                       plan.row_seconds,
                       solver_name(plan.solver.solver), plan.solver.reason);
}

// ---- Afterwards -----------------------------------------------------------------------------------------------------

Json radiosity_json(const frame::Frame& frame, const frame::Settings& settings, const RunOptions& options, const FileStore* rows) {
    const frame::RadiosityBuffers& b = frame.radiosity;
    if (b.elements.count() == 0 || b.radiosity.empty()) return nullptr;
    Json json = {{"elements", b.elements.count()},
                 {"triangles", b.elements.of.size()},
                 {"offset_m", b.elements.offset_m},
                 {"nearer", b.elements.nearer},
                 {"without_normal", b.elements.without_normal},
                 {"rows", {{"bytes", b.factors.all_bytes()}, {"in_memory_bytes", b.factors.bytes()}, {"files", b.factors.block_count()}, {"found", b.rows_found}}}};
    json["solution"] = solution_json(b.solved);
    if (settings.radiosity.audit) json["energy"] = audit_json(radiosity::audit_of(b.solved, b.factors, b.elements, b.lamps, b.sky, b.emitters, options));
    if (rows && !rows->notes().empty()) json["notes"] = rows->notes();
    return json;
}

std::string radiosity_text(const Json& json) {
    if (json.is_null()) return "";
    const Json& s = json["solution"];
    std::string text = fmt::format("solved by {}: {}\n", s["solver"].get<std::string>(), s["reason"].get<std::string>());
    if (json.contains("energy")) {
        const Json& e = json["energy"];
        const auto watts = [&](const char* name) { return e[name].get<double>(); };
        text += fmt::format("energy: {:.6g} W emitted and {:.6g} W incident = {:.6g} W absorbed + {:.6g} W escaped + {:.3g} W of small emitters "
                            "not arrived + {:.3g} W by rows that are not reciprocal + {:.3g} W unsolved\n",
                            watts("emitted"), watts("incident"), watts("absorbed"), watts("escaped"), watts("not_arrived"), watts("not_reciprocal"), watts("unsolved"));
        text += fmt::format("rows sum to {:.6g} to {:.6g}, {:.6g} in the mean; A_i F_ij and A_j F_ji differ by {:.2g} of what is exchanged (rms of {} pairs)\n",
                            e["row_sums"]["least"].get<double>(), e["row_sums"]["largest"].get<double>(), e["row_sums"]["mean"].get<double>(),
                            e["reciprocity"]["exchange_rms"].get<double>() > 0
                                ? e["reciprocity"]["defect_rms"].get<double>() / e["reciprocity"]["exchange_rms"].get<double>() : 0.0,
                            e["reciprocity"]["pairs"].get<std::int64_t>());
    }
    return text;
}

}  // namespace plumb::cli
