// The stages of a bake against double: conditions that are known, all cases by hand, and scenes.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/error.h"
#include "gi/lend.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/density.h"
#include "gi/probes/lambda.h"
#include "gi/probes/radiance.h"
#include "gi/probes/share.h"
#include "gi/probes/supports.h"
#include "gi/probes/update.h"
#include "gi/stability/bake.h"

using namespace plumb;
using namespace plumb::stability;

namespace {

const Case& case_named(const std::string& name) {
    for (const Case& c : cases())
        if (c.name == name) return c;
    FAIL("no case is named " << name);
    throw;
}

Cell cell_of(const StageData& data) {
    const std::vector<Cell> cells = bake_cells({data}, "", {});
    REQUIRE(cells.size() == 1);
    return cells[0];
}

const std::set<std::string> all_stages = {"probes.density",  "probes.supports", "probes.share", "probes.coefficients", "probes.radiance",
                                           "probes.lambda",   "probes.level",    "probes.basis", "probes.irradiance",   "probes.lightmap",
                                           "probes.volume",   "probes.lightmap_uv", "probes.lookup", "probes.relief",
                                           "probes.indirect_shadow"};

}  // namespace

// Expected: gi/probes/README.md, Stability. All inputs are powers of two, whose ULP is eps of them.
TEST_CASE("stability: condition numbers of a bake's stages that are known", "[stability][probes][analytic]") {
    // w = (1 - t)^2 (1 + 2 t): t w'/w = -6 t^2 / ((1 - t)(1 + 2 t)), 3 at t = 1/2. The probe's x and the radius are moved; the
    // receiver lies at 0, which nothing rounds.
    const Buffer<glm::vec4> origin = {{0, 0, 0, 0}}, one = {{1, 0, 0, 0}}, both = {{0, 0, 0, 0}, {1, 0, 0, 0}};
    probes::SupportsInputs supports;
    supports.receivers = &origin, supports.probes = &one, supports.radius = 2, supports.overlaps = 1;
    CHECK(cell_of(probes::data_of(supports, 0, 1)).condition == Approx(2 * 1.5).epsilon(1e-5));
    // The nearer to the radius, the worse: 2 / (1 - t). 1 / 1.0625 is 16/17.
    supports.radius = 1.0625f;
    CHECK(cell_of(probes::data_of(supports, 0, 1)).condition == Approx(2 * 6 * 256.0 / 289 / (1.0 / 17 * 49 / 17) * (1 + 1 / 1.0625) / 2).epsilon(1e-4));

    // The same for a candidate and its only neighbour, of 1/r.
    CHECK(cell_of(probes::data_of(probes::DensityInputs{&both, 2})).condition == Approx(2 * 1.5).epsilon(1e-5));

    // f / w: one each.
    const glm::vec4 supporting(0, 0, 0, 0.5f);
    const float factor = 0.25f, length = 1, share = 0.125f;
    const std::int32_t sees = 1;
    probes::ShareInputs shares{1, 1, 1, false, &supporting, &factor, &sees, &length};
    CHECK(cell_of(probes::data_of(shares)).condition == Approx(2).epsilon(1e-5));
    // W(x) adds 2 / (1 + 2 pi x^2).
    shares.published = true;
    CHECK(cell_of(probes::data_of(shares)).condition == Approx(2 + 2 / (1 + 6.2831853)).epsilon(1e-5));

    // alpha = share w Y_0: one each; Y_0 = 0.28209479 = 1.1283792 / 4 comes from the table, and its ULP is eps / 1.1283792 of it.
    const std::vector<std::int32_t> rows = probes::coefficient_rows(1, 0);
    const glm::vec4 seen(0, 0, 2, 1);
    const probes::CoefficientsInputs alpha{1, 1, 1, 0, rows.data(), &supporting, &seen, &sees, &share};
    CHECK(cell_of(probes::data_of(alpha)).condition == Approx(2 + 1 / 1.1283792).epsilon(1e-5));

    // f = rho / pi I: one each; of a texel alone no place moves it. c I: of c, too, and not of rho.
    const Buffer<glm::vec4> surface = {{0.5f, 0.5f, 0.5f, 1}}, none = {{0, 0, 0, 0}}, middle = {{0.5f, 0.5f, 0, 0}}, one_w = {{1, 1, 1, 0}};
    const Image4 lightmap(1, 1, glm::vec4(2));
    probes::RadianceInputs ray;
    ray.probes = ray.rays = 1, ray.constant = 0.25f;
    ray.surface = &surface, ray.emitted = &none, ray.direct = &none, ray.place = &middle, ray.lightmap = &lightmap;
    for (const probes::Feedback f : {probes::Feedback::corrected, probes::Feedback::constant, probes::Feedback::material}) {
        ray.feedback = f;
        CHECK(cell_of(probes::data_of(ray)).condition == Approx(2).epsilon(1e-5));
    }
    // What is emitted is there as it is.
    const Buffer<glm::vec4> black = {{0, 0, 0, 0}};
    ray.surface = &black, ray.emitted = &one_w;
    CHECK(cell_of(probes::data_of(ray)).condition == Approx(1).epsilon(1e-5));

    // lambda = w f Y: one each.
    const Buffer<glm::vec4> radiance = {{0.25f, 2, 1, 0}};
    const Buffer<float> harmonics = {-0.5f}, weights = {4};
    const std::vector<std::int32_t> level = {0};
    probes::LambdaInputs lambda;
    lambda.probes = lambda.rays = lambda.coefficients = 1, lambda.level_rays = {1}, lambda.level_coefficients = {1};
    lambda.radiance = &radiance, lambda.harmonics = &harmonics, lambda.weights = &weights, lambda.probe_level = &level;
    CHECK(cell_of(probes::data_of(lambda)).condition == Approx(3).epsilon(1e-5));
    // b = m lambda, I = u b: one each. Of two terms of opposite signs, 1 and 3/4, both of a factor that is moved each:
    // 2 (1 + 3/4) / (1 - 3/4) = 14.
    probes::ClusterData d;
    d.coefficients = 2, d.singular_values = 1;
    d.clusters = {{0, 0, 1, 1}}, d.cluster_probes = {0}, d.matrix = {1, 1}, d.u = {1}, d.receiver = {0}, d.cluster = {0};
    const std::int32_t finest = 0;
    const glm::vec4 two[] = {{1, 1, 1, 0}, {-0.75f, -0.75f, -0.75f, 0}}, b(1, 2, 4, 0);
    probes::BasisInputs basis;
    basis.clusters = &d, basis.cluster_level = &finest, basis.lambda = two, basis.probes = 1, basis.coefficients = {1, 1, 1, 1};
    CHECK(cell_of(probes::data_of(basis)).condition == Approx(2).epsilon(1e-5));
    basis.coefficients = {2, 2, 2, 2};
    CHECK(cell_of(probes::data_of(basis)).condition == Approx(2 * 1.75 / 0.25).epsilon(0.25));
    CHECK(cell_of(probes::data_of(probes::IrradianceInputs{&d, &finest, &finest, &b})).condition == Approx(2).epsilon(1e-5));
    // A value is copied, a mean is one of its parts each: 1.
    const Image<std::int32_t> cover = probes::lightmap_cover({{1, 1}}, {0}, 3, 1);
    CHECK(cell_of(probes::data_of(probes::LightmapInputs{&cover, &b, 1})).condition == Approx(1).epsilon(1e-5));
}

TEST_CASE("stability: every case of a bake by hand is within its budget, or is refused as it says", "[stability][probes]") {
    const std::set<std::string> refused = {"radius of 1e-20", "denormal weights", "weights that are no numbers", "hits infinitely far",
                                           "hits 2^61 m from a probe", "a hit that is no number", "rays at a level that there is not",
                                           "rays that half reflect", "a probe of a level that there is not", "a probe that is not there"};
    std::set<std::string> names, stages;
    for (const BakeCase& c : bake_cases()) {
        CHECK(names.insert(c.name).second);
        if (c.group == "radiosity" || c.group == "reuse") continue;  // test_stability_radiosity.cpp
        const std::vector<Cell> cells = bake_cells(c.data(), "", {});
        REQUIRE(!cells.empty());
        for (const Cell& cell : cells) {
            CAPTURE(c.name, cell.stage, cell.used, cell.condition, cell.nonfinite, cell.reason);
            CHECK(cell.ok);
            CHECK(cell.refused == (refused.count(c.name) == 1));
            CHECK(cell.budget == 16);
            stages.insert(cell.stage);
        }
    }
    // What is hard of the others their scenes have.
    for (const char* of_scenes : {"probes.volume", "probes.lightmap_uv", "probes.lookup", "probes.relief", "probes.indirect_shadow"}) stages.insert(of_scenes);
    CHECK(stages == all_stages);
    for (const std::string& name : refused) CHECK(names.count(name) == 1);
}

TEST_CASE("stability: the stages of a bake have cells in a room of 0.2 mm and of 2000 km, far away, and of slivers",
          "[stability][probes]") {
    for (const char* name : {"room", "scale 1e-4", "scale 1e6", "offset 1e3", "offset 1e6", "slivers", "guard band"}) {
        const Case& c = case_named(name);
        REQUIRE(is_baked(c));
        const std::vector<StageData> data = bake_data(c.scene(), {});
        std::set<std::string> stages;
        for (const Cell& cell : bake_cells(data, "", {})) {
            CAPTURE(name, cell.stage, cell.used, cell.condition, cell.nonfinite, cell.reason);
            CHECK(cell.ok);
            CHECK_FALSE(cell.refused);
            CHECK(cell.pixels > 0);
            // Rounding is there, and it is seen; of a level, a whole number, only where it turns.
            if (cell.stage != "probes.level") CHECK(cell.used > 0);
            stages.insert(cell.stage);
        }
        CHECK(stages == all_stages);
        // One stage alone has the same cell.
        const std::vector<Cell> alone = bake_cells(data, "probes.supports", {});
        REQUIRE(alone.size() == 1);
        CHECK(alone[0].stage == "probes.supports");
    }
    // What a bake does not see makes no cells.
    for (const char* name : {"light ratio 1e-3", "distance 0", "reflectance 1"}) CHECK_FALSE(is_baked(case_named(name)));
    CHECK(is_of_bake("probes.share"));
    CHECK_FALSE(is_of_bake("probes.clusters"));
    CHECK_FALSE(is_of_bake("rsm.disc"));
}

TEST_CASE("stability: the cells of a bake are the same on one thread and on four", "[stability][probes][bits]") {
    const Scene scene = case_named("scale 1e2").scene();
    Effort one, four;
    one.run.threads = 1, four.run.threads = 4;
    const std::vector<Cell> a = bake_cells(bake_data(scene, one.run), "", one), b = bake_cells(bake_data(scene, four.run), "", four);
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        CAPTURE(a[i].stage);
        CHECK((a[i].used == b[i].used && a[i].condition == b[i].condition && a[i].rel_error == b[i].rel_error && a[i].flips == b[i].flips));
    }
}
