#include "tools/plumb/verdict_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/file.h"
#include "tools/plumb/diagnosis_report.h"
#include "tools/plumb/explain_samples.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using parity::StageVerdict;
using parity::Verdict;
using parity::WorstPixel;

constexpr const char* nothing_to_judge = "nothing_to_judge";

Json number_json(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : "none"; }

// Infinity: nothing is known, as of light from a sample that may lie at the point itself.
std::string bound_text(double value) { return std::isinf(value) ? "anything" : number_text(value); }

std::string worst_text(const WorstPixel& w) {
    return fmt::format("{},{} {}: expected {}, got {}, may differ by {}", w.pixel.x, w.pixel.y, component_text(w),
                       exact_text(w.expected), exact_text(w.got), bound_text(w.bound));
}

// The worst pixel of a stage on which not all is equal; else null.
const WorstPixel* worst_of(const StageVerdict& v) {
    return v.verdict == Verdict::equal || v.worst.empty() ? nullptr : &v.worst.front();
}

// The first values and the last: the way in, and where it came out.
std::vector<TapValue> ends_of(const std::vector<TapValue>& values) {
    constexpr std::size_t first = 16, last = 12;
    if (values.size() <= first + last + 1) return values;
    std::vector<TapValue> kept(values.begin(), values.begin() + first);
    kept.push_back({"...", -1, {}, fmt::format("{} more: --json and --html list all", values.size() - first - last)});
    kept.insert(kept.end(), values.end() - last, values.end());
    return kept;
}

std::string worst_table(const StageVerdict& v) {
    std::vector<std::vector<std::string>> rows;
    for (const WorstPixel& w : v.worst) {
        if (w.verdict == Verdict::equal) continue;
        rows.push_back({fmt::format("{},{}", w.pixel.x, w.pixel.y), parity::verdict_name(w.verdict), component_text(w),
                        exact_text(w.expected), exact_text(w.got), number_text(std::abs(w.got - w.expected)),
                        bound_text(w.bound)});
    }
    return format_table({{"pixel"},
                         {"verdict"},
                         {"output"},
                         {"expected", Align::right},
                         {"got", Align::right},
                         {"difference", Align::right},
                         {"allowed", Align::right}},
                        rows, 2);
}

Json worst_json(const WorstPixel& w) {
    return {{"pixel", {w.pixel.x, w.pixel.y}},
            {"verdict", parity::verdict_name(w.verdict)},
            {"output", w.output},
            {"channel", w.channel},
            {"expected", number_json(w.expected)},
            {"got", number_json(w.got)},
            {"bound", number_json(w.bound)},
            {"excess", number_json(w.excess)}};
}

using Counts = std::array<std::int64_t, parity::verdicts>;

double share_of(const Counts& counts, Verdict verdict, std::int64_t pixels) {
    return pixels > 0 ? double(counts[std::size_t(verdict)]) / double(pixels) : 0.0;
}

Json counts_json(const Counts& counts) {
    Json json;
    for (int i = 0; i < parity::verdicts; ++i) json[parity::verdict_name(Verdict(i))] = counts[std::size_t(i)];
    return json;
}

// Shares of the pixels where more than 0 is expected.
Json nonzero_json(const StageVerdict& v) {
    Json json;
    for (int i = 0; i < parity::verdicts; ++i)
        json[parity::verdict_name(Verdict(i))] = share_of(v.nonzero_count, Verdict(i), v.nonzero);
    json["pixels"] = v.nonzero;
    json["counts"] = counts_json(v.nonzero_count);
    return json;
}

Json stage_json(const StageReport& stage) {
    const StageVerdict& v = stage.verdict;
    auto share = [&](Verdict verdict) { return share_of(v.count, verdict, v.pixels); };
    Json worst_pixels = Json::array();
    for (const WorstPixel& w : v.worst)
        if (w.verdict != Verdict::equal) worst_pixels.push_back(worst_json(w));
    const WorstPixel* worst = worst_of(v);
    Json json = {{"name", v.label},
                 {"stage", v.stage},
                 {"id", v.id},
                 {"verdict", stage.decided() ? parity::verdict_name(v.verdict) : nothing_to_judge},
                 {"passed", stage.passed()},
                 {"reason", stage.reason()},
                 {"equal", share(Verdict::equal)},
                 {"within_bound", share(Verdict::within_bound)},
                 {"ambiguous", share(Verdict::ambiguous)},
                 {"wrong", share(Verdict::wrong)},
                 {"judged", v.pixels},
                 {"pixels", v.pixels},
                 {"counts", counts_json(v.count)},
                 {"nonzero", nonzero_json(v)},
                 {"unwritten", v.unwritten},
                 {"left_out", v.left_out},
                 {"stale", stage.stale},
                 {"worst", worst ? worst_json(*worst) : Json(nullptr)},
                 {"worst_pixels", worst_pixels},
                 {"notes", stage.notes},
                 {"diagnosis", diagnosis_json(stage.diagnosis)},
                 {"ms", v.ms}};
    if (!stage.explanation.empty())
        json["explain"] = explain_json({v.label, stage.explained, stage.explanation});
    return json;
}

}  // namespace

std::string StageReport::reason() const {
    return stale + (stale.empty() || verdict.reason.empty() ? "" : "; ") + verdict.reason;
}

bool ValidationReport::judged() const {
    return std::any_of(stages.begin(), stages.end(), [](const StageReport& s) { return s.decided(); });
}

bool ValidationReport::passed() const {
    return judged() && std::none_of(stages.begin(), stages.end(), [](const StageReport& s) { return s.failed(); });
}

Verdict ValidationReport::verdict() const {
    Verdict worst = Verdict::equal;
    for (const StageReport& s : stages) worst = std::max(worst, s.verdict.verdict);
    return worst;
}

const StageReport* ValidationReport::first_failed() const {
    const auto at = std::find_if(stages.begin(), stages.end(), [](const StageReport& s) { return s.failed(); });
    return at == stages.end() ? nullptr : &*at;
}

std::string verdict_text(const StageReport& stage) {
    const StageVerdict& v = stage.verdict;
    if (!stage.stale.empty()) return "stale";
    if (!stage.decided()) return "nothing to judge";
    return v.unwritten > 0 && v.unwritten == v.pixels ? "not written" : parity::verdict_name(v.verdict);
}

std::string none_judged(const ValidationReport& report) {
    const bool any = std::any_of(report.stages.begin(), report.stages.end(),
                                 [](const StageReport& s) { return s.verdict.pixels > 0; });
    const bool black = std::any_of(report.stages.begin(), report.stages.end(), [](const StageReport& s) {
        return s.verdict.reason.find("all that is expected is 0") == 0;
    });
    return any ? fmt::format("nothing to judge: all that is {} is 0", black ? "expected" : "read") : "no pixel was judged";
}

std::string profile_text(const ValidationReport& report) {
    const int bits = report.profile == "ideal" ? report.manifest.subpixel_bits : 0;
    return report.profile + (bits > 0 ? fmt::format(" with {} subpixel bits", bits) : "");
}

std::string share_text(std::int64_t count, std::int64_t of) {
    if (count == 0 || of == 0) return "0";
    if (count == of) return "100 %";
    const double percent = 100 * double(count) / double(of);
    if (percent < 0.001) return "< 0.001 %";
    if (percent > 99.999) return "> 99.999 %";
    return fmt::format("{:.3f} %", percent);
}

std::string component_text(const WorstPixel& w) {
    return w.channel < 0 || w.channel > 3 ? w.output : fmt::format("{}.{}", w.output, "xyzw"[w.channel]);
}

bool has_zeros(const StageVerdict& v) { return v.nonzero > 0 && v.nonzero < v.pixels; }

namespace {

// The shares once more, of the pixels where more than 0 is expected.
std::vector<std::string> nonzero_row(const StageVerdict& v) {
    std::vector<std::string> row = {"  where not 0", ""};
    for (std::int64_t count : v.nonzero_count) row.push_back(share_text(count, v.nonzero));
    row.insert(row.end(), {fmt::format("{}", v.nonzero), "", ""});
    return row;
}

}  // namespace

std::string validation_text(const ValidationReport& report) {
    std::vector<std::vector<std::string>> rows;
    for (const StageReport& s : report.stages) {
        const StageVerdict& v = s.verdict;
        std::vector<std::string> row = {v.label, verdict_text(s)};
        for (std::int64_t count : v.count) row.push_back(share_text(count, v.pixels));
        row.push_back(fmt::format("{}", v.pixels));
        row.push_back(milliseconds_text(v.ms));
        const WorstPixel* worst = worst_of(v);
        row.push_back(worst && v.unwritten < v.pixels ? worst_text(*worst) : "");
        rows.push_back(std::move(row));
        if (has_zeros(v)) rows.push_back(nonzero_row(v));
    }
    std::string text = fmt::format("{}, held against the profile {}\n\n",
                                   report.manifest.device.empty() ? io::shown(report.manifest.file.string())
                                                                  : io::printable(report.manifest.device, 200),
                                   profile_text(report));
    text += format_table({{"stage"},
                          {"verdict"},
                          {"equal", Align::right},
                          {"within bound", Align::right},
                          {"ambiguous", Align::right},
                          {"wrong", Align::right},
                          {"pixels", Align::right},
                          {"ms", Align::right},
                          {"worst pixel"}},
                         rows);
    for (const StageReport& s : report.stages)
        for (const std::string& note : s.notes) text += fmt::format("note: {}: {}\n", s.verdict.label, note);

    std::size_t undecided = 0;
    for (const StageReport& s : report.stages)
        if (!s.decided()) ++undecided, text += fmt::format("note: {}: {}\n", s.verdict.label, s.reason());
    if (!report.judged()) return text + "\ndisagree: " + none_judged(report) + "\n";

    // The first stage that fails is the one to look at.
    const StageReport* failed = report.first_failed();
    if (!failed) {
        const bool equal = report.verdict() == Verdict::equal;
        text += equal ? "\nagree: equal, to the bit" : "\nagree: nothing is wrong";
        return text + (undecided > 0 ? fmt::format("; nothing to judge in {} of {} stages\n", undecided,
                                                   report.stages.size())
                                     : "\n");
    }
    text += fmt::format("\nThe first stage that fails: {}\n", failed->verdict.label);
    if (failed->verdict.unwritten < failed->verdict.pixels) text += worst_table(failed->verdict);
    text += diagnosis_text(failed->diagnosis);
    if (!failed->explanation.empty())
        text += "\n" + explain_text({"explain: " + failed->verdict.label, failed->explained,
                                     ends_of(by_contribution(failed->explanation))});
    text += "\n";
    for (const StageReport& s : report.stages)
        if (s.failed()) {
            const std::string cause = cause_text(s.diagnosis);
            text += fmt::format("disagree: {}: {}{}{}\n", s.verdict.label, s.reason(), cause.empty() ? "" : "; ", cause);
        }
    return text;
}

Json validation_json(const ValidationReport& report) {
    Json stages = Json::array();
    for (const StageReport& s : report.stages) stages.push_back(stage_json(s));
    const StageReport* failed = report.first_failed();
    return {{"verdict", report.judged() ? parity::verdict_name(report.verdict()) : nothing_to_judge},
            {"passed", report.passed()},
            {"reason", report.judged() ? "" : none_judged(report)},
            {"manifest", report.manifest.file.string()},
            {"device", report.manifest.device},
            {"profile", report.profile},
            {"subpixel_bits", report.profile == "ideal" && report.manifest.subpixel_bits > 0
                                  ? Json(report.manifest.subpixel_bits)
                                  : Json(nullptr)},
            {"max_ambiguous", report.max_ambiguous},
            {"first_failed", failed ? Json(failed->verdict.label) : Json(nullptr)},
            {"stages", stages}};
}

}  // namespace plumb::cli
