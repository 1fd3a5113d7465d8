// plumb experiment isr --pairing pov as numbers, text and a page.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/compare_pictures.h"
#include "tools/experiments/isr.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"
#include "tools/shared/sweep.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using Optional = std::optional<double>;

Optional mean_of(const std::vector<double>& values) {
    if (values.empty()) return std::nullopt;
    double sum = 0;
    for (const double v : values) sum += v;
    return std::isfinite(sum) ? Optional(sum / double(values.size())) : std::nullopt;
}

struct Quantity {
    const char* name;
    const char* unit;
    Optional thesis;
};
// Of figures 5.8 to 5.10 and 5.3.2, the thesis' figures beside them.
const std::vector<Quantity>& quantities() {
    static const std::vector<Quantity> all = {{"gain, mean", "%", 5.88},        {"gain, median", "%", 7.18},
                                              {"gain, least", "%", 0.21},       {"gain, largest", "%", 14.69},
                                              {"views better", "%", 100.0},     {"views not worse", "%", {}},
                                              {"pixels better", "%", 99.05},    {"pixels not worse", "%", {}},
                                              {"mean error of DL", "", {}},     {"mean error of ISR", "", {}},
                                              {"correlation of DL", "", 0.8867}, {"correlation of ISR", "", 0.8870}};
    return all;
}

std::vector<Optional> values_of(const std::vector<const IsrPair*>& pairs) {
    std::vector<double> gains, better, not_worse, direct, isr, direct_pearson, isr_pearson;
    double positive = 0, no_worse = 0;
    for (const IsrPair* p : pairs) {
        gains.push_back(100 * compare::gain(p->direct_error, p->isr_error).value_or(0));
        positive += p->isr_error < p->direct_error, no_worse += p->isr_error <= p->direct_error;
        better.push_back(100 * p->better), not_worse.push_back(100 * (1 - p->worse));
        direct.push_back(p->direct_error), isr.push_back(p->isr_error);
        if (!p->direct_pearson || !p->isr_pearson) continue;
        direct_pearson.push_back(*p->direct_pearson), isr_pearson.push_back(*p->isr_pearson);
    }
    const double n = double(pairs.size());
    return {mean_of(gains),  quantile(gains, 0.5), quantile(gains, 0), quantile(gains, 1),
            100 * positive / n, 100 * no_worse / n,  mean_of(better),    mean_of(not_worse),
            mean_of(direct), mean_of(isr),         mean_of(direct_pearson), mean_of(isr_pearson)};
}

std::vector<const IsrPairing*> made(const std::vector<IsrPairing>& pairings) {
    std::vector<const IsrPairing*> all;
    for (const IsrPairing& p : pairings)
        if (p.failed.empty()) all.push_back(&p);
    return all;
}

std::string coverage(const std::vector<IsrPairing>& pairings, std::size_t of) {
    double seconds = 0;
    const std::vector<const IsrPairing*> all = made(pairings);
    for (const IsrPairing* p : all) seconds += p->pov_s;
    return fmt::format("{} of the lists' {} views; POV-Ray took {:.0f} s for table 1's pictures", all.size(), of, seconds);
}

}  // namespace

std::vector<VrsmNumber> isr_pairing_numbers(const std::vector<IsrPairing>& pairings) {
    std::vector<VrsmNumber> numbers;
    const std::vector<const IsrPairing*> all = made(pairings);
    if (all.empty()) return numbers;
    for (std::size_t i = 0; i < all.front()->pairs.size(); ++i) {
        std::vector<const IsrPair*> pairs;
        for (const IsrPairing* p : all) pairs.push_back(&p->pairs.at(i));
        const IsrPair& of = *pairs.front();
        const std::vector<Optional> values = values_of(pairs);
        for (std::size_t q = 0; q < quantities().size(); ++q)
            numbers.push_back({"pairing", of.model + ", " + of.display, of.setting, quantities()[q].name, quantities()[q].unit,
                               values[q], quantities()[q].thesis});
    }
    for (const IsrPairing* view : all)
        for (const IsrPair& p : view->pairs)
            numbers.push_back({"pairing of a view", view->name, p.setting, p.model + ", " + p.display + ": gain", "%",
                               100 * compare::gain(p.direct_error, p.isr_error).value_or(0), {}});
    return numbers;
}

Json isr_pairing_json(const IsrResult& result, const std::vector<IsrPairing>& pairings, std::size_t of,
                      const std::vector<VrsmNumber>& numbers) {
    Json rows = Json::array(), refused = Json::array(), readings = Json::array();
    for (const VrsmNumber& n : numbers) {
        Json row = {{"table", n.table},       {"scene", n.scene}, {"row", n.row},
                    {"quantity", n.quantity}, {"unit", n.unit},   {"value", n.value ? Json(*n.value) : Json(nullptr)}};
        if (n.thesis) row["thesis"] = *n.thesis;
        rows.push_back(row);
    }
    for (const IsrPairing& p : pairings)
        if (!p.failed.empty()) refused.push_back({{"view", p.name}, {"reason", p.failed}});
    for (const IsrReading& r : isr_readings()) readings.push_back({{"name", r.name}, {"settings", r.sets}, {"tries", r.why}});
    const IsrRequest& r = result.request;
    return {{"lists", r.lists},     {"size", {r.size.x, r.size.y}}, {"samples", r.samples},
            {"views", made(pairings).size()}, {"views_of_the_lists", of}, {"readings", readings},
            {"left_out", refused},  {"numbers", rows}};
}

std::string isr_pairing_text(const std::vector<IsrPairing>& pairings, std::size_t of, const std::vector<VrsmNumber>& numbers) {
    std::vector<Column> columns{{"model and display"}, {"setting"}};
    for (const Quantity& q : quantities()) columns.push_back({q.name, Align::right});
    std::vector<std::vector<std::string>> cells;
    std::vector<std::string> thesis{"ISR, as it states", ""};
    for (const Quantity& q : quantities()) thesis.push_back(q.thesis ? fmt::format("{:g}", *q.thesis) : "");
    cells.push_back(thesis);
    for (const VrsmNumber& n : numbers) {
        if (n.table != "pairing") continue;
        if (n.quantity == quantities().front().name) cells.push_back({n.scene, n.row});
        cells.back().push_back(isr_value_text(n));
    }
    std::string text = coverage(pairings, of) + "\n" + format_table(columns, cells);
    for (const IsrPairing& p : pairings)
        if (!p.failed.empty()) text += fmt::format("left out: {}: {}\n", p.name, p.failed);
    return text;
}

std::string isr_pairing_html(const IsrResult& result, const std::vector<IsrPairing>& pairings, std::size_t of,
                             const std::vector<VrsmNumber>& numbers, const std::string& command) {
    using page::Cell;
    page::Page page("Printed ISR against POV-Ray: plumb experiment isr --pairing pov");
    const IsrRequest& request = result.request;
    page.paragraph(fmt::format(
        "Rohleder 2010, 5.3.2, states a mean gain of 5.88 %, a median of 7.18 %, gain in every view and 99.05 % of the pixels closer to "
        "POV-Ray's picture. Here: {}, {} x {} pixels.", coverage(pairings, of), request.size.x, request.size.y));
    page.paragraph(
        "Each row is a reading of what the thesis leaves open, held against the same models: POV-Ray with table 1's preset, the same with "
        "brightness 1, and the path tracer with one bounce and with all. Displays: sRGB-encoded, the same in bytes, and bytes that are not "
        "encoded. A view or a pixel that is neither better nor worse is a tie: not worse counts it, better does not. Exposures are the model's own: "
        "its logarithmic mean is a middle grey. Gains depend on the size of the pictures, since what printed ISR reaches is a number of pixels.");
    page.heading("Readings", "readings");
    std::vector<std::vector<Cell>> rows{{{"reading"}, {"settings"}, {"what it tries"}}};
    for (const IsrReading& r : isr_readings()) rows.push_back({{r.name}, {fmt::format("{}", fmt::join(r.sets, " "))}, {r.why}});
    page.table(rows);
    page.heading("Gains", "gains");
    std::string model;
    rows.clear();
    const auto flush = [&] {
        if (!rows.empty()) page.table(rows, model);
        rows.clear();
    };
    for (const VrsmNumber& n : numbers) {
        if (n.table != "pairing") continue;
        if (n.scene != model) {
            flush(), model = n.scene;
            std::vector<Cell> head{{"setting"}}, stated{{"ISR, as it states"}};
            for (const Quantity& q : quantities()) {
                head.push_back({q.name + std::string(*q.unit ? ", " : "") + q.unit, true});
                stated.push_back({q.thesis ? fmt::format("{:g}", *q.thesis) : "", true});
            }
            rows = {head, stated};
        }
        if (n.quantity == quantities().front().name) rows.push_back({{n.row}});
        rows.back().push_back({isr_value_text(n), true});
    }
    flush();
    for (const IsrPairing& p : pairings)
        if (!p.failed.empty()) page.paragraph(fmt::format("Left out: {}: {}", p.name, p.failed));
    page.heading("How it was measured", "how");
    page.raw(fmt::format("<p><code>{}</code></p>\n", page::escaped(command)));
    return page.html();
}

}  // namespace plumb::cli
