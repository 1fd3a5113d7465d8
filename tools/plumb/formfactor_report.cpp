#include "tools/plumb/formfactor_report.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/shared/table.h"

namespace plumb::cli {
namespace {

using radiosity::RayFactor;

constexpr double most_sigmas = 5;  // of 32 batches: one run in 50,000 lies beyond

// Where no ray or every ray met B there is no deviation to measure by: one ray stands for it.
double ray_error(const FormFactorReport& r, const RayFactor& f) {
    return std::fmax(f.standard_error, 1 / double(r.ray_count));
}

std::string percent(double got, double truth) {
    return truth > 0 ? fmt::format("{:+.4f} %", 100 * (got / truth - 1)) : "-";
}
std::string sigmas(const FormFactorReport& r, double value) {
    return fmt::format("{:+.2f}", (value - r.rays.value) / ray_error(r, r.rays));
}

std::string shape_line(const char* name, const Shape& shape) {
    if (shape.is_point())
        return fmt::format("{}: point, looks along {:g}, {:g}, {:g}\n", name, shape.source.normal.x,
                           shape.source.normal.y, shape.source.normal.z);
    const std::size_t faces = shape.source.faces.size();
    return fmt::format("{}: {}, {:.6g} m2{}{}\n", name, shape.words, shape.source.area(),
                       faces > 1 ? fmt::format(", {} triangles", faces) : "",
                       shape.closed ? ", closed: its fronts count" : "");
}

struct Line {
    std::string method, value, error;
    double number;
};
std::vector<Line> lines_of(const FormFactorReport& r) {
    std::vector<Line> lines;
    if (r.with_contour)
        lines.push_back({r.a->is_point() ? "Lambert's formula" : "contour integral",
                         fmt::format("{:.12f}", r.contour.value), fmt::format("{:.1e}", r.contour.error),
                         r.contour.value});
    if (!r.a->is_point())
        lines.push_back({fmt::format("Lambert's formula, {} points", r.points), fmt::format("{:.8f}", r.at_points), "",
                         r.at_points});
    for (const FormFactorReport::Row& row : r.hemicubes)
        lines.push_back({fmt::format("hemicube {}", row.size), fmt::format("{:.8f}", row.value), "", row.value});
    for (const FormFactorReport::Projected& p : r.projections)
        lines.push_back({fmt::format("{} {}, {:g} deg", p.name, p.size, r.view_deg), fmt::format("{:.8f}", p.value), "", p.value});
    lines.push_back({fmt::format("rays, {}", r.ray_count), fmt::format("{:.8f}", r.rays.value),
                     fmt::format("{:.1e}", r.rays.standard_error), r.rays.value});
    return lines;
}

double contour_product(const FormFactorReport& r) { return r.a->source.area() * r.contour.value; }
double contour_product_back(const FormFactorReport& r) { return r.b->source.area() * r.contour_back.value; }

// Between A_A F_AB and A_B F_BA.
double reciprocity_sigmas(const FormFactorReport& r) {
    const double a = r.a->source.area(), b = r.b->source.area();
    const double ea = a * ray_error(r, r.rays), eb = b * ray_error(r, r.rays_back);
    return (a * r.rays.value - b * r.rays_back.value) / std::sqrt(ea * ea + eb * eb);
}

std::string reciprocity_text(const FormFactorReport& r) {
    const double a = r.a->source.area(), b = r.b->source.area();
    std::string text = "reciprocity, A_A F_AB against A_B F_BA, m2\n";
    if (r.with_contour)
        text += fmt::format("  contour  {:.12g}  {:.12g}\n", contour_product(r), contour_product_back(r));
    return text + fmt::format("  rays     {:.6g}  {:.6g}: {:+.2f} standard errors apart\n", a * r.rays.value,
                              b * r.rays_back.value, reciprocity_sigmas(r));
}

}  // namespace

void judge(FormFactorReport& r) {
    const radiosity::Between& between = r.between;
    const double hidden = between.segments > 0 ? 100.0 * between.hidden / between.segments : 0;
    r.contour_holds = r.with_contour && between.hidden == 0;
    r.sigmas = (r.rays.value - r.contour.value) / ray_error(r, r.rays);
    if (!r.with_contour) {
        r.verdict = fmt::format("no contour integral: {} pairs of faces are more than 4096; rays count", r.pairs);
    } else if (between.hidden > 0) {
        r.verdict = fmt::format(
            "the contour integral is not valid: {}{}{} hide {:.1f} % of the {} segments between A and B; rays count",
            between.occluders > 0 ? fmt::format("{} occluding triangles", between.occluders) : "",
            between.occluders > 0 && between.own > 0 ? " and " : "",
            between.own > 0 ? fmt::format("{} triangles of A and B themselves", between.own) : "", hidden,
            between.segments);
    } else if (r.contour.value == 0 && r.rays.value == 0) {
        r.verdict = "A sees nothing of B";
    } else {
        r.agrees = std::fabs(r.rays.value - r.contour.value) <= most_sigmas * ray_error(r, r.rays) + r.contour.error;
        r.verdict = fmt::format(
            "nothing hides A from B: the contour integral is valid, and rays {} with it: {:+.2f} standard errors",
            r.agrees ? "agree" : "do not agree", r.sigmas);
    }
}

std::string form_factor_text(const FormFactorReport& r) {
    std::vector<std::vector<std::string>> rows;
    for (const Line& line : lines_of(r))
        rows.push_back({line.method, line.value, line.error,
                        r.with_contour ? percent(line.number, r.contour.value) : "-", sigmas(r, line.number)});
    std::string text = shape_line("A", *r.a) + shape_line("B", *r.b) + "\n";
    text += format_table({{"F from A to B"},
                          {"value", Align::right},
                          {"standard error", Align::right},
                          {"from the contour", Align::right},
                          {"from rays, in theirs", Align::right}},
                         rows);
    text += fmt::format("\nhemicubes: mean over {} point{} of A, {} weights\n", r.points, r.points == 1 ? "" : "s",
                        r.weights);
    if (!r.a->is_point()) text += reciprocity_text(r);
    return text + "\n" + r.verdict + "\n";
}

std::string form_factor_csv(const FormFactorReport& r) {
    std::string text = "method,size,points,rays,value,standard_error,sigmas_from_rays\n";
    auto add = [&](const std::string& method, int size, int points, std::int64_t rays, double value, double error) {
        text += fmt::format("{},{},{},{},{},{},{}\n", method, size, points, rays, value, error,
                            (value - r.rays.value) / ray_error(r, r.rays));
    };
    if (r.with_contour) add("contour", 0, 0, 0, r.contour.value, r.contour.error);
    add("lambert", 0, r.points, 0, r.at_points, 0);
    for (const FormFactorReport::Row& row : r.hemicubes) add("hemicubes", row.size, r.points, 0, row.value, 0);
    for (const FormFactorReport::Projected& p : r.projections) add(p.name, p.size, r.points, 0, p.value, 0);
    add("rays", 0, 0, r.ray_count, r.rays.value, r.rays.standard_error);
    return text;
}

Json form_factor_json(const FormFactorReport& r) {
    auto shape = [](const Shape& s) {
        return Json{
            {"shape", s.words}, {"area_m2", s.source.area()}, {"faces", s.source.faces.size()}, {"closed", s.closed}};
    };
    Json json{{"a", shape(*r.a)}, {"b", shape(*r.b)}};
    json["contour"] = r.with_contour
                          ? Json{{"value", r.contour.value}, {"error", r.contour.error}, {"valid", r.contour_holds}}
                          : Json();
    json["points"] = {{"count", r.points}, {"value", r.at_points}};
    json["hemicubes"] = Json::array();
    for (const FormFactorReport::Row& row : r.hemicubes)
        json["hemicubes"].push_back({{"size", row.size},
                                     {"weights", r.weights},
                                     {"value", row.value},
                                     {"sigmas_from_rays", (row.value - r.rays.value) / ray_error(r, r.rays)}});
    for (const FormFactorReport::Projected& p : r.projections)
        json["projections"].push_back({{"projection", p.name},
                                       {"size", p.size},
                                       {"view_deg", r.view_deg},
                                       {"value", p.value},
                                       {"sigmas_from_rays", (p.value - r.rays.value) / ray_error(r, r.rays)}});
    json["rays"] = {{"count", r.ray_count},
                    {"batches", r.batches},
                    {"value", r.rays.value},
                    {"standard_error", r.rays.standard_error}};
    if (r.with_contour) json["rays"]["sigmas_from_contour"] = r.sigmas;
    json["reciprocity"] = Json();
    if (!r.a->is_point()) {
        Json& both = json["reciprocity"];
        if (r.with_contour) both["contour_m2"] = {contour_product(r), contour_product_back(r)};
        both["rays_m2"] = {r.a->source.area() * r.rays.value, r.b->source.area() * r.rays_back.value};
        both["sigmas"] = reciprocity_sigmas(r);
    }
    json["between"] = {{"segments", r.between.segments},
                       {"hidden", r.between.hidden},
                       {"occluders", r.between.occluders},
                       {"own", r.between.own}};
    json["agrees"] = r.agrees;
    json["verdict"] = r.verdict;
    return json;
}

// ---- How hemicubes err as they turn -------------------------------------------------------------------------------

std::string rotations_text(const std::vector<RotationRow>& rows) {
    std::vector<std::vector<std::string>> cells;
    for (const RotationRow& r : rows)
        cells.push_back({std::to_string(r.size), fmt::format("{:.4f}", r.exact.rms),
                         fmt::format("{:.4f}", r.exact.largest), fmt::format("{:.4f}", r.centre.rms),
                         fmt::format("{:.4f}", r.centre.largest)});
    return "Error, %, from a patch to an opposed unit square at distance 1 (0.239456470460774), turned by 0, 1 .. 90 "
           "degrees\n\n" +
           format_table({{"texels", Align::right},
                         {"exact: rms", Align::right},
                         {"largest", Align::right},
                         {"centre: rms", Align::right},
                         {"largest", Align::right}},
                        cells);
}
std::string rotations_csv(const std::vector<RotationRow>& rows) {
    std::string text = "size,exact_rms_percent,exact_largest_percent,centre_rms_percent,centre_largest_percent\n";
    for (const RotationRow& r : rows)
        text += fmt::format("{},{},{},{},{}\n", r.size, r.exact.rms, r.exact.largest, r.centre.rms, r.centre.largest);
    return text;
}
Json rotations_json(const std::vector<RotationRow>& rows) {
    Json json = Json::array();
    for (const RotationRow& r : rows)
        json.push_back({{"size", r.size},
                        {"exact", {{"rms_percent", r.exact.rms}, {"largest_percent", r.exact.largest}}},
                        {"centre", {{"rms_percent", r.centre.rms}, {"largest_percent", r.centre.largest}}}});
    return json;
}

}  // namespace plumb::cli
