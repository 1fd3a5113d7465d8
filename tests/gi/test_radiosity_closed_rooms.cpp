// The method's hemicubes, rows and solvers, as a frame runs them, in rooms whose light is known; numbers of verification.md, section
// 3, where nothing else is said.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "gi/frame/frame.h"
#include "gi/radiosity/contour.h"
#include "tests/gi/radiosity_scenes.h"
#include "tests/gi/radiosity_systems.h"

using namespace plumb;
using namespace plumb::radiosity;
using Catch::Matchers::Contains;

namespace {

// What a frame makes that looks from near the origin's corner into the room.
frame::RadiosityBuffers framed(Scene scene, const RadiosityParams& params) {
    glm::vec3 low, high;
    bounds(flatten(scene), low, high);
    const glm::dvec3 size = glm::dvec3(high) - glm::dvec3(low);
    scene.camera.position = glm::dvec3(low) + 0.11 * size, scene.camera.look_at = glm::dvec3(low) + glm::dvec3(0.6, 0.55, 0) * size;
    scene.camera.near = 1e-3 * size.x, scene.frame_size = {16, 12}, scene.method = "radiosity";
    frame::Settings settings = frame::settings_of(scene);
    settings.radiosity = params, settings.pruning = false;
    frame::Frame frame = frame::execute(scene, settings, frame::plan(scene, settings), {});
    for (const glm::vec4& r : frame.radiance.texels) REQUIRE(std::isfinite(r.x + r.y + r.z));
    return std::move(frame.radiosity);
}

RadiosityParams with(int size, Kind kind, SolverChoice solver = SolverChoice::automatic, float tolerance = 1e-5f) {
    RadiosityParams p;
    p.size = size, p.kind = kind, p.solver = solver, p.tolerance = tolerance;
    return p;
}

// cube()'s face that the element is of: its normal points inwards.
int face_of(const Elements& e, int i) {
    const glm::vec4& n = e.normal[std::size_t(i)];
    for (int axis = 0; axis < 3; ++axis)
        if (std::fabs(n[axis]) > 0.9f) return 2 * axis + (n[axis] < 0 ? 1 : 0);
    FAIL("an element of no face");
    return 0;
}

// By the areas that elements stand for.
std::array<double, 6> face_means(const Elements& e, const std::vector<glm::dvec3>& values) {
    std::array<double, 6> sum{}, area{};
    for (int i = 0; i < e.count(); ++i) {
        const std::size_t f = std::size_t(face_of(e, i)), at = std::size_t(i);
        sum[f] += e.area[at] * values[at].x, area[f] += e.area[at];
    }
    for (std::size_t f = 0; f < 6; ++f) sum[f] /= area[f];
    return sum;
}
std::array<double, 6> face_radiosities(const frame::RadiosityBuffers& b) { return face_means(b.elements, b.solved.solution.radiosity); }

// One element a face: form factors between whole faces, from hemicubes all over them.
DenseSystem face_averaged(const frame::RadiosityBuffers& b) {
    DenseSystem s(6);
    std::array<double, 6> area{};
    std::vector<float> row;
    for (int i = 0; i < b.elements.count(); ++i) {
        const int f = face_of(b.elements, i);
        row.assign(std::size_t(b.elements.count()), 0.0f);
        b.factors.add_row(i, row);
        const double a = b.elements.area[std::size_t(i)];
        area[std::size_t(f)] += a;
        for (int j = 0; j < b.elements.count(); ++j) s.at(f, face_of(b.elements, j)) += a * double(row[std::size_t(j)]);
    }
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) s.at(i, j) /= area[std::size_t(i)];
    return s;
}

test::CubeFaces one_emits(double rho) {
    test::CubeFaces faces;
    faces.reflectance.fill(rho), faces.emission[0] = 1;
    return faces;
}

}  // namespace

TEST_CASE("radiosity: a cube of one element a face, by hemicubes, has the table's radiosities", "[radiosity][frame][HEM 4.5.4][analytic]") {
    const frame::RadiosityBuffers b = framed(test::cube(8, one_emits(0.5)), with(64, Kind::triangles));
    DenseSystem s = face_averaged(b);
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) {
            const double truth = i == j ? 0 : i / 2 == j / 2 ? opposite_square : adjacent_square;
            CHECK(s.at(i, j) == Approx(truth).margin(2e-4));
        }
    for (const double rho : {0.5, 0.8, 0.95, 0.99}) {
        s.reflect(float(rho)), s.exitance[0] = glm::vec4(1, 1, 1, 0);
        const std::array<double, 3> table = cube_radiosity(rho);
        const Solution x = solved(s, Solver::bicgstab, 1e-8);
        double worst = 0;
        for (int i = 0; i < 6; ++i) worst = std::max(worst, std::fabs(x.radiosity[std::size_t(i)].x / table[std::size_t(std::min(i, 2))] - 1));
        CAPTURE(rho, worst);
        CHECK(worst < 1e-3);
    }
}

TEST_CASE("radiosity: fine meshes of the cube come to the continuous radiosities", "[radiosity][frame][HEM 4.5.4][analytic]") {
    struct Row { double rho, emitter, opposite, side; };
    for (const Row& r : {Row{0.5, 1.1044, 0.1712, 0.1811}, Row{0.8, 1.5875, 0.6610, 0.6879}})
        for (const Kind kind : {Kind::vertices, Kind::triangles}) {
            const std::array<double, 6> b = face_radiosities(framed(test::cube(12, one_emits(r.rho)), with(32, kind)));
            CAPTURE(r.rho, int(kind), b[0], b[1], b[2], b[3], b[4], b[5]);
            CHECK(b[0] == Approx(r.emitter).epsilon(0.01));
            CHECK(b[1] == Approx(r.opposite).epsilon(0.01));
            for (int side = 2; side < 6; ++side) CHECK(b[std::size_t(side)] == Approx(r.side).epsilon(0.01));
            // One element a face would be at 1.0909 and 1.5517.
            CHECK(b[0] > cube_radiosity(r.rho)[0] + 0.5 * (r.emitter - cube_radiosity(r.rho)[0]));
        }
}

TEST_CASE("radiosity: six reflectances come to the continuous radiosities", "[radiosity][frame][analytic]") {
    const std::array<double, 6> rho = {0.9, 0.1, 0.5, 0.3, 0.7, 0.95};
    // Lambert's formula from the middles of 64 and 256 patches a face; what they miss shrinks by four at each halving.
    std::array<double, 6> mean[2];
    for (int fine = 0; fine < 2; ++fine) {
        const int m = 8 << fine;
        DenseSystem s = cube_of_patches(m, 0);
        for (int i = 0; i < s.n; ++i) s.reflectance[std::size_t(i)] = glm::vec4(float(rho[std::size_t(i / (m * m))]));
        const Solution x = solved(s, Solver::bicgstab, 1e-7);
        mean[fine].fill(0);
        for (int i = 0; i < s.n; ++i) mean[fine][std::size_t(i / (m * m))] += x.radiosity[std::size_t(i)].x / (m * m);
    }
    test::CubeFaces faces;
    faces.reflectance = rho, faces.emission[0] = 1;
    for (const Kind kind : {Kind::vertices, Kind::triangles}) {
        const std::array<double, 6> b = face_radiosities(framed(test::cube(12, faces), with(32, kind)));
        for (std::size_t f = 0; f < 6; ++f) {
            CAPTURE(int(kind), f, mean[0][f], mean[1][f]);
            CHECK(b[f] == Approx(mean[1][f] + (mean[1][f] - mean[0][f]) / 3).epsilon(0.01));
        }
    }
}

TEST_CASE("radiosity: concentric spheres are 10/9 and 2/9, by hemicubes", "[radiosity][frame][analytic]") {
    // Both polyhedra have the same shape: the ratio of their areas is that of the spheres.
    const auto means = [](int n, Kind kind) {
        const frame::RadiosityBuffers b = framed(test::concentric_spheres(0.5, 1, n, 0.5, 0.5, 1, 0), with(64, kind));
        double mean[2] = {0, 0}, area[2] = {0, 0};
        for (int i = 0; i < b.elements.count(); ++i) {
            const std::size_t at = std::size_t(i);
            const glm::vec4& p = b.elements.position[at];
            const int outer = p.x * p.x + p.y * p.y + p.z * p.z > 0.5f;
            const double got = b.solved.solution.radiosity[at].x;
            CHECK(got == Approx(outer ? 2.0 / 9 : 10.0 / 9).epsilon(0.05));
            mean[outer] += b.elements.area[at] * got, area[outer] += b.elements.area[at];
        }
        return glm::dvec2(mean[0] / area[0] * 0.9 - 1, mean[1] / area[1] * 4.5 - 1);  // relative errors
    };
    const glm::dvec2 triangles = means(8, Kind::triangles), coarse = means(6, Kind::vertices), fine = means(12, Kind::vertices);
    CAPTURE(triangles.x, triangles.y, coarse.x, coarse.y, fine.x, fine.y);
    CHECK(std::fabs(triangles.x) < 0.005);
    CHECK(std::fabs(triangles.y) < 0.01);
    CHECK(std::fabs(fine.x) < 0.002);
    CHECK(std::fabs(fine.y) < 0.008);
    CHECK(std::fabs(coarse.y) > 3 * std::fabs(fine.y));  // by the square of the edges' lengths: four times
}

TEST_CASE("radiosity: CIE 171:2006 case 5.8, mean indirect illuminance of a 4 m cube", "[radiosity][frame][CIE 171][analytic]") {
    // 10,000 lm from the middle; photometric numbers stand for radiometric ones.
    const auto ratio_to = [](double rho, double indirect, int n, Kind kind) {
        test::CubeFaces faces;
        faces.reflectance.fill(rho);
        Scene scene = test::cube(n, faces, 4);
        Light lamp;
        lamp.name = "lamp", lamp.type = LightType::point;
        lamp.position = {2, 2, 2}, lamp.intensity = glm::vec3(float(10000 / (4 * host::pi)));
        scene.lights = {lamp};
        const frame::RadiosityBuffers b = framed(scene, with(32, kind));
        double direct = 0, reflected = 0;
        for (std::size_t i = 0; i < b.irradiance.size(); ++i) {
            direct += b.elements.area[i] * double(b.lamps[i].x), reflected += b.elements.area[i] * double(b.irradiance[i].x);
        }
        CHECK(direct == Approx(10000).epsilon(0.01));  // of a point in each triangle, or linear between vertices
        return reflected / 96 / indirect;
    };
    for (const auto& [rho, indirect] : {std::pair(0.2, 26.042), {0.5, 104.167}, {0.8, 416.667}, {0.95, 1979.167}}) {
        CAPTURE(rho);
        CHECK(ratio_to(rho, indirect, 12, Kind::triangles) == Approx(1).epsilon(0.006));
    }
    // Vertices in a room's corners see little of what sees them: by the square of the edges' lengths.
    const double coarse = ratio_to(0.95, 1979.167, 8, Kind::vertices), fine = ratio_to(0.95, 1979.167, 16, Kind::vertices);
    CAPTURE(coarse, fine);
    CHECK(std::fabs(fine - 1) < 0.015);
    CHECK(std::fabs(coarse - 1) > 3 * std::fabs(fine - 1));
}

TEST_CASE("radiosity: near a reflectance of one rows of halves and sums of floats lose nothing of a closed room", "[radiosity][frame][analytic]") {
    for (const float rho : {0.5f, 0.9f, 0.99f, 0.999f, 0.9999f, 0.999999f}) {
        test::CubeFaces faces;
        faces.reflectance.fill(double(rho)), faces.emission.fill(1);
        const frame::RadiosityBuffers b = framed(test::cube(6, faces), with(32, Kind::vertices, SolverChoice::automatic, 1e-7f));
        const double exitance = double(b.elements.exitance[0].x), truth = exitance / (1 - double(rho));
        double worst = 0;
        for (const glm::dvec3& x : b.solved.solution.radiosity) worst = std::max(worst, std::fabs(x.x / truth - 1));
        CAPTURE(rho, worst, text_of(b.solved));
        CHECK(worst < 2e-7);
        CHECK(b.solved.solution.products <= 40);
    }
    // Where light is not even: one face emits, and the mean is 1 / (6 (1 - rho)) of its exitance, by what is absorbed.
    for (const float rho : {0.9f, 0.999f, 0.999999f})
        for (const SolverChoice solver : {SolverChoice::automatic, SolverChoice::bicgstab, SolverChoice::conjugate_gradients}) {
            const frame::RadiosityBuffers b = framed(test::cube(6, one_emits(double(rho))), with(32, Kind::triangles, solver, 1e-4f));
            const std::array<double, 6> face = face_radiosities(b);
            double mean = 0;
            for (const double x : face) mean += x / 6;
            CAPTURE(rho, int(solver), mean * 6 * (1 - double(rho)), text_of(b.solved));
            CHECK(b.solved.solution.converged);
            CHECK(b.solved.solution.products <= 40);
            CHECK(mean * 6 * (1 - double(rho)) == Approx(1).epsilon(0.01));
        }
}

TEST_CASE("radiosity: a tolerance of 0 is that many passes as published", "[radiosity][frame][HEM 4.5.4][analytic]") {
    test::CubeFaces faces;
    faces.reflectance.fill(0.75), faces.emission.fill(1);
    for (const int n : {1, 2, 5, 16}) {
        RadiosityParams p = with(16, Kind::vertices, SolverChoice::automatic, 0);
        p.passes = n;
        const frame::RadiosityBuffers b = framed(test::cube(4, faces), p);
        const double exitance = double(b.elements.exitance[0].x);
        CHECK(b.solved.solver == Solver::passes);
        CHECK(b.solved.solution.products == n);
        CHECK(int(b.solved.solution.curve.size()) == n);
        for (const glm::vec4& x : b.radiosity) REQUIRE(double(x.x) == Approx(exitance * (1 - std::pow(0.75, n)) / 0.25).epsilon(1e-6));
    }
}

TEST_CASE("radiosity: all solvers agree in a frame, and say what they took", "[radiosity][frame]") {
    const Scene scene = test::cube(5, one_emits(0.7));
    const std::vector<glm::dvec3> truth = framed(scene, with(32, Kind::vertices, SolverChoice::bicgstab, 1e-6f)).solved.solution.radiosity;
    for (int k = 0; k <= int(SolverChoice::direct); ++k) {
        const frame::RadiosityBuffers b = framed(scene, with(32, Kind::vertices, SolverChoice(k)));
        const Solution& s = b.solved.solution;
        const std::string text = text_of(b.solved);
        CAPTURE(text);
        if (k > 0) CHECK(b.solved.solver == Solver(k - 1));
        CHECK_THAT(text, Contains(solver_name(b.solved.solver)) && Contains("products with all rows") && Contains("estimated error") && Contains("converged"));
        CHECK(s.converged);
        CHECK(!s.curve.empty());
        // Those that turn rows round or average them solve for other rows: as far off as these are from reciprocal, and no more.
        const bool other = b.solved.solver == Solver::shooting || b.solved.solver == Solver::conjugate_gradients;
        double error = 0, all = 0;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            const glm::dvec3 d = s.radiosity[i] - truth[i];
            error += b.elements.area[i] * glm::dot(d, d), all += b.elements.area[i] * glm::dot(truth[i], truth[i]);
        }
        CHECK(std::sqrt(error / all) < (other ? s.row_residual / (1 - 0.7) : 2e-5));
        if (other) CHECK(s.row_residual > s.residual);
    }
}

TEST_CASE("radiosity: where all power goes, by the rows of a frame", "[radiosity][frame][analytic]") {
    const frame::RadiosityBuffers b = framed(test::cube(6, one_emits(0.8)), with(32, Kind::triangles, SolverChoice::automatic, 1e-6f));
    const Audit a = audit_of(b.solved, b.factors, b.elements, b.lamps, b.sky, b.emitters, {});
    const double emitted = 3 * double(b.elements.exitance[0].x);  // 1 m2, three channels
    CHECK(emitted > 0);
    CHECK(a.emitted == Approx(emitted).epsilon(1e-6));
    CHECK(a.incident == 0);
    CHECK(std::fabs(a.escaped) < 1e-5 * emitted);  // closed
    CHECK(std::fabs(a.unsolved) < 1e-5 * emitted);
    CHECK(std::fabs(a.unbalanced) < 1e-12 * emitted);
    CHECK(a.absorbed + a.not_reciprocal == Approx(emitted).epsilon(1e-5));
    CHECK(std::fabs(a.not_reciprocal) < 0.02 * emitted);
    CHECK(a.least_row == Approx(1).epsilon(1e-5));
    CHECK(a.largest_row == Approx(1).epsilon(1e-5));
    CHECK(a.exchange_rms > 0);
    CHECK(a.defect_rms > 0);
    CHECK(a.defect_rms < 0.3 * a.exchange_rms);
    // What a gather loses is no more than it is said to lose.
    CHECK(a.gather_off < 4 * transport_of(b.factors, b.elements).gather_loss);
    CHECK(transport_of(b.factors, b.elements).gather_loss < 1e-6);
}

TEST_CASE("radiosity: what small emitters send is emitted, M times A, and what of it does not arrive is told", "[radiosity][frame][analytic]") {
    // A lamp of 0.2 x 0.1 m, 7 W/m2, looks down from 0.9 m into a closed cube; into one without a ceiling, too; and on a floor alone.
    const double sent = 3 * 7 * 0.02;
    const auto lamp = [](Scene& s) { s.meshes.push_back(test::grid({0.4, 0.9, 0.45}, {0.2, 0, 0}, {0, 0, 0.1}, 1, 1, test::add_material(s, 0.5, 7))); };
    test::CubeFaces grey;
    grey.reflectance.fill(0.5);
    Scene room = test::cube(12, grey), floor;
    const int white = test::add_material(floor, 0.5);
    floor.meshes.push_back(test::grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 24, 24, white));
    lamp(room), lamp(floor);
    RadiosityParams p = with(32, Kind::vertices, SolverChoice::automatic, 1e-6f);
    p.small_emitters = 0.02f;
    const auto audited = [](const frame::RadiosityBuffers& b) { return audit_of(b.solved, b.factors, b.elements, b.lamps, b.sky, b.emitters, {}); };
    const frame::RadiosityBuffers closed = framed(room, p);
    for (const glm::vec4& m : closed.elements.exitance) REQUIRE(m == glm::vec4(0));
    const Audit a = audited(closed);
    CHECK(a.emitted == Approx(sent).epsilon(1e-5));
    CHECK(a.incident == 0);
    CHECK(std::fabs(a.not_arrived) < 0.01 * sent);
    CHECK(std::fabs(a.unbalanced) < 1e-12 * sent);
    CHECK(std::fabs(a.unsolved) < 1e-5 * sent);
    CHECK(a.absorbed + a.escaped + a.not_reciprocal == Approx(sent).epsilon(0.01));  // the lamp's back takes some
    // Of a floor alone, by the contour integral: the rest goes past it.
    const Audit open = audited(framed(floor, p));
    const Polygon down = {{0.4, 0.9, 0.45}, {0.6, 0.9, 0.45}, {0.6, 0.9, 0.55}, {0.4, 0.9, 0.55}}, up = {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}};
    const double arrives = polygon_form_factor(down, up).value;
    CHECK((arrives > 0.2 && arrives < 0.4));
    CHECK(open.emitted == Approx(sent).epsilon(1e-5));
    CHECK(open.not_arrived == Approx((1 - arrives) * sent).epsilon(2e-3));
    CHECK(open.incident == 0);
    CHECK(std::fabs(open.unbalanced) < 1e-12 * sent);
    // A lamp of no size stays incident light; seen by texels the emitter has the same power.
    Light key;
    key.name = "key", key.type = LightType::point, key.position = {0.5f, 0.5f, 0.5f}, key.intensity = {0.2f, 0, 0};
    Scene both = room;
    both.lights.push_back(key);
    const Audit with_lamp = audited(framed(both, p));
    CHECK(with_lamp.emitted == Approx(sent).epsilon(1e-5));
    CHECK(with_lamp.incident == Approx(4 * M_PI * 0.2).epsilon(0.02));
    CHECK(with_lamp.not_arrived == Approx(a.not_arrived).margin(1e-6 * sent));
    p.small_emitters = 0;
    const Audit by_texels = audited(framed(room, p));
    CHECK(by_texels.emitted == Approx(sent).epsilon(1e-5));
    CHECK(by_texels.not_arrived == 0);
}

TEST_CASE("radiosity: vertices inside walls, slivers and areas of a million to one", "[radiosity][frame][analytic]") {
    // A closed room, a box that stands in its floor, a sliver in the air and a speck on a wall's side: light is even where all emits
    // and reflects alike, whatever the shape, but for what backs take away.
    test::CubeFaces faces;
    faces.reflectance.fill(0.5), faces.emission.fill(1);
    Scene scene = test::cube(4, faces, 10);
    const int white = test::add_material(scene, 0.5, 1);
    const double low = -0.7;
    Mesh box = test::grid({3, low, 3}, {0, 0, 2}, {2, 0, 0}, 2, 2, white);  // below the floor: nobody sees it
    test::append(box, test::grid({3, 2, 3}, {0, 0, 2}, {2, 0, 0}, 2, 2, white));
    test::append(box, test::grid({3, low, 3}, {0, 0, 2}, {0, 2 - low, 0}, 2, 2, white));
    test::append(box, test::grid({5, low, 3}, {0, 2 - low, 0}, {0, 0, 2}, 2, 2, white));
    test::append(box, test::grid({3, low, 3}, {0, 2 - low, 0}, {2, 0, 0}, 2, 2, white));
    test::append(box, test::grid({3, low, 5}, {2, 0, 0}, {0, 2 - low, 0}, 2, 2, white));
    scene.meshes.push_back(box);
    scene.meshes.push_back(test::grid({7, 5, 2}, {0, 0, 6}, {1e-5, 0, 0}, 1, 1, white));
    scene.meshes.push_back(test::grid({8, 0.5, 8}, {0, 0, 1e-2}, {1e-2, 0, 0}, 1, 1, white));
    for (const SolverChoice solver : {SolverChoice::automatic, SolverChoice::bicgstab, SolverChoice::gauss_seidel, SolverChoice::direct}) {
        const frame::RadiosityBuffers b = framed(scene, with(32, Kind::vertices, solver));
        CAPTURE(text_of(b.solved));
        const double exitance = double(b.elements.exitance[0].x);
        double largest = 0;
        for (const glm::dvec3& x : b.solved.solution.radiosity) {
            REQUIRE(x.x >= exitance * (1 - 1e-6));  // each emits
            largest = std::max(largest, x.x);
        }
        CHECK(largest <= 2 * exitance * (1 + 2e-5));  // M / (1 - rho), nowhere more
        CHECK(largest > 1.9 * exitance);
        const Audit a = audit_of(b.solved, b.factors, b.elements, b.lamps, b.sky, b.emitters, {});
        CHECK(a.largest_row <= 1 + 1e-6);
        CHECK(std::fabs(a.unbalanced) < 1e-12 * a.emitted);
        CHECK(a.escaped > 0);  // to backs
    }
}

TEST_CASE("radiosity: what does not converge or has no end is refused in a line that names the scene", "[radiosity][frame][bad input]") {
    Scene scene = test::cube(3, one_emits(0.9));
    scene.name = "some room.toml";
    RadiosityParams p = with(16, Kind::vertices, SolverChoice::passes);
    p.passes = 3;
    CHECK_THROWS_WITH(framed(scene, p), Contains("some room.toml: radiosity: passes: not converged after 3 products") && Contains("tolerance = 1e-05") &&
                                            Contains("bicgstab"));
    p = with(16, Kind::vertices, SolverChoice::automatic, 1e-7f);
    p.passes = 5;
    CHECK_THROWS_WITH(framed(scene, p), Contains("some room.toml: radiosity: bicgstab: not converged"));
    Scene white = test::cube(3, one_emits(1));
    white.name = "white.toml";
    for (const SolverChoice solver : {SolverChoice::automatic, SolverChoice::gauss_seidel, SolverChoice::shooting})
        CHECK_THROWS_WITH(framed(white, with(16, Kind::vertices, solver)), Contains("white.toml: radiosity: element 0: reflects all light"));
    // A given number of passes ends.
    p = with(16, Kind::vertices, SolverChoice::passes, 0);
    p.passes = 4;
    CHECK(framed(white, p).solved.solution.products == 4);
    p = with(16, Kind::vertices, SolverChoice::direct);
    p.memory_mb = 1;
    Scene large = test::cube(8, one_emits(0.5));
    large.name = "large.toml";
    CHECK_THROWS_WITH(framed(large, p), Contains("large.toml: radiosity: direct: 486 elements need 0.00189 GB"));
    p.solver = SolverChoice::automatic;
    CHECK(framed(large, p).factors.bytes() < 1'000'000);
    CHECK_THROWS_WITH(framed(test::cube(12, one_emits(0.5)), p), Contains("1014 elements") && Contains("memory_mb = 4 or more"));
}
