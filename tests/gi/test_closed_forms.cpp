// The path tracer, ambient occlusion and the gather against light whose amount is known. The list of cases is that of
// `plumb experiment closed-forms`, here with fewer paths.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>

#include "gi/reference/closed_forms.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

const ClosedForm& form_named(const std::string& name) {
    static const std::vector<ClosedForm> forms = closed_forms();
    for (const ClosedForm& f : forms)
        if (f.name == name) return f;
    FAIL("no closed form is named " << name);
    throw;
}

}  // namespace

TEST_CASE("closed forms: all agree within 4 standard errors, and these are honest", "[reference][analytic]") {
    ClosedFormOptions options;
    options.error = 0.004;
    double squares = 0;
    int noisy = 0;
    for (const ClosedForm& form : closed_forms()) {
        // Cases that take few rays are repeated, for the sake of the statistics.
        std::uint64_t rays = 0;
        for (options.seed = 1; options.seed <= 3 && rays < 500000; ++options.seed) {
            const Measured m = measure(form, options);
            rays = m.rays;
            // The bound of 0.2 % is for `plumb experiment`, which runs longer.
            ClosedForm loose = form;
            if (form.statistical) loose.bound = 5 * options.error;
            const Verdict v = judge(loose, m, 4);
            CAPTURE(form.name, options.seed, form.expected, m.got, m.standard_error, v.relative, v.sigmas, m.nonfinite);
            CHECK(v.agrees);
            CHECK(m.standard_error <= 1.5 * options.error * std::abs(form.expected));
            if (!is_noisy(form, m)) continue;
            squares += v.sigmas * v.sigmas;
            ++noisy;
        }
    }
    // Chi-square: of k squares of normal numbers the mean is 1 with a standard deviation of sqrt(2 / k). A standard
    // error that is too small by a fifth or too large by a third falls out.
    CAPTURE(noisy, squares / noisy);
    CHECK(noisy > 170);
    CHECK(std::abs(squares / noisy - 1) < 3.3 * std::sqrt(2.0 / noisy));
}

TEST_CASE("closed forms: our own rays agree as well", "[reference][analytic]") {
    ClosedFormOptions options;
    options.error = 0.004;
    options.rays = Rays::exact;
    for (const char* name :
         {"form factor: perpendicular unit squares", "openness: sphere of radius 0.5 at height 0.5, 0.75 aside",
          "furnace: cube, rho 0.8", "sphere: lamp at (0.3, 0.2, -0.4), rho 0.2", "concentric spheres: F21",
          "mirror: emitter seen in a ceiling, all"}) {
        ClosedForm form = form_named(name);
        form.bound = 5 * options.error;
        const Measured m = measure(form, options);
        const Verdict v = judge(form, m, 4);
        CAPTURE(name, form.expected, m.got, m.standard_error, v.sigmas);
        CHECK(v.agrees);
    }
}

TEST_CASE("closed forms: expected values are the published ones", "[reference][analytic]") {
    // As verification.md 3 lists them.
    const std::pair<const char*, double> known[] = {
        {"form factor: unit square at 1", 0.239456470460774},
        {"form factor: unit wall, 0.5 from its foot", 0.190135882384807},
        {"form factor: unit wall, 0.02 from its foot", 0.484323815518066},
        {"form factor: opposed unit squares", 0.199824895698387},
        {"form factor: perpendicular unit squares", 0.200043776075403},
        {"form factor: disc of radius 0.5 at 0.5", 0.5},
        {"openness: sphere of radius 0.5 at height 1, 0 aside", 0.75},
        {"furnace: sphere, rho 0.95", 20},
        {"concentric spheres: H1 at rho 0.5", 2.0 / 9},
        {"unit cube: one face emits, rho 0.5", 1.0 / 3},
    };
    for (const auto& [name, value] : known) {
        CAPTURE(name);
        CHECK(form_named(name).expected == Approx(value).epsilon(1e-13).margin(0));
    }
    const std::pair<const char*, double> lux[] = {
        {"0.2", 26.042}, {"0.5", 104.167}, {"0.8", 416.667}, {"0.95", 1979.167}};
    for (const auto& [rho, value] : lux)
        CHECK(form_named(std::string("CIE 171:2006 case 5.8: indirect, rho ") + rho).expected ==
              Approx(value).margin(0.0005));
}

TEST_CASE("closed forms: names differ, and with them the random numbers", "[reference]") {
    std::set<std::string> names;
    for (const ClosedForm& form : closed_forms()) {
        CAPTURE(form.name);
        CHECK(names.insert(form.name).second);
        CHECK(std::isfinite(form.expected));
        CHECK(form.bound > 0);
    }
    ClosedForm probe;
    probe.run = [](const ClosedFormOptions& o) { return Measured{double(o.seed)}; };
    probe.name = "one";
    const double one = measure(probe, {}).got;
    CHECK(measure(probe, {}).got == one);
    ClosedFormOptions other;
    other.seed = 2;
    CHECK(measure(probe, other).got != one);
    probe.name = "two";
    CHECK(measure(probe, {}).got != one);
}

TEST_CASE("closed forms: a verdict fails closed", "[reference]") {
    ClosedForm form;
    form.expected = 2;
    form.bound = 0.002;
    auto agrees = [&](double got, double error, std::size_t nonfinite = 0) {
        Measured m;
        m.got = got, m.standard_error = error, m.nonfinite = nonfinite;
        return judge(form, m).agrees;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    CHECK(agrees(2, 0.001));
    CHECK(agrees(2.0029, 0.001));
    CHECK_FALSE(agrees(2.0031, 0.001));  // 3.1 standard errors
    CHECK(agrees(2.0039, 0.01));
    CHECK_FALSE(agrees(2.0041, 0.01));  // 0.205 %
    CHECK_FALSE(agrees(1.9959, 0.01));
    CHECK(agrees(2.000005, 0));  // rounding of floats
    CHECK_FALSE(agrees(2.0001, 0));
    CHECK_FALSE(agrees(2, 0.001, 1));
    for (double bad : {nan, infinity, -infinity}) {
        CHECK_FALSE(agrees(bad, 0.001));
        CHECK_FALSE(agrees(2, bad));
    }
    form.statistical = false;
    CHECK(agrees(2.0039, 0));
    CHECK_FALSE(agrees(2.0041, 0));
    CHECK_FALSE(agrees(nan, 0));
    form.statistical = true;
    form.expected = 0;
    CHECK(agrees(0, 0));
    CHECK_FALSE(agrees(1e-30, 0));
}
