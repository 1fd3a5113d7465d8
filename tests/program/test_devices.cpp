// plumb devices. What is there depends on the machine; what is said about it does not.
#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/program/program.h"

using namespace plumb::program;

namespace {

bool without_vulkan(const Result& r) {
    return r.exit == 2 && r.err == "plumb: devices: this program was built without Vulkan (libvulkan-dev)\n";
}

}  // namespace

TEST_CASE("devices: each with its driver, its profile and its limits", "[program]") {
    const Result r = run({"devices", "--json"});
    if (without_vulkan(r)) return;
    REQUIRE(r.exit == 0);
    CHECK(r.err.empty());
    const Json devices = Json::parse(r.out);
    REQUIRE(devices.is_array());
    const Result text = run({"devices"});
    for (const Json& d : devices) {
        CHECK(keys(d) == Words{"index", "name", "type", "api_version", "driver_name", "driver_info", "profile",
                               "max_image", "max_image_layers", "max_buffer_bytes", "max_buffers", "max_colour_targets",
                               "raster_taps"});
        CHECK(d["max_image"] >= 4096);  // Vulkan 1.1, 36.1: required limits
        CHECK(text.out.find(d["name"].get<std::string>()) != std::string::npos);
        CHECK(text.out.find(d["profile"].get<std::string>()) != std::string::npos);
    }
}

TEST_CASE("devices: none is an empty list", "[program]") {
    setenv("VK_ICD_FILENAMES", "/nonexistent.json", 1);
    const Result json = run({"devices", "--json"}), text = run({"devices"});
    unsetenv("VK_ICD_FILENAMES");
    if (without_vulkan(json)) return;
    CHECK(json.exit == 0);
    CHECK(json.out == "[]\n");
    CHECK(text.exit == 0);
    CHECK(text.out == "no Vulkan device (for a software one, install mesa-vulkan-drivers)\n");
}
