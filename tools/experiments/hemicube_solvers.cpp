// plumb experiment hemicube: error against products with all rows, of passes as published (HEM 4.5.4) and of all other solvers.
#include <fmt/format.h>

#include <optional>

#include "core/formats.h"
#include "tools/experiments/hemicube_world.h"

namespace plumb::cli {

namespace {

using radiosity::Solver;
using Store = decltype(radiosity::SolveParams::store);

constexpr std::array budgets = {1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 96, 128, 192, 256};
constexpr std::array levels = {1e-2, 1e-3, 1e-4, 1e-5};
constexpr Solver solvers[] = {Solver::passes, Solver::shooting, Solver::gauss_seidel, Solver::bicgstab, Solver::conjugate_gradients, Solver::direct};

struct Point {
    double products = 0, error = 0, seconds = 0;
};

// The box with all reflectances as they are, or one everywhere.
class Study {
  public:
    Study(const radiosity::Elements& elements, const RowTransport& rows, const RunOptions& options) : elements_(elements), rows_(rows), options_(options) {
        truth_ = irradiance(Solver::direct, 1000, {}).second;
    }
    // store: what becomes of radiosities after each pass.
    std::vector<Point> curve(Solver solver, const Store& store = {}) const {
        std::vector<Point> points;
        for (const int budget : budgets) {
            const Clock::time_point start = Clock::now();
            const auto [solution, h] = irradiance(solver, budget, store);
            points.push_back({solution.products, mean_difference(h, truth_, elements_.area), seconds_since(start)});
            if (solver == Solver::direct) break;
        }
        return points;
    }

  private:
    // With the ambient term where there is one.
    std::pair<radiosity::Solution, Buffer<glm::vec4>> irradiance(Solver solver, int budget, const Store& store) const {
        radiosity::SolveParams p;
        p.solver = solver, p.tolerance = 0, p.most_products = budget, p.store = store;
        const radiosity::System system = system_of(elements_);
        radiosity::Solution s = radiosity::solve(system, rows_.transport(), p, options_);
        const Buffer<glm::vec4> b = radiosity::shown(s, system);
        return {std::move(s), rows_.irradiance(b, options_)};
    }

    const radiosity::Elements& elements_;
    const RowTransport& rows_;
    const RunOptions& options_;
    Buffer<glm::vec4> truth_;
};

std::string level_name(double level) { return fmt::format("products to {:g} %", 100 * level); }

IprSheet sheet_of(const std::string& title, const Study& study, const Tell& tell) {
    IprSheet sheet{"solvers, " + title, "error of irradiance against products with all rows",
                   "mean |error| of what elements gather from the solution, of its mean, against LU; those that estimate the radius first have its products counted in",
                   {}, {}, {}, {}};
    for (const double level : levels) sheet.heads.push_back({level_name(level), 1});
    sheet.heads.insert(sheet.heads.end(), {{"least error %", 5}, {"after 4 products %", 4}, {"after 16 %", 4}, {"a product: ms", 3}});
    page::Chart chart{title + ": error of irradiance", "products with all rows", "mean |error|, %", true, true, {}};
    for (const Solver solver : solvers) {
        tell(fmt::format("solvers: {}, {}", title, radiosity::solver_name(solver)));
        const std::vector<Point> points = study.curve(solver);
        IprSheetRow row{radiosity::solver_name(solver), "", {}, {}};
        page::ChartLine line{row.name, {}};
        double least = 1e300;
        for (const Point& p : points) {
            least = std::min(least, p.error);
            line.points.push_back({p.products, 100 * p.error, {}});
        }
        for (const double level : levels) {
            std::optional<double> products;
            for (const Point& p : points)
                if (!products && p.error <= level) products = p.products;
            row.values.push_back(products);
        }
        const auto after = [&](int budget) -> std::optional<double> {
            for (std::size_t i = 0; i < points.size(); ++i)
                if (budgets[i] == budget) return 100 * points[i].error;
            return {};
        };
        const bool direct = solver == Solver::direct;
        row.values.insert(row.values.end(), {100 * least, direct ? std::nullopt : after(4), direct ? std::nullopt : after(16),
                                             1e3 * points.back().seconds / points.back().products});
        sheet.rows.push_back(std::move(row)), chart.lines.push_back(std::move(line));
    }
    sheet.charts = {chart};
    return sheet;
}

// HEM 4.5.4: "4 to 16 iterations".
IprSheet passes_sheet(const std::vector<std::pair<std::string, const Study*>>& studies) {
    IprSheet sheet{"HEM 4.5.4", "n passes from black against the converged solution", "mean |error| of irradiance, %", {}, {}, {}, {}};
    std::vector<std::vector<Point>> curves;
    const Store rgbe = [](Buffer<glm::vec4>& b) {
        for (glm::vec4& v : b) v = glm::vec4(decode_rgbe(encode_rgbe(glm::vec3(v))), 0);
    };
    for (const auto& [title, study] : studies) {
        sheet.heads.insert(sheet.heads.end(), {{title, 4}, {title + ", B in RGBE", 4}});
        curves.push_back(study->curve(Solver::passes)), curves.push_back(study->curve(Solver::passes, rgbe));
    }
    for (std::size_t k = 0; k < budgets.size(); ++k) {
        if (budgets[k] > 64) continue;
        sheet.rows.push_back({fmt::format("{} passes", budgets[k]), budgets[k] >= 4 && budgets[k] <= 16 ? "within the thesis' 4 to 16" : "", {}, {}});
        for (const std::vector<Point>& curve : curves) sheet.rows.back().values.push_back(100 * curve[k].error);
    }
    return sheet;
}

}  // namespace

std::vector<IprSheet> measure_solvers(const HemicubeRequest& request, const RunOptions& options, const Tell& tell) {
    tell("solvers: rows");
    const Box box = benchmark_box(request.quick ? 300 : benchmark_meshes[0].triangles, false, options);
    radiosity::RowParams row;
    row.size = request.quick ? 16 : 64;
    const radiosity::FormFactors factors = radiosity::form_factors(box.elements, row, options);
    radiosity::Elements bright = box.elements, mirror_like = box.elements;
    for (glm::vec4& rho : bright.reflectance) rho = glm::vec4(glm::vec3(0.95f), 0);
    for (glm::vec4& rho : mirror_like.reflectance) rho = glm::vec4(glm::vec3(0.999f), 0);
    const RowTransport rows(factors, box.elements);
    const Study as_it_is(box.elements, rows, options), brighter(bright, rows, options), stiff(mirror_like, rows, options);
    const std::vector<std::pair<std::string, const Study*>> studies = {{"the box", &as_it_is}, {"rho 0.95", &brighter}, {"rho 0.999", &stiff}};
    std::vector<IprSheet> sheets = {passes_sheet(studies)};
    for (const auto& [title, study] : studies) sheets.push_back(sheet_of(title, *study, tell));
    return sheets;
}

}  // namespace plumb::cli
