// The probes of tools/vulkan/probe.h on software drivers whose rounding is known.
//
// Expected figures: raster/README.md, "Devices", and data/parity/probes.md.
#include <catch2/catch.hpp>
#include <iostream>

#include "tools/vulkan/probe.h"
#include "tools/vulkan/profile.h"

namespace {

using namespace plumb;
using vulkan::Probe;

// The first device whose profile was measured, probed once; null, and said so, where there is none. It is never ended: a
// driver's own statics may be gone before ours.
struct Probed {
    vulkan::Device device;
    DeviceProfile expected;
    Probe probe;

    explicit Probed(const std::string& name)
        : device({.name = name, .validate = true}), expected(vulkan::profile_of(device)),
          probe(vulkan::probe_device(device)) {}
};
const Probed* known_device() {
    static const Probed* probed = nullptr;
    if (probed) return probed;
    for (const vulkan::DeviceInfo& d : vulkan::list_devices())
        if (vulkan::profile_of(d).name != "ideal") return probed = new Probed(std::to_string(d.index));
    for (const vulkan::DeviceInfo& d : vulkan::list_devices())
        std::cout << "SKIPPED: no profile for " << d.name() << ", " << d.driver_info << "; try plumb probe-device\n";
    std::cout << "SKIPPED: no device of a known profile (mesa-vulkan-drivers)\n";
    return nullptr;
}

std::vector<std::string> differing(const Probe& probe, const DeviceProfile& profile) {
    std::vector<std::string> out;
    for (const vulkan::ProfileField& f : vulkan::compare_fields(probe, profile))
        if (!f.fits) out.push_back(f.name);
    return out;
}

}  // namespace

TEST_CASE("probes: a known driver fits its own profile and no other that is exact", "[vulkan][probe]") {
    const Probed* p = known_device();
    if (!p) return;
    INFO(p->device.name());
    const DeviceProfile* fitting = vulkan::fitting_profile(p->probe, device_profiles());
    REQUIRE(fitting);
    CHECK(fitting->name == p->expected.name);
    CHECK(differing(p->probe, p->expected).empty());
    for (const DeviceProfile& d : device_profiles())
        if (d.interpolation != Interpolation::ideal && d.name != p->expected.name) {
            INFO(d.name);
            CHECK_FALSE(vulkan::fits(p->probe, d));
        }
    for (const std::string& complaint : p->device.complaints()) UNSCOPED_INFO(complaint);
    CHECK(p->device.complaints().empty());
}

TEST_CASE("probes: each field that is altered is found, and no other", "[vulkan][probe]") {
    const Probed* p = known_device();
    if (!p) return;
    using Alter = void (*)(DeviceProfile&);
    const std::pair<const char*, Alter> alterations[] = {
        {"subpixel_bits", [](DeviceProfile& d) { d.subpixel_bits += 1; }},
        {"interpolation",
         [](DeviceProfile& d) {
             for (const DeviceProfile& other : device_profiles())
                 if (other.interpolation != Interpolation::ideal && other.interpolation != d.interpolation) {
                     d.interpolation = other.interpolation;
                     break;
                 }
         }},
        {"half_store",
         [](DeviceProfile& d) {
             d.half_store = d.half_store == HalfStore::nearest ? HalfStore::truncate : HalfStore::nearest;
             d.half_store_either = false;
         }},
        {"precision.add", [](DeviceProfile& d) { d.precision.add = 0.49; }},
        {"precision.multiply", [](DeviceProfile& d) { d.precision.multiply = 0.49; }},
        {"precision.divide", [](DeviceProfile& d) { d.precision.divide = 0.49; }},
        {"precision.inverse_sqrt", [](DeviceProfile& d) { d.precision.inverse_sqrt = 1; }},
        {"precision.sqrt", [](DeviceProfile& d) { d.precision.sqrt = 0.49; }},
        {"precision.exp2, exp2_slope", [](DeviceProfile& d) { d.precision.exp2 = 3, d.precision.exp2_slope = 0.4; }},
        {"precision.log2, log2_absolute", [](DeviceProfile& d) { d.precision.log2_absolute = 0x1p-24; }},
    };
    for (const auto& [field, alter] : alterations) {
        DeviceProfile altered = p->expected;
        alter(altered);
        INFO(field);
        CHECK(differing(p->probe, altered) == std::vector<std::string>{field});
        CHECK_FALSE(vulkan::fits(p->probe, altered));
    }
}

TEST_CASE("probes: fused multiply-adds in the rasteriser and flushed denormals are seen", "[vulkan][probe]") {
    const Probed* p = known_device();
    if (!p) return;
    DeviceProfile altered = p->expected;
    altered.fused_raster = !altered.fused_raster;
    const bool lavapipe = altered.interpolation == Interpolation::plane_equation;
    std::vector<std::string> expected;
    if (lavapipe) expected.push_back("fused_raster");  // nobody asks SwiftShader's planes
    CHECK(differing(p->probe, altered) == expected);
    altered = p->expected;
    altered.precision.flushes_denormals = false;
    CHECK(differing(p->probe, altered).empty() == lavapipe);  // its compute shaders keep them, SwiftShader's do not
}

TEST_CASE("probes: an altered probe fits nothing, and the profile made of it fits it", "[vulkan][probe]") {
    const Probed* p = known_device();
    if (!p) return;
    // The grid of no profile; planes, then, are no longer known either.
    Probe probe = p->probe;
    probe.snapping.bits = 6;
    probe.snapping.displacement = 0x1p-7;
    CHECK(vulkan::fitting_profile(probe, device_profiles()) == nullptr);
    const DeviceProfile made = vulkan::measured_profile(probe, "made");
    CHECK(made.subpixel_bits == 6);
    CHECK(made.interpolation == Interpolation::ideal);
    CHECK(differing(probe, made).empty());

    // Of the probe as it is: what was measured, again.
    const DeviceProfile again = vulkan::measured_profile(p->probe, "again");
    CHECK(differing(p->probe, again).empty());
    CHECK(again.subpixel_bits == p->expected.subpixel_bits);
    CHECK(again.interpolation == p->expected.interpolation);
    CHECK(again.fused_raster == p->expected.fused_raster);
    CHECK(again.precision.flushes_denormals == p->expected.precision.flushes_denormals);
    CHECK(vulkan::profile_source(again).find("d.interpolation = Interpolation::") != std::string::npos);
}

// What twins count on (design: spelled out in scalars, under `precise`), and what they do not call.
TEST_CASE("probes: precise keeps the order of operations, and what is not precise may change it", "[vulkan][probe]") {
    const Probed* p = known_device();
    if (!p) return;
    auto formula = [&](const char* name) { return vulkan::operation(p->probe, name).formula; };
    for (const char* name : {"a + b", "a - b", "a * b", "a / b", "1 / a", "sqrt(a)"}) CHECK(formula(name) == "IEEE 754");
    CHECK(formula("precise a * b + c") == "a b + c");
    CHECK(formula("precise (a + 0.1) + 0.2") == "in order");
    CHECK(formula("(a + 0.1) + 0.2") == "a + 0.3");
    const bool lavapipe = p->expected.interpolation == Interpolation::plane_equation;
    CHECK(formula("mix(a, b, c)") == (lavapipe ? "a (1 - c) + b c" : "a + c (b - a)"));
    CHECK(formula("normalize(abc)") == (lavapipe ? "v / sqrt(v.v)" : "v (1 / sqrt(v.v))"));
    CHECK(formula("mat4 * vec4") == (lavapipe ? "last column first" : "first column first"));
    CHECK(formula("float(uint)") == (lavapipe ? "nearest" : "of 31 bits and 1, added"));
    CHECK(vulkan::operation(p->probe, "acos(a)").worst_absolute > 1e-5);
    CHECK(p->probe.shared_edges == 0);
}

// SwiftShader's halves are the nearest but just above 2^-25; its ten bits round, lavapipe's are cut.
TEST_CASE("probes: stores and filters of the drivers that were measured", "[vulkan][probe]") {
    const Probed* p = known_device();
    if (!p) return;
    const bool lavapipe = p->expected.interpolation == Interpolation::plane_equation;
    REQUIRE(p->probe.stores.size() == 6);
    for (const vulkan::StoreFigures& s : p->probe.stores) {
        INFO(s.name);
        REQUIRE(s.values > 190000);
        if (s.name.rfind("rgba16f", 0) == 0) {
            CHECK((lavapipe ? s.not_truncated : s.not_nearest) <= (lavapipe ? 0 : 1));
            CHECK((lavapipe ? s.not_nearest : s.not_truncated) > s.values / 3);
        }
        if (s.name.rfind("rgba8", 0) == 0) CHECK(s.not_nearest == 0);
        if (s.name.rfind("r10g10b10a2", 0) == 0) CHECK((lavapipe ? s.not_cut : s.not_nearest) <= (lavapipe ? 2 : 0));
    }
    REQUIRE(p->probe.filters.size() == 3);
    for (const vulkan::FilterFigures& f : p->probe.filters) {
        INFO(f.format);
        const bool bytes = f.format == "rgba8";
        REQUIRE(f.supported);
        CHECK(f.bits == (lavapipe && bytes ? 8 : 0));
        CHECK(f.worst < (lavapipe && bytes ? 0.006 : 2e-7));
    }
}
