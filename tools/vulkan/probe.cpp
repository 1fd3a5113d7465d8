// What the probes say about a device, as a profile.
#include "tools/vulkan/probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/decisions.h"

namespace plumb::vulkan {
namespace {

constexpr const char* interpolation_names[] = {"ideal", "plane_equation", "snapped_planes"};
constexpr double slack = 1e-6;        // of figures in units: the exact results are doubles
constexpr int exp2_bins = 1024;       // of Probe::exp2, for 1 of |x|
constexpr double resolution = 0x1p-11;  // pixels: of SnappingFigures::displacement, two rows

const char* name_of(Interpolation i) { return interpolation_names[int(i)]; }
const char* word(bool b) { return b ? "true" : "false"; }
const char* name_of(HalfStore h) { return h == HalfStore::nearest ? "nearest" : "truncate"; }

double worst_of(const Probe& probe, std::initializer_list<const char*> names) {
    double worst = 0;
    for (const char* name : names) worst = std::max(worst, operation(probe, name).worst_ulp);
    return worst;
}

// ---- What was measured, by field ------------------------------------------------------------------------------------

bool draws_alike(const Probe& probe, DeviceProfile profile) {
    if (probe.snapping.bits > 0) profile.subpixel_bits = probe.snapping.bits;
    return compare_drawing(probe.inside, profile).none() && compare_drawing(probe.clipped, profile).none();
}

// The known rasteriser that has all bits; null where none has.
const DeviceProfile* known_rasteriser(const Probe& probe) {
    for (const DeviceProfile& d : device_profiles())
        if (d.interpolation != Interpolation::ideal && draws_alike(probe, d)) return &d;
    return nullptr;
}

struct HalfRule {
    bool nearest = true, truncate = true, neither = false;
};
HalfRule half_rule(const Probe& probe) {
    HalfRule out;
    for (const StoreFigures& s : probe.stores) {
        if (s.name.rfind("rgba16f", 0) != 0 || s.values == 0) continue;
        out.nearest &= s.not_nearest == 0;
        out.truncate &= s.not_truncated == 0;
        out.neither |= s.neither > 0;
    }
    return out;
}

// The fewest of a filter of floats; 0: a float's.
int weight_bits(const Probe& probe) {
    int bits = 0;
    for (const FilterFigures& f : probe.filters)
        if (f.supported && f.format != "rgba8" && f.bits > 0) bits = bits == 0 ? f.bits : std::min(bits, f.bits);
    return bits;
}

bool denormals_flushed(const Probe& probe) {
    return std::any_of(probe.operations.begin(), probe.operations.end(), [](const OperationFigures& o) {
        return o.denormals == Denormals::flushed || o.denormals == Denormals::both;
    });
}

// exp2 + exp2_slope |x| that no result exceeds.
bool covers_exp2(const Probe& probe, double constant, double slope) {
    for (std::size_t k = 0; k < probe.exp2.size(); ++k)
        if (!(probe.exp2[k] <= constant + slope * double(k) / exp2_bins)) return false;
    return true;
}
// A line above all errors; the worst with |x| < 1 is its start.
double exp2_constant(const Probe& probe) {
    const auto last = probe.exp2.begin() + std::ptrdiff_t(std::min<std::size_t>(probe.exp2.size(), exp2_bins));
    return last == probe.exp2.begin() ? 0 : *std::max_element(probe.exp2.begin(), last);
}
double exp2_slope(const Probe& probe) {
    double slope = 0;
    for (std::size_t k = 1; k < probe.exp2.size(); ++k)
        slope = std::max(slope, (probe.exp2[k] - exp2_constant(probe)) / (double(k) / exp2_bins));
    return slope;
}

// The greatest error that so many units of the logarithm do not cover.
double log2_absolute(const Probe& probe, double units) {
    double worst = 0;
    for (std::size_t k = 0; k < probe.log2.size(); ++k)
        if (!(probe.log2[k] <= units * ulp_ratio * std::ldexp(1.0, int(k) - 24)))
            worst = std::max(worst, probe.log2[k]);
    return worst;
}

// To two digits, upwards.
double rounded_up(double x) {
    if (!(x > 0) || !(x < __builtin_inf())) return x;
    double unit = 1;
    while (x >= 100 * unit) unit *= 10;
    while (x < 10 * unit) unit /= 10;
    return std::stod(fmt::format("{:.2g}", std::ceil(x / unit - 1e-9) * unit));
}

std::string units_text(double x) { return fmt::format("{:.4g}", x); }

void add_raster_fields(const Probe& probe, const DeviceProfile& d, std::vector<ProfileField>& out) {
    const SnappingFigures& s = probe.snapping;
    const bool placed = s.displacement <= std::ldexp(d.snap_uncertainty, -d.subpixel_bits) + resolution;
    const bool emulated = d.interpolation != Interpolation::ideal;
    // Who says where corners may be does not say where they are.
    const bool bits = s.bits == d.subpixel_bits || (!emulated && d.snap_uncertainty > 0 && placed);
    out.push_back({"subpixel_bits", s.bits > 0 ? fmt::format("{}, ties {}", s.bits, s.ties) : "none known",
                   std::to_string(d.subpixel_bits), bits});
    const DeviceProfile* known = known_rasteriser(probe);
    DeviceProfile other = d;
    other.fused_raster = !d.fused_raster;
    const bool alike = !emulated || draws_alike(probe, d);
    const bool either = alike || draws_alike(probe, other);
    out.push_back({"interpolation", known ? name_of(known->interpolation) : "none known", name_of(d.interpolation),
                   either});
    out.push_back({"fused_raster", known ? word(known->fused_raster) : "-", word(d.fused_raster), alike || !either});
    out.push_back({"snap_uncertainty", fmt::format("{:.4f} pixel", s.displacement),
                   fmt::format("{:g} steps", d.snap_uncertainty), emulated || placed});
}

void add_store_fields(const Probe& probe, const DeviceProfile& d, std::vector<ProfileField>& out) {
    const HalfRule half = half_rule(probe);
    const bool stores = d.half_store_either ? !half.neither
                                            : d.half_store == HalfStore::nearest ? half.nearest : half.truncate;
    const char* rule = half.nearest ? "nearest" : half.truncate ? "truncate" : half.neither ? "neither" : "either";
    out.push_back({"half_store", rule,
                   d.half_store_either ? "either" : name_of(d.half_store), stores});
    const int bits = weight_bits(probe);
    auto bits_text = [](int n) { return n == 0 ? std::string("float") : std::to_string(n); };
    out.push_back({"bilinear_weight_bits", bits_text(bits), bits_text(d.bilinear_weight_bits),
                   bits == 0 || (d.bilinear_weight_bits > 0 && bits >= d.bilinear_weight_bits)});
}

void add_precision_fields(const Probe& probe, const Precision& p, std::vector<ProfileField>& out) {
    auto units = [&](const char* name, double measured, double granted) {
        out.push_back({fmt::format("precision.{}", name), units_text(measured), units_text(granted),
                       measured <= granted + slack});
    };
    units("add", worst_of(probe, {"a + b", "a - b"}), p.add);
    units("multiply", worst_of(probe, {"a * b"}), p.multiply);
    units("divide", worst_of(probe, {"a / b", "1 / a"}), p.divide);
    units("inverse_sqrt", worst_of(probe, {"inversesqrt(a)"}), p.inverse_sqrt);
    units("sqrt", worst_of(probe, {"sqrt(a)"}), p.sqrt);
    out.push_back({"precision.exp2, exp2_slope",
                   fmt::format("{:.3g} + {:.3g} |x|", exp2_constant(probe), exp2_slope(probe)),
                   fmt::format("{:g} + {:g} |x|", p.exp2, p.exp2_slope), covers_exp2(probe, p.exp2, p.exp2_slope)});
    const double absolute = log2_absolute(probe, p.log2);
    out.push_back({"precision.log2, log2_absolute", fmt::format("{:g} or {:.3g}", p.log2, absolute),
                   fmt::format("{:g} or {:.3g}", p.log2, p.log2_absolute), absolute <= p.log2_absolute});
    out.push_back({"precision.flushes_denormals", word(denormals_flushed(probe)), word(p.flushes_denormals),
                   p.flushes_denormals || !denormals_flushed(probe)});
}

}  // namespace

Probe probe_device(const Device& device) {
    Probe probe;
    probe.device = device.name();
    probe.driver = device.info().driver_name;
    if (!device.info().driver_info.empty()) probe.driver += ", " + device.info().driver_info;
    probe_operations(device, probe);
    probe_stores(device, probe);
    probe_filters(device, probe);
    probe_rasterisation(device, probe);
    return probe;
}

const OperationFigures& operation(const Probe& probe, const std::string& name) {
    for (const OperationFigures& o : probe.operations)
        if (o.name == name) return o;
    throw std::out_of_range("no operation \"" + name + "\"");
}

std::vector<ProfileField> compare_fields(const Probe& probe, const DeviceProfile& profile) {
    std::vector<ProfileField> out;
    add_raster_fields(probe, profile, out);
    add_store_fields(probe, profile, out);
    add_precision_fields(probe, profile.precision, out);
    return out;
}

bool fits(const Probe& probe, const DeviceProfile& profile) {
    const std::vector<ProfileField> fields = compare_fields(probe, profile);
    return probe.shared_edges == 0 &&
           std::all_of(fields.begin(), fields.end(), [](const ProfileField& f) { return f.fits; });
}

const DeviceProfile* fitting_profile(const Probe& probe, const std::vector<DeviceProfile>& profiles) {
    const auto general = [](const DeviceProfile& d) {
        return d.interpolation != Interpolation::ideal ? 0 : !d.driver.empty() ? 1 : 2;
    };
    const DeviceProfile* found = nullptr;
    for (const DeviceProfile& d : profiles)
        if ((!found || general(d) < general(*found)) && fits(probe, d)) found = &d;
    return found;
}

DeviceProfile measured_profile(const Probe& probe, const std::string& name) {
    DeviceProfile d;
    d.name = name;
    d.driver = probe.driver.empty() ? probe.device : probe.driver;
    if (const DeviceProfile* known = known_rasteriser(probe)) {
        d.interpolation = known->interpolation;
        d.fused_raster = known->fused_raster;
        d.snap_uncertainty = 0;
    }
    if (probe.snapping.bits > 0) d.subpixel_bits = probe.snapping.bits;
    if (d.interpolation == Interpolation::ideal)
        d.snap_uncertainty =
            std::max(1.0, rounded_up(std::ldexp(probe.snapping.displacement - resolution, d.subpixel_bits)));
    const HalfRule half = half_rule(probe);
    d.half_store_either = half.nearest == half.truncate;
    d.half_store = half.truncate && !half.nearest ? HalfStore::truncate : HalfStore::nearest;
    d.bilinear_weight_bits = weight_bits(probe);

    // No better than what rounds correctly.
    Precision& p = d.precision;
    auto units = [&](std::initializer_list<const char*> names) {
        return std::max(0.5, rounded_up(worst_of(probe, names) - slack));
    };
    p.add = units({"a + b", "a - b"});
    p.multiply = units({"a * b"});
    p.divide = units({"a / b", "1 / a"});
    p.inverse_sqrt = units({"inversesqrt(a)"});
    p.sqrt = units({"sqrt(a)"});
    p.exp2 = rounded_up(exp2_constant(probe));
    p.exp2_slope = rounded_up(exp2_slope(probe));
    p.log2_absolute = rounded_up(log2_absolute(probe, p.log2));
    p.flushes_denormals = denormals_flushed(probe);
    return d;
}

std::string profile_source(const DeviceProfile& d) {
    const Precision& p = d.precision;
    return fmt::format("DeviceProfile d;\n"
                       "d.name = \"{}\";\n"
                       "d.driver = \"{}\";\n"
                       "d.subpixel_bits = {};\n"
                       "d.interpolation = Interpolation::{};\n"
                       "d.fused_raster = {};\n"
                       "d.snap_uncertainty = {:g};\n"
                       "d.half_store = HalfStore::{};\n"
                       "d.half_store_either = {};\n"
                       "d.bilinear_weight_bits = {};\n"
                       "d.precision = {{.add = {:g}, .multiply = {:g}, .divide = {:g}, .inverse_sqrt = {:g}, "
                       ".sqrt = {:g},\n               .exp2 = {:g}, .exp2_slope = {:g}, .log2 = {:g}, "
                       ".log2_absolute = {:g},\n               .flushes_denormals = {}}};\n",
                       d.name, d.driver, d.subpixel_bits, name_of(d.interpolation), word(d.fused_raster),
                       d.snap_uncertainty, name_of(d.half_store), word(d.half_store_either), d.bilinear_weight_bits,
                       p.add, p.multiply, p.divide, p.inverse_sqrt, p.sqrt, p.exp2, p.exp2_slope, p.log2,
                       p.log2_absolute, word(p.flushes_denormals));
}

}  // namespace plumb::vulkan
