// plumb probe-device: how a device rounds, and which profile that is.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "tools/plumb/devices.h"
#include "tools/shared/reports.h"
#include "tools/shared/table.h"
#ifdef PLUMB_WITH_VULKAN
#include "tools/vulkan/probe.h"
#include "tools/vulkan/profile.h"
#endif

namespace plumb::cli {
namespace {

struct ProbeRequest {
    std::string device;
    Common common;
};

#ifdef PLUMB_WITH_VULKAN

using vulkan::Probe;
using vulkan::ProfileField;

// The name of a device as one of a profile.
std::string profile_name(const std::string& device) {
    std::string out;
    for (const char c : device.substr(0, device.find(" ("))) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
        out += c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : letter ? c : '-';
    }
    return out;
}

std::string operations_text(const Probe& probe) {
    std::vector<std::vector<std::string>> rows;
    for (const vulkan::OperationFigures& o : probe.operations) {
        const bool measured = o.inputs > 0;
        rows.push_back({o.name, measured ? fmt::format("{:.4g}", 100 * o.off) : "",
                        measured ? fmt::format("{:.3g}", o.worst_ulp) : "",
                        measured && o.worst_ulp > 0.5 ? fmt::format("{:.6g}", o.worst_at) : "",
                        measured && o.worst_ulp > 1 ? fmt::format("{:.2g}", o.worst_absolute) : "",
                        vulkan::denormals_text(o.denormals), o.formula});
    }
    return format_table({{"operation"},
                         {"% off", Align::right},
                         {"ULP", Align::right},
                         {"at a", Align::right},
                         {"absolute", Align::right},
                         {"denormals"},
                         {"is"}},
                        rows) +
           "\n% off: results that are not the nearest float; is: the formula that has all bits, if one has\n";
}

std::string store_text(const vulkan::StoreFigures& s) {
    if (s.values == 0) return "not supported";
    if (s.not_nearest == 0) return "nearest";
    if (s.not_truncated == 0) return "towards zero";
    if (s.not_cut < s.not_nearest && s.not_cut < s.values / 10000)
        return fmt::format("10 bits cut from 16, alpha nearest; of {} values {} are not", s.values, s.not_cut);
    return fmt::format("of {} values {} not nearest, {} not towards zero, {} neither: {}", s.values, s.not_nearest,
                       s.not_truncated, s.neither, s.example);
}

std::string figures_text(const Probe& probe) {
    std::vector<std::vector<std::string>> rows;
    rows.push_back({"min(), max() of NaN", probe.minimum_of_nan + ", " + probe.maximum_of_nan});
    for (const vulkan::StoreFigures& s : probe.stores) rows.push_back({s.name, store_text(s)});
    rows.push_back({"halves of large numbers", probe.half_overflow});
    for (const vulkan::FilterFigures& f : probe.filters)
        rows.push_back({f.format + " filter",
                        f.supported ? fmt::format("{} weights ({}), off by {:.2g} at most", f.weights,
                                                  f.bits > 0 ? fmt::format("{} bits", f.bits) : "float", f.worst)
                                    : "not supported"});
    rows.push_back({"top-left rule", probe.shared_edges == 0
                                         ? "kept"
                                         : fmt::format("{} pixels belong to another triangle", probe.shared_edges)});
    return format_table({{""}, {""}}, rows);
}

// A field a row, a profile a column; what does not fit has a mark.
std::string fields_text(const Probe& probe) {
    std::vector<Column> columns{{"field"}, {"measured"}};
    std::vector<std::vector<std::string>> rows;
    for (const DeviceProfile& d : device_profiles()) {
        columns.push_back({d.name});
        const std::vector<ProfileField> fields = vulkan::compare_fields(probe, d);
        for (std::size_t i = 0; i < fields.size(); ++i) {
            if (rows.size() <= i) rows.push_back({fields[i].name, fields[i].measured});
            rows[i].push_back(fields[i].stated + (fields[i].fits ? "" : " !"));
        }
    }
    return format_table(columns, rows);
}

Json probe_json(const Probe& probe, const DeviceProfile* fitting) {
    Json operations = Json::array(), stores = Json::array(), filters = Json::array(), profiles = Json::object();
    for (const vulkan::OperationFigures& o : probe.operations)
        operations.push_back({{"operation", o.name},
                              {"inputs", o.inputs},
                              {"not_nearest", o.inputs > 0 ? Json(o.off) : Json()},
                              {"worst_ulp", o.inputs > 0 ? Json(o.worst_ulp) : Json()},
                              {"worst_at", o.inputs > 0 ? Json(o.worst_at) : Json()},
                              {"worst_absolute", o.inputs > 0 ? Json(o.worst_absolute) : Json()},
                              {"denormals", vulkan::denormals_text(o.denormals)},
                              {"formula", o.formula.empty() ? Json() : Json(o.formula)}});
    for (const vulkan::StoreFigures& s : probe.stores)
        stores.push_back({{"store", s.name},
                          {"values", s.values},
                          {"not_nearest", s.not_nearest},
                          {"not_truncated", s.not_truncated},
                          {"neither", s.neither},
                          {"not_cut_from_16", s.not_cut}});
    for (const vulkan::FilterFigures& f : probe.filters)
        filters.push_back({{"format", f.format},
                           {"supported", f.supported},
                           {"weights", f.weights},
                           {"weight_bits", f.bits},
                           {"worst_absolute", f.worst}});
    for (const DeviceProfile& d : device_profiles()) {
        Json fields = Json::array();
        for (const ProfileField& f : vulkan::compare_fields(probe, d))
            fields.push_back({{"field", f.name}, {"measured", f.measured}, {"says", f.stated}, {"fits", f.fits}});
        profiles[d.name] = fields;
    }
    return {{"device", probe.device},
            {"driver", probe.driver},
            {"operations", operations},
            {"min_of_nan", probe.minimum_of_nan},
            {"max_of_nan", probe.maximum_of_nan},
            {"stores", stores},
            {"half_overflow", probe.half_overflow},
            {"filters", filters},
            {"subpixel_bits", probe.snapping.bits},
            {"ties", probe.snapping.ties},
            {"displacement_pixels", probe.snapping.displacement},
            {"pixels_off_top_left_rule", probe.shared_edges},
            {"profiles", profiles},
            {"fits", fitting ? Json(fitting->name) : Json()},
            {"measured_profile", fitting ? Json()
                                         : Json(vulkan::profile_source(vulkan::measured_profile(
                                               probe, profile_name(probe.device))))}};
}

std::string verdict_text(const Probe& probe, const DeviceProfile* fitting, const DeviceProfile& by_name) {
    if (fitting) {
        const char* remark = fitting->name == by_name.name ? "" : ", not what its name says: ";
        return fmt::format("fits {}{}{}\n", fitting->name, remark, *remark ? by_name.name : "");
    }
    std::string differs;
    for (const ProfileField& f : vulkan::compare_fields(probe, by_name))
        if (!f.fits) differs += (differs.empty() ? "" : "; ") + f.name;
    return fmt::format("fits no profile; differs from {} in {}\n\n{}", by_name.name,
                       differs.empty() ? "the top-left rule" : differs,
                       vulkan::profile_source(vulkan::measured_profile(probe, profile_name(probe.device))));
}

int probe_device(const ProbeRequest& request) {
    request.common.run_options();
    const vulkan::Device device({.name = request.device});
    const Probe probe = vulkan::probe_device(device);
    const DeviceProfile* fitting = vulkan::fitting_profile(probe, device_profiles());
    if (request.common.json) {
        std::fputs(json_text(probe_json(probe, fitting)).c_str(), stdout);
    } else {
        const std::string title = probe.device + (probe.driver.empty() ? "" : " (" + probe.driver + ")");
        std::fputs(fmt::format("{}\n\n{}\n{}\n{}\n! does not fit\n\n{}", title, operations_text(probe),
                               figures_text(probe), fields_text(probe),
                               verdict_text(probe, fitting, vulkan::profile_of(device)))
                       .c_str(),
                   stdout);
    }
    return fitting ? success : disagreement;
}

#else

int probe_device(const ProbeRequest&) {
    require_vulkan("probe-device");
    return success;
}

#endif

}  // namespace

void add_probe_device(CLI::App& program, Action& action) {
    auto request = std::make_shared<ProbeRequest>();
    CLI::App* command =
        program.add_subcommand("probe-device", "measure how a Vulkan device rounds, and which profile that is");
    add_device_option(*command, request->device);
    add_common(*command, request->common);
    command->callback([request, &action] { action = [request] { return probe_device(*request); }; });
}

}  // namespace plumb::cli
