// plumb experiment vrsm: what seeds scatter, and when the least of some numbers is told apart from the others.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tools/experiments/vrsm.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

compare::SignedErrors errors_of(double rms, double noise = 0) {
    compare::SignedErrors e;
    e.pixels = 1, e.rms = rms, e.noise = noise;
    return e;
}
VrsmErrors row_of(const std::vector<double>& rms, double noise = 0) {
    VrsmErrors row{true, rsm::Visibility::none, 0};
    for (const double v : rms) row.seeds.push_back(errors_of(v, noise));
    return row;
}
VrsmBeyond setting_of(const std::vector<double>& rms, glm::ivec2 samples, const char* set) {
    VrsmBeyond b{"", {}, samples};
    if (set) b.sets = {set};
    for (const double v : rms) b.seeds.push_back(errors_of(v));
    return b;
}

// What is marked of rows with those values: 'b' best, 't' tied, '.' neither.
std::string marks(std::vector<VrsmErrors> rows) {
    std::vector<VrsmErrors*> pointers;
    for (VrsmErrors& row : rows) pointers.push_back(&row);
    vrsm_mark_best(pointers);
    std::string text;
    for (const VrsmErrors& row : rows) text += row.best ? 'b' : row.tied ? 't' : '.';
    return text;
}

}  // namespace

TEST_CASE("experiment vrsm: a mean over seeds has the standard error of its closed form", "[experiment][analytic]") {
    // 1 to n: the variance is (n^2 - 1) / 12 times n / (n - 1), and the mean's a share 1/n of it.
    for (const int n : {2, 4, 9}) {
        std::vector<std::optional<double>> values;
        for (int i = 1; i <= n; ++i) values.push_back(double(i));
        const VrsmEstimate e = vrsm_estimate(values);
        CHECK(*e.mean == Approx((n + 1) / 2.0).epsilon(1e-12));
        CHECK(*e.error == Approx(std::sqrt((n * n - 1) / 12.0 / (n - 1))).epsilon(1e-12));
    }
    // Two: half of their difference.
    CHECK(*vrsm_estimate({3.0, 3.5}).error == Approx(0.25).epsilon(1e-12));
    // Equal ones scatter by nothing, though a third has no exact sum.
    const VrsmEstimate equal = vrsm_estimate({0.1, 0.1, 0.1});
    CHECK(*equal.mean == 0.1);
    CHECK(*equal.error == 0);
    const VrsmEstimate one = vrsm_estimate({0.7});
    CHECK(*one.mean == 0.7);
    CHECK_FALSE(one.error);
    CHECK_FALSE(vrsm_estimate({}).mean);
    CHECK_FALSE(vrsm_estimate({1.0, std::nullopt}).mean);
    CHECK_FALSE(vrsm_estimate({1.0, std::numeric_limits<double>::quiet_NaN()}).mean);
}

TEST_CASE("experiment vrsm: means are told apart by two standard errors of their difference", "[experiment]") {
    const VrsmEstimate a{1.0, 0.03}, near{1.09, 0.04}, far{1.11, 0.04}, one{2.0, {}}, none{}, exact{1.0, 0.0}, other{1.0 + 1e-9, 0.0};
    CHECK_FALSE(told_apart(a, near));  // 0.09 of 2 x 0.05
    CHECK(told_apart(a, far));
    CHECK(told_apart(far, a));
    for (const VrsmEstimate& unknown : {one, none}) CHECK_FALSE((told_apart(a, unknown) || told_apart(unknown, a)));
    CHECK_FALSE(told_apart(exact, exact));
    CHECK(told_apart(exact, other));
    CHECK(told_at_most({0.9, 0.05}, 1));
    CHECK_FALSE(told_at_most({0.9, 0.051}, 1));
    for (const VrsmEstimate& unknown : {one, none}) CHECK_FALSE(told_at_most(unknown, 100));
}

TEST_CASE("experiment vrsm: the least is marked where it is told apart from all others, and from the truth's noise", "[experiment]") {
    CHECK(marks({row_of({1.0, 1.1}), row_of({2.0, 2.1}), row_of({3.0, 3.1})}) == "b..");
    CHECK(marks({row_of({1.0, 1.1}), row_of({1.05, 1.2}), row_of({3.0, 3.1})}) == "tt.");
    // One seed says nothing of what it scatters.
    CHECK(marks({row_of({1.0}), row_of({2.0})}) == "tt");
    // The same bits, whatever they are.
    CHECK(marks({row_of({1.0, 1.0}), row_of({1.0, 1.0})}) == "tt");
    // A subset's truth whose noise is more than half of the rms.
    CHECK(marks({row_of({1.0, 1.1}, 0.5), row_of({2.0, 2.1}, 0.5)}) == "b.");
    CHECK(marks({row_of({1.0, 1.1}, 0.6), row_of({2.0, 2.1}, 0.6)}) == "tt");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(marks({row_of({nan, 1.0}), row_of({2.0, 2.1}), row_of({3.0, 3.1})}) == ".b.");
    CHECK(marks({row_of({nan, nan})}) == ".");
}

TEST_CASE("experiment vrsm: a truth against itself has no error, and is marked nowhere beside itself", "[experiment]") {
    compare::Plane truth(3, 2);
    for (std::size_t i = 0; i < truth.size(); ++i) truth.texels[i] = 0.3 + double(i);
    VrsmErrors row{true, rsm::Visibility::none, 0};
    for (int seed = 0; seed < 4; ++seed) row.seeds.push_back(compare::signed_errors(truth, truth));
    for (const VrsmEstimate& e : {row.rms(), row.estimate(&compare::SignedErrors::mean_error), row.estimate(&compare::SignedErrors::leaked),
                                  row.estimate(&compare::SignedErrors::too_dark)}) {
        CHECK(*e.mean == 0);
        CHECK(*e.error == 0);
    }
    CHECK(marks({row, row}) == "tt");
    CHECK(marks({row, row_of({1.0, 1.1, 1.05, 1.0})}) == "b.");
}

TEST_CASE("experiment vrsm: beyond the thesis wins what is told to err at most as much, for the least", "[experiment]") {
    Vrsm result;
    VrsmScene& scene = result.scenes.emplace_back();
    scene.beyond = {setting_of({1.0, 1.2}, {15, 10}, nullptr), setting_of({0.9, 1.0}, {8, 10}, "a"),
                    setting_of({0.999, 1.199}, {4, 16}, "b"), setting_of({0.9, 1.3}, {2, 10}, "c")};
    // Seed by seed the ratios are 0.9 and 0.83, 0.999 and 0.9992, 0.9 and 1.08.
    const VrsmEstimate ratio = relative_rms(scene.beyond[1], scene.beyond[0]);
    CHECK(*ratio.mean == Approx((0.9 + 1.0 / 1.2) / 2).epsilon(1e-12));
    CHECK(*ratio.error == Approx((0.9 - 1.0 / 1.2) / 2).epsilon(1e-12));
    CHECK(vrsm_winner(result) == 2u);
    // On another scene b is worse, and then nothing is left but a.
    result.scenes.push_back(scene);
    result.scenes[1].beyond[2] = setting_of({1.01, 1.21}, {4, 16}, "b");
    CHECK(vrsm_winner(result) == 1u);
    result.scenes[1].beyond[1] = setting_of({1.01, 1.21}, {8, 10}, "a");
    CHECK(vrsm_winner(result) == 0u);
    // One seed tells nothing: the thesis' own is left.
    for (VrsmScene& s : result.scenes)
        for (VrsmBeyond& b : s.beyond) b.seeds.resize(1);
    CHECK(vrsm_winner(result) == 0u);
}
