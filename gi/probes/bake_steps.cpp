#include "gi/probes/bake_steps.h"

#include "gi/probes/bake_params.h"
#include "gi/probes/host_step.h"

namespace plumb::probes {

namespace {

constexpr auto step = host_step<BakeParams>;

const Port geometry = {"geometry", "triangles", "m", "all meshes in world space"};
const Port uv = {"uv", "buffer f32 x 2", "", "[vertex] lightmap coordinate, (0, 0) the top left corner of the first texel"};
const Port receivers = {"receivers", "buffer f32 x 4", "m", "[receiver] position, and unit normal"};
const Port directions = {"directions", "buffer f32 x 4", "", "[ray] unit, of each probe's rays"};
const Port probes = {"probes", "buffer f32 x 4", "m", "[probe] position"};

}  // namespace

StageInfo info_atlas() {
    return step("probes.atlas", "IPR 3.2.1.1; without a twin: charts are packed one after the other", {geometry},
                {uv, {"charts", "rectangles", "texels", "where each chart lies"}},
                {"receivers_per_m2", "lightmap_size", "gap", "chart_angle"});
}

StageInfo info_receivers() {
    return step("probes.receivers", "IPR 3.2.1.2, 5.1.4; without a twin: drawn by texture_space, and rays", {geometry, uv},
                {receivers, {"border", "buffer u32", "", "[receiver] which of its neighbours it extends into"}},
                {"test_rays", "back_share"});
}

StageInfo info_placement() {
    return step("probes.placement", "IPR 3.2.2; without a twin: probes are removed one after the other, and rays",
                {geometry, receivers}, {probes, {"radius", "number", "m", "how far probes reach"}},
                {"probes_per_m3", "count", "least", "both_sides", "candidates_per_probe", "sample_receivers", "radius_of"});
}

StageInfo info_spatial() {
    return step("probes.spatial", "IPR 4.1.1 (1) to (3); without a twin: rays. probes.coefficients and probes.clusters read it, too",
                {geometry, probes},
                {{"receivers", "buffer f32 x 4", "m", "[direction][place] position, and unit normal: an axis"},
                 {"grid", "numbers", "m", "places along x, y, z; origin; spacing"}},
                {"spatial_receivers", "spatial_back_share", "spatial_weight"});
}

StageInfo info_directions() {
    return step("probes.directions", "IPR 3.2.3.1; without a twin: one least-squares problem",
                {{"sequence", "integers", "", "direction numbers of Sobol's sequence, two dimensions"}},
                {directions, {"weights", "buffer f32", "sr", "[ray] exact for harmonics to degree 14"},
                 {"harmonics", "buffer f32", "1/sqrt(sr)", "[ray][coefficient] Y_j"}},
                {"relight_rays", "degree"});
}

StageInfo info_relight() {
    return step("probes.relight", "IPR 3.2.3.1; without a twin: rays", {geometry, uv, probes, directions},
                {{"hits", "buffers", "m", "[probe][ray] material, lightmap coordinate and position of what the ray met"}}, {});
}

StageInfo info_rays() {
    return step("probes.rays", "IPR 3.2.3.2; without a twin: rays. probes.share and probes.coefficients read what they met",
                {geometry, receivers, probes},
                {{"seen", "buffer f32 x 4", "m", "[ray][receiver] what was met"},
                 {"visible", "buffer i32", "", "[ray][receiver] which probes see it as well"}},
                {"receiver_rays", "distribution", "escapes", "gather", "rays"});
}

StageInfo info_clusters() {
    return step("probes.clusters", "IPR 3.2.4; without a twin: decompositions",
                {receivers, {"alpha", "buffer f32", "sr", "[receiver][slot][coefficient]"}},
                {{"sigma_vt", "buffer f32", "sr", "[cluster][singular value][probe][coefficient]"},
                 {"u", "buffer f32", "", "[receiver][singular value]"}},
                {"singular_values", "threshold", "cluster_receivers", "by_size_only"});
}

}  // namespace plumb::probes
