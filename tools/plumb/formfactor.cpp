// plumb formfactor: how much of what leaves A reaches B, by contour integral, hemicube and rays side by side.
#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "core/error.h"
#include "gi/radiosity/hemicube_factor.h"
#include "gi/radiosity/projections.h"
#include "gi/reference/ray_query.h"
#include "io/file.h"
#include "io/scene_file.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/formfactor_report.h"
#include "tools/shared/scene_command.h"

namespace plumb::cli {
namespace {

using namespace radiosity;

struct Given {
    std::string a, b, scene, sizes = "32,64,128,256,512", weights = "exact";
    Common common;
    std::int64_t rays = 1 << 18, seed = 1;
    int points = 64;
    double view_deg = 0;
    bool rotations = false, csv = false;
};

Weights parse_weights(const std::string& text) {
    constexpr const char* names[] = {"exact", "centre", "published"};
    for (int i = 0; i < 3; ++i)
        if (text == names[i]) return Weights(i);
    throw InputError("--weights " + io::printable(text) + ": expected exact, centre or published");
}

std::vector<int> parse_sizes(const std::string& text) {
    std::vector<int> sizes;
    for (std::size_t start = 0, end = 0; end != std::string::npos; start = end + 1) {
        end = text.find(',', start);
        const std::string word = text.substr(start, end == std::string::npos ? end : end - start);
        const bool number =
            !word.empty() && word.size() < 5 && word.find_first_not_of("0123456789") == std::string::npos;
        const int size = number ? std::stoi(word) : 0;
        if (size < 2 || size > 1024 || size % 2 != 0)
            throw InputError(
                fmt::format("--size {}: expected even numbers from 2 to 1024, 32,64 say", io::printable(text)));
        sizes.push_back(size);
    }
    return sizes;
}

// More pairs of faces take minutes.
constexpr std::size_t most_pairs = 4096;

void integrate(const ShapePair& pair, FormFactorReport& report) {
    const Shape &a = pair.a, &b = pair.b;
    report.pairs = (a.is_point() ? 1 : a.source.faces.size()) * b.source.faces.size();
    report.with_contour = report.pairs <= most_pairs;
    if (!report.with_contour) return;
    if (a.is_point()) {
        report.contour = {point_form_factor(a.source.point, a.source.normal, b.source.faces, b.sides()), 1e-15};
        return;
    }
    report.contour = surface_form_factor(a.source.faces, b.source.faces, b.sides());
    report.contour_back = surface_form_factor(b.source.faces, a.source.faces, Sides::front);
    if (b.closed) return;
    const ContourFactor other = surface_form_factor(turned(b.source).faces, a.source.faces, Sides::front);
    report.contour_back.value += other.value, report.contour_back.error += other.error;
}

// Rays from A to B; and back, from every side of B that A may see.
void shoot(const ShapePair& pair, const RayQuery& query, RayFactorParams params, const RunOptions& options,
           FormFactorReport& report) {
    const Geometry& g = pair.geometry;
    std::vector<std::int32_t> to_b(2 * g.triangles.size(), -1), to_a = to_b;
    for (const std::uint32_t t : pair.b.triangles) to_b[2 * t] = 0, to_b[2 * t + 1] = pair.b.closed ? -1 : 0;
    for (const std::uint32_t t : pair.a.triangles) to_a[2 * t] = 0;
    report.rays = ray_form_factors(query, g, pair.a.source, to_b, 1, params, options)[0];
    if (pair.a.is_point()) return;
    params.seed += 0x10000;
    report.rays_back = ray_form_factors(query, g, pair.b.source, to_a, 1, params, options)[0];
    if (pair.b.closed) return;
    params.seed += 0x10000;
    const RayFactor other = ray_form_factors(query, g, turned(pair.b.source), to_a, 1, params, options)[0];
    report.rays_back.value += other.value;
    report.rays_back.standard_error = std::sqrt(report.rays_back.standard_error * report.rays_back.standard_error +
                                                other.standard_error * other.standard_error);
}

void draw(const ShapePair& pair, const raster::Surfaces& surfaces, const Given& given, const std::vector<int>& sizes,
          const RunOptions& options, FormFactorReport& report) {
    const std::vector<SourcePoint> points = source_points(pair.a.source, given.points);
    report.points = int(points.size());
    for (const SourcePoint& p : points)
        report.at_points +=
            point_form_factor(p.position, p.normal, pair.b.source.faces, pair.b.sides()) / double(points.size());
    std::vector<std::int32_t> targets(2 * pair.geometry.triangles.size(), -1);
    for (const std::uint32_t t : pair.b.triangles) targets[2 * t] = 0, targets[2 * t + 1] = pair.b.closed ? -1 : 0;
    for (const int size : sizes)
        report.hemicubes.push_back(
            {size, hemicube_form_factor(pair.geometry, &surfaces, points, targets, size, parse_weights(given.weights),
                                        surface_offset(pair.geometry), options)});
    report.view_deg = given.view_deg;
    if (given.view_deg == 0) return;
    for (const auto& [projection, name] : {std::pair(Projection::plane, "plane"), std::pair(Projection::fish_eye, "fish-eye")})
        for (const int size : sizes) {
            const ProjectionParams p{projection, size_of_equal_texels(size), given.view_deg, false};
            report.projections.push_back(
                {name, p.size, projected_form_factor(pair.geometry, &surfaces, points, targets, p, surface_offset(pair.geometry), options)});
        }
}

int rotations(const Given& given) {
    if (!given.a.empty())
        throw InputError("--rotations: takes no A and B: the patch and the square are those of verification");
    const RunOptions options = given.common.run_options();
    std::vector<RotationRow> rows;
    for (const int size : parse_sizes(given.sizes))
        rows.push_back(
            {size, rotation_errors(size, Weights::exact, options), rotation_errors(size, Weights::centre, options)});
    std::fputs(given.common.json ? json_text(rotations_json(rows)).c_str()
               : given.csv       ? rotations_csv(rows).c_str()
                                 : rotations_text(rows).c_str(),
               stdout);
    return success;
}

int form_factor(const Given& given) {
    const RunOptions options = given.common.run_options();
    const std::vector<int> sizes = parse_sizes(given.sizes);
    parse_weights(given.weights);
    if (given.common.json && given.csv) throw InputError("--csv: not together with --json");
    if (given.rotations) return rotations(given);
    if (given.a.empty() || given.b.empty())
        throw InputError("formfactor: expected A and B; plumb formfactor --help tells how they are written");
    std::unique_ptr<Scene> scene;
    if (!given.scene.empty()) scene = std::make_unique<Scene>(io::load_scene(given.scene, frame::method_tables()));
    const ShapePair pair = find_shapes(given.a, given.b, scene.get());
    const raster::Surfaces surfaces = raster::prepare(pair.scene, pair.geometry);
    const auto query = reference::build_ray_query(pair.geometry, surfaces, Rays::exact);

    FormFactorReport report;
    report.a = &pair.a, report.b = &pair.b;
    report.weights = given.weights;
    RayFactorParams params;
    params.rays = given.rays, params.seed = std::uint32_t(given.seed);
    report.ray_count = (params.rays + params.batches - 1) / params.batches * params.batches;
    report.batches = params.batches;
    std::vector<std::int32_t> owner(pair.geometry.triangles.size(), -1);
    for (const std::uint32_t t : pair.a.triangles) owner[t] = 0;
    for (const std::uint32_t t : pair.b.triangles) owner[t] = 1;
    report.between =
        between(*query, pair.geometry, pair.a.source, pair.b.source, owner, pair.b.sides(), 16384, params.seed);
    integrate(pair, report);
    shoot(pair, *query, params, options, report);
    draw(pair, surfaces, given, sizes, options, report);
    judge(report);
    std::fputs(given.common.json ? json_text(form_factor_json(report)).c_str()
               : given.csv       ? form_factor_csv(report).c_str()
                                 : form_factor_text(report).c_str(),
               stdout);
    return report.agrees ? success : disagreement;
}

}  // namespace

void add_formfactor(CLI::App& program, Action& action) {
    auto given = std::make_shared<Given>();
    CLI::App* command = program.add_subcommand(
        "formfactor", "the form factor from A to B by contour integral, hemicubes and rays, each with its error");
    command
        ->add_option(
            "A", given->a,
            "an object, a material or a triangle's number of the scene; \"x,y,z;x,y,z;x,y,z\": a polygon, "
            "counter-clockwise from its front; \"x,y,z/nx,ny,nz\": a point and its normal. In brackets where it "
            "begins with a minus")
        ->check(some_word());
    command->add_option("B", given->b, "the same, but no point")->check(some_word());
    command
        ->add_option("--scene", given->scene,
                     "of which A and B are parts, and which may hide one from the other: .toml, .obj, .gltf or .glb")
        ->check(some_word())
        ->type_name("SCENE");
    command->add_option("--rays", given->rays, "rays from A, and as many from each side of B; 262144 otherwise")
        ->check(number_within(32, 1e9))
        ->type_name("N");
    command
        ->add_option("--size", given->sizes, "hemicubes, texels across, even, 2 to 1024; 32,64,128,256,512 otherwise")
        ->check(some_word())
        ->type_name("N,N,...");
    command->add_option("--points", given->points, "of A at which hemicubes stand, 1 to 65536; 64 otherwise")
        ->check(number_within(1, 65536))
        ->type_name("N");
    command->add_option("--weights", given->weights, "of a hemicube's texels: exact, centre or published (HEM 5.6)")
        ->check(some_word())
        ->type_name("W");
    command->add_option("--view", given->view_deg,
                        "beside hemicubes, one picture of that angle, as a plane and through a fish-eye, of as many texels (HEM 4.5.3); "
                        "1 to 179.9 degrees")
        ->check(number_within(1, 179.9))
        ->type_name("DEG");
    command->add_option("--seed", given->seed, "of rays and points, 0 to 65535; 1 otherwise")
        ->check(number_within(0, 65535))
        ->type_name("N");
    command->add_flag("--rotations", given->rotations,
                      "in place of A and B: how hemicubes err on a square as it turns by 0 to 90 degrees");
    command->add_flag("--csv", given->csv, "a line a method, in place of the table");
    add_common(*command, given->common);
    command->callback([given, &action] { action = [=] { return form_factor(*given); }; });
}

}  // namespace plumb::cli
