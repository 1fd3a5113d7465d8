// plumb probe-device: exit codes and what its report holds. The figures: tests/parity/test_probe.cpp.
#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/program/program.h"

using namespace plumb::program;

namespace {

bool without_vulkan(const Result& r) {
    return r.exit == 2 && r.err == "plumb: probe-device: this program was built without Vulkan (libvulkan-dev)\n";
}

}  // namespace

TEST_CASE("probe-device: a device that is not there is one line and exit 2", "[program]") {
    const Result unknown = run({"probe-device", "--device", "no such device"});
    if (without_vulkan(unknown)) return;
    CHECK(unknown.exit == 2);
    CHECK(unknown.out.empty());
    CHECK(unknown.err.rfind("plumb: Vulkan: no ", 0) == 0);
    CHECK(unknown.err.find('\n') == unknown.err.size() - 1);
}

TEST_CASE("probe-device: fits the profile of its device, or makes one", "[program]") {
    const Result devices = run({"devices", "--json"});
    if (devices.exit != 0 || Json::parse(devices.out).empty()) return;
    const Json device = Json::parse(devices.out)[0];
    const Result r = run({"probe-device", "--device", "0", "--json"});
    const Json report = Json::parse(r.out);
    CHECK(report["device"] == device["name"]);
    CHECK(r.exit == (report["fits"].is_null() ? 1 : 0));
    CHECK(report["fits"].is_null() != report["measured_profile"].is_null());
    CHECK(report["operations"].size() == 36);
    CHECK(report["profiles"].contains("ideal"));
    if (device["profile"] == "ideal") return;  // nobody has measured this driver
    CHECK(report["fits"] == device["profile"]);
    for (const Json& field : report["profiles"][device["profile"].get<std::string>()]) CHECK(field["fits"] == true);
}
