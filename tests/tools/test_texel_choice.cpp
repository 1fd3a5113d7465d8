// How many pixels have a choice of texel that devices may make otherwise: with whole texels it is that of the projection,
// with continuous ones that of every sample. The figures of gi/rsm/README.md:
//
//     build/release/test_tools "[texel_choice]" -s
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "core/parallel.h"
#include "gi/parity/stages.h"
#include "io/scene_file.h"

using namespace plumb;

namespace {

struct Open {
    int pixels = 0;     // that see a surface
    int several = 0;    // have more than one outcome, or one that nobody can tell
    int ambiguous = 0;  // of these: more outcomes than are followed
    double share() const { return double(several) / pixels; }
};

// The Cornell box, 400 samples of a map of 512 texels a side.
Open open_choices(rsm::Gather gather, rsm::Texels texels) {
    Scene scene = io::load_scene(PLUMB_SOURCE_DIR "/data/scenes/cornell/cornell.toml",
                                 frame::method_tables());
    scene.frame_size = {96, 96};
    scene.lights.at(0).rsm_size = 512;
    frame::Settings settings = frame::settings_of(scene);
    settings.rsm.gather = gather, settings.rsm.texels = texels;
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame frame = frame::execute(scene, settings, plan, {});
    Open all;
    for (const StageData& data : parity::frame_data(scene, settings, plan, frame)) {
        if (data.stage != rsm::stage_name(gather, texels)) continue;
        REQUIRE(all.pixels == 0);  // one light
        const auto bound = parity::find_binding(data.stage, "test").bind(data);
        std::vector<Open> rows(96);
        parallel_bands(96, 1, {}, [&](int y, int) {
            std::vector<Outcome> out;
            for (int x = 0; x < 96; ++x) {
                if (frame.gbuffer.normal(x, y).w == 0) continue;
                bound->outcomes({x, y}, {}, {}, {}, out);
                Open& row = rows[std::size_t(y)];
                ++row.pixels, row.several += out.size() > 1 || out.at(0).ambiguous, row.ambiguous += out.at(0).ambiguous;
            }
        });
        for (const Open& row : rows)
            all.pixels += row.pixels, all.several += row.several, all.ambiguous += row.ambiguous;
    }
    return all;
}

}  // namespace

TEST_CASE("texel choice: whole texels leave few pixels open, continuous ones many", "[rsm][texel_choice]") {
    for (const rsm::Gather gather : {rsm::Gather::disc, rsm::Gather::paths}) {
        const Open whole = open_choices(gather, rsm::Texels::whole), own = open_choices(gather, rsm::Texels::continuous);
        const std::string line = fmt::format(
            "{}: of {} pixels whole {} ({:.2f} %, ambiguous {}), continuous {} ({:.2f} %, ambiguous {})",
            rsm::stage_name(gather), whole.pixels, whole.several, 100 * whole.share(), whole.ambiguous, own.several,
            100 * own.share(), own.ambiguous);
        INFO(line);
        REQUIRE(whole.pixels > 5000);
        CHECK(own.pixels == whole.pixels);
        CHECK(own.share() > 0.005);
        CHECK(own.share() < 0.5);
        // Of disc alone: along paths an undecided slot is a choice, too.
        if (gather == rsm::Gather::disc) CHECK(whole.share() < 0.1 * own.share());
    }
}
