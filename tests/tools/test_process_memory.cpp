// What memory there is, and what is refused for want of it.
#include "tools/shared/process_memory.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "core/error.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

std::string group(const std::string& name, const std::vector<std::pair<std::string, std::string>>& files) {
    const std::string folder = PLUMB_BINARY_DIR "/memory_groups/" + name;
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    for (const auto& [file, text] : files) std::ofstream(folder + "/" + file) << text;
    return folder;
}

}  // namespace

TEST_CASE("memory: a control group leaves its limit less what is used, but for kept files", "[tools][memory]") {
    CHECK(left_by_group(group("v2", {{"memory.max", "1000\n"}, {"memory.current", "600\n"}, {"memory.stat", "anon 400\nfile 150\nfile_mapped 7\n"}})) == 550);
    CHECK(left_by_group(group("v1", {{"memory.limit_in_bytes", "1000\n"}, {"memory.usage_in_bytes", "600\n"}, {"memory.stat", "cache 9\ntotal_cache 100\n"}})) == 500);
    CHECK(left_by_group(group("no stat", {{"memory.max", "1000\n"}, {"memory.current", "600\n"}})) == 400);
    CHECK(left_by_group(group("above", {{"memory.max", "1000\n"}, {"memory.current", "1600\n"}})) == 0);
    CHECK_FALSE(left_by_group(group("max", {{"memory.max", "max\n"}, {"memory.current", "600\n"}})));
    CHECK_FALSE(left_by_group(group("none", {{"memory.limit_in_bytes", "9223372036854771712\n"}, {"memory.usage_in_bytes", "600\n"}})));
    CHECK_FALSE(left_by_group("/nowhere"));
}

TEST_CASE("memory: what is there is less than the machine has", "[tools][memory]") {
    std::ifstream file("/proc/meminfo");
    std::string name;
    std::uint64_t kilobytes = 0;
    REQUIRE(file >> name >> kilobytes);
    REQUIRE(name == "MemTotal:");
    CHECK(memory_there() > 0);
    CHECK(memory_there() <= kilobytes * 1024);
}

TEST_CASE("memory: what does not fit is refused with both numbers", "[tools][memory]") {
    CHECK_NOTHROW(require_memory("export", 999, 999, "expected less"));
    CHECK_THROWS_WITH(require_memory("export of 9 x 9 pixels", 21340000000, 6000000000, "expected a smaller --size"),
                      "export of 9 x 9 pixels needs about 21.3 GB of memory; there are 6.0 GB: expected a smaller --size");
    CHECK_THROWS_AS(require_memory("export", 1000, 999, "expected less"), InputError);
}
