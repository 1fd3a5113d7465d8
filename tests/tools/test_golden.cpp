// Golden hashes: the small Cornell box, buffer by buffer. The expected values are in data/golden/cornell_small.txt; this
// command writes them anew, where a change of the pictures is meant:
//
//     build/release/test_tools "[write_golden]"
#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <sstream>

#include "core/content_hash.h"
#include "gi/frame/frame.h"
#include "io/scene_file.h"

using namespace plumb;

namespace {

const std::string golden_path = std::string(PLUMB_SOURCE_DIR) + "/data/golden/cornell_small.txt";

using Hashes = std::map<std::string, std::string>;

// The hash of every buffer of a frame of 128 x 96 pixels, a map of 64 x 64 texels, 100 samples.
Hashes hashes_of(const Scene& scene, raster::Layout layout, rsm::Gather gather, const RunOptions& options) {
    frame::Settings settings = frame::settings_of(scene);
    settings.layout = layout;
    settings.rsm.gather = gather;
    settings.rsm.samples = 100;
    settings.rsm.max_rays = 1e6f;  // 64 texels a pixel: exact rays, whose standard error has a hash too
    const frame::Frame f = frame::execute(scene, settings, frame::plan(scene, settings), options);
    const std::string set = std::string(layout == raster::Layout::fp32 ? "fp32" : "rgba16f") + "/" +
                            rsm::stage_name(gather).substr(4) + "/";
    Hashes h;
    auto add = [&](const char* name, const auto& image) {
        REQUIRE_FALSE(image.empty());
        h[set + name] = hash_text(content_hash(image));
    };
    add("position", f.gbuffer.position);
    add("normal", f.gbuffer.normal);
    add("albedo", f.gbuffer.albedo);
    add("emission", f.gbuffer.emission);
    add("depth", f.gbuffer.depth);
    add("id", f.gbuffer.id);
    add("rsm.position", f.rsms[0][0].position);
    add("rsm.normal", f.rsms[0][0].normal);
    add("rsm.flux", f.rsms[0][0].flux);
    h[set + "shadow"] = hash_text(content_hash(f.visibility.data(), f.visibility.size() * sizeof(float)));
    add("direct", f.direct);
    add("indirect", f.indirect);
    if (gather == rsm::Gather::all_rays) add("indirect.error", f.indirect_error);
    add("color", f.radiance);
    add("display", f.display);
    return h;
}

// Of the method isr: with all its sources and two bounces, and as printed.
Hashes isr_hashes(const Scene& scene, bool printed, const RunOptions& options) {
    frame::Settings settings = frame::settings_of(scene);
    settings.method = frame::Method::isr;
    isr::IsrParams& p = settings.isr;
    p.spacing = 3, p.k_ssao = 0.5f;
    if (printed)
        p.variant = isr::Variant::published, p.k_isr = 0.5f;
    else
        p.bounces = 2, p.guard = 16, p.layers = 2, p.cameras = 2, p.rotations = 4;
    const frame::Frame f = frame::execute(scene, settings, frame::plan(scene, settings), options);
    const std::string set = printed ? "isr/published/" : "isr/corrected/";
    Hashes h;
    auto add = [&](const char* name, const Image4& image) {
        REQUIRE_FALSE(image.empty());
        h[set + name] = hash_text(content_hash(image));
    };
    add("surface", f.isr.surface);
    add("gathered", f.isr.gathered.back());
    add("lit", f.isr.lit);
    add("indirect", f.indirect);
    add("color", f.radiance);
    if (!printed) add("unseen", f.isr.unseen.back());
    return h;
}

Scene small_cornell() {
    Scene scene = io::load_scene(std::string(PLUMB_SOURCE_DIR) + "/data/scenes/cornell/cornell.toml",
                                 frame::method_tables());
    scene.frame_size = {128, 96};
    scene.lights.at(0).rsm_size = 64;
    return scene;
}

Hashes all_hashes(const Scene& scene, const RunOptions& options) {
    Hashes h;
    for (auto layout : {raster::Layout::fp32, raster::Layout::rgba16f})
        for (auto gather : {rsm::Gather::disc, rsm::Gather::all, rsm::Gather::all_rays})
            h.merge(hashes_of(scene, layout, gather, options));
    for (const bool printed : {false, true}) h.merge(isr_hashes(scene, printed, options));
    return h;
}

}  // namespace

TEST_CASE("golden: every buffer of the Cornell box, by every instruction set and thread count", "[golden][bits]") {
    Hashes expected;
    std::ifstream file(golden_path);
    for (std::string name, hash; file >> name >> hash;) expected[name] = hash;
    REQUIRE(expected.size() == 6 * 14 + 2 + 11);
    const Scene scene = small_cornell();
    for (Isa isa : supported_isas())
        for (int threads : {1, 2, 3}) {
            RunOptions options;
            options.isa = isa;
            options.threads = threads;
            const Hashes got = all_hashes(scene, options);
            REQUIRE(got.size() == expected.size());
            for (const auto& [name, hash] : expected) {
                CAPTURE(isa_name(isa), threads, name);
                CHECK(got.at(name) == hash);
            }
        }
}

TEST_CASE("golden: write the hashes anew", "[.][write_golden]") {
    std::ofstream file(golden_path);
    for (const auto& [name, hash] : all_hashes(small_cornell(), RunOptions{})) file << name << ' ' << hash << '\n';
    REQUIRE(file.good());
}
