// Whole frames as a real GPU wrote them, judged without one (data/parity/h100_96x57.tar.xz).
#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/program/exported.h"

using namespace plumb;
using namespace plumb::program;

namespace fs = std::filesystem;

namespace {

std::string frame_of(const std::string& name) { return std::string(PLUMB_MEASURED) + "/" + name; }

Json judged(const std::string& folder, int exit, const Words& more = {}) {
    Words words = {"validate", folder + "/manifest.toml", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Result r = run(words);
    INFO(r.out << r.err);
    REQUIRE(r.exit == exit);
    return Json::parse(r.out);
}

}  // namespace

// The bits were the kernel's where the figures say equal; elsewhere a GPU rounds in its own way.
TEST_CASE("measured: three frames of an NVIDIA H100 agree, and not by being equal", "[program]") {
    struct Expected {
        std::string frame, stage;
        std::size_t stages;
    };
    for (const Expected& e : {Expected{"small_rsm_96x57", "rsm.disc (key)", 7}, {"small_paths_96x57", "rsm.paths (key)", 12},
                              {"small_isr_96x57", "isr.upsample", 21}}) {
        CAPTURE(e.frame);
        const Json all = judged(frame_of(e.frame), 0);
        CHECK(all["verdict"] == "within_bound");
        CHECK(all["stages"].size() == e.stages);
        for (const Json& stage : all["stages"]) {
            CAPTURE(stage.at("name"));
            CHECK(stage.at("counts").at("wrong") == 0);
            CHECK(stage.at("counts").at("ambiguous") == 0);
        }
        const Json gather = stage_of(all, e.stage);
        CHECK(gather.at("counts").at("within_bound") > 0);
        CHECK(gather.at("counts").at("equal") > gather.at("counts").at("within_bound"));
    }
}

TEST_CASE("measured: the H100's frames keep the profile that was probed on it, and not that of a driver that rounds otherwise", "[program]") {
    for (const char* frame : {"small_rsm_96x57", "small_paths_96x57", "small_isr_96x57"}) {
        CAPTURE(frame);
        const Json own = judged(frame_of(frame), 0, {"--profile", "nvidia-hopper-580"});
        CHECK(own["verdict"] == "within_bound");
        for (const Json& stage : own["stages"]) {
            CAPTURE(stage.at("name"));
            CHECK(stage.at("counts").at("wrong") == 0);
        }
        // Quotients and roots that are correctly rounded are not what it writes.
        CHECK(judged(frame_of(frame), 1, {"--profile", "lavapipe-22.3-fma"})["verdict"] == "wrong");
    }
}

// The highest bit of the exponent, of numbers all over the picture, one at a time.
TEST_CASE("measured: a byte changed in a GPU's frame is found", "[program]") {
    const std::string folder = fresh_folder("measured_changed");
    fs::copy(frame_of("small_rsm_96x57"), folder, fs::copy_options::recursive);
    const std::string file = folder + "/rsm.disc.key/out/irradiance.bin", original = read(file);
    const auto value_at = [&](std::size_t byte) { return word<float>(original, byte / 4); };
    int tried = 0;
    for (std::size_t byte = 3; byte < original.size() && tried < 12; byte += 2004) {
        if (byte % 16 == 15 || value_at(byte) == 0) continue;  // w, and pixels that are black
        CAPTURE(byte);
        std::string changed = original;
        changed[byte] = char(changed[byte] ^ 0x40);
        write(file, changed);
        const Json all = judged(folder, 1), stage = stage_of(all, "rsm.disc (key)");
        CHECK(all["first_failed"] == "rsm.disc (key)");
        CHECK(stage["counts"]["wrong"] == 1);
        const int pixel = int(byte / 16);
        CHECK(stage["worst"]["pixel"] == Json({pixel % 96, pixel / 96}));
        ++tried;
    }
    CHECK(tried == 12);
}
