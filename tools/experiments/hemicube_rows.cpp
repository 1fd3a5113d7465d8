// plumb experiment hemicube: one row of form factors as a hemicube makes it, and as cosine-distributed rays from the same eye do: error
// against time.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <functional>
#include <map>
#include <tuple>

#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/radiosity/ray_form_factors.h"
#include "gi/reference/ray_query.h"
#include "tools/experiments/hemicube_world.h"

namespace plumb::cli {

namespace {

using Row = std::vector<double>;

constexpr std::array hemicube_sizes = {16, 32, 64, 128, 256};
constexpr int cells = 8;                 // patches along each of a wall's edges
constexpr int fewest_rays = 1 << 8, most_rays = 1 << 20, more_rays = 4;
constexpr int rays_timed = 1 << 18;      // in one measurement, about

// How far rows are from the true ones, root mean square over eyes.
struct RowErrors {
    double elements = 0;  // sum over elements of |F - truth|
    double patches = 0;   // sum over patches of |sum over their elements of F - truth|
    double light = 0;     // |sum (F - truth) (B - M)| / sum truth (B - M): of what the box reflects
};
// Seconds of the processor, the least of some runs on one thread: the same on a busy machine, nearly.
double processor_seconds(int repeats, const std::function<void()>& work) {
    double least = 1e300;
    for (int run = 0; run < repeats; ++run) {
        const std::clock_t start = std::clock();
        work();
        least = std::min(least, double(std::clock() - start) / CLOCKS_PER_SEC);
    }
    return least;
}

double squared(double x) { return x * x; }

struct Measured {
    double samples = 0, seconds = 0;  // texels or rays, and the time, of one row
    RowErrors errors;
};

// Elements that look from where those of `all` do, in that order; the further ones look nowhere.
radiosity::Elements looking(const radiosity::Elements& all, const std::vector<int>& from) {
    radiosity::Elements some = all;
    for (std::size_t k = 0; k < some.eye.size(); ++k) {
        some.eye[k] = k < from.size() ? all.eye[std::size_t(from[k])] : glm::vec4(0);
        some.normal[k] = k < from.size() ? all.normal[std::size_t(from[k])] : glm::vec4(0);
    }
    return some;
}
std::vector<int> spread(int n, int count) {
    std::vector<int> index;
    for (int k = 0; k < count; ++k) index.push_back(int((2 * k + 1) * std::int64_t(n) / (2 * count)));
    return index;
}

class RowStudy {
  public:
    RowStudy(const HemicubeRequest& request, const RunOptions& options, const Tell& tell)
        : options_(options), repeats_(request.repeats), box_(benchmark_box(request.quick ? 1200 : benchmark_meshes.back().triangles, false, options)),
          eyes_(spread(box_.elements.count(), request.quick ? 8 : 32)), timed_eyes_(spread(box_.elements.count(), std::min(radiosity::rows_of_block, box_.elements.count()))),
          surfaces_(raster::prepare(box_.scene, box_.elements.geometry)) {
        one_thread_ = options, one_thread_.threads = 1;
        tell("rows: light");
        const radiosity::FormFactors rough = radiosity::form_factors(box_.elements, {16, radiosity::Weights::exact}, options);
        const RowTransport rows(rough, box_.elements);
        const Buffer<glm::vec4> all = radiosity::floats_of(converged(box_.elements, rows, options));
        for (std::size_t i = 0; i < all.size(); ++i) light_.push_back(luminance_of(all[i] - box_.elements.exitance[i]));
        group();
        tell("rows: truth");
        truth_ = hemicube_rows(request.quick ? 256 : radiosity::largest_hemicube);
    }
    const Box& box() const { return box_; }
    int truth_size(bool quick) const { return quick ? 256 : radiosity::largest_hemicube; }
    std::size_t eyes() const { return eyes_.size(); }
    int patches() const { return patches_; }

    Measured hemicube(int size) const {
        const radiosity::Elements some = looking(box_.elements, timed_eyes_);
        const double seconds = processor_seconds(repeats_, [&] { radiosity::row_blocks(some, {size, radiosity::Weights::exact}, one_thread_, 0, 1); });
        return {3.0 * size * size, seconds / double(timed_eyes_.size()), errors_of_rows(hemicube_rows(size))};
    }
    Measured rays(int count) const {
        const std::vector<glm::dvec3> directions = radiosity::cosine_directions(count);
        const auto native = reference::build_ray_query(box_.elements.geometry, surfaces_, Rays::native);
        const auto exact = reference::build_ray_query(box_.elements.geometry, surfaces_, Rays::exact);
        const std::vector<int> from = spread(box_.elements.count(), std::clamp(rays_timed / count, 1, 64));
        Row row;
        const double seconds = processor_seconds(repeats_, [&] {
            for (const int eye : from) {
                row.assign(std::size_t(box_.elements.count()), 0.0);
                radiosity::add_ray_row(*native, box_.elements, eye, directions, row);
            }
        });
        std::vector<Row> rows(eyes_.size(), Row(std::size_t(box_.elements.count()), 0.0));
        parallel_bands(int(eyes_.size()), 1, options_, [&](int first, int last) {
            for (int k = first; k < last; ++k)
                radiosity::add_ray_row(*exact, box_.elements, eyes_[std::size_t(k)], directions, rows[std::size_t(k)]);
        });
        return {double(count), seconds / double(from.size()), errors_of_rows(rows)};
    }

  private:
    // By wall, and by where on it.
    void group() {
        const radiosity::Elements& e = box_.elements;
        glm::vec3 low(e.position[0]), high = low;
        for (const glm::vec4& p : e.position) low = glm::min(low, glm::vec3(p)), high = glm::max(high, glm::vec3(p));
        std::map<std::tuple<int, int, int, int>, int> number;
        for (std::size_t i = 0; i < e.position.size(); ++i) {
            const glm::vec3 n(e.normal[i]), size = glm::abs(n);
            const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
            const auto cell = [&](int a) {
                return std::clamp(int(cells * (double(e.position[i][a]) - double(low[a])) / (double(high[a]) - double(low[a]))), 0, cells - 1);
            };
            const auto key = std::tuple(axis, n[axis] > 0 ? 1 : 0, cell((axis + 1) % 3), cell((axis + 2) % 3));
            patch_.push_back(number.try_emplace(key, int(number.size())).first->second);
        }
        patches_ = int(number.size());
    }
    std::vector<Row> hemicube_rows(int size) const {
        radiosity::FormFactors f;
        f.count = box_.elements.count();
        f.blocks = radiosity::row_blocks(looking(box_.elements, eyes_), {size, radiosity::Weights::exact}, options_, 0, 1);
        std::vector<Row> rows;
        std::vector<float> row;
        for (int k = 0; k < int(eyes_.size()); ++k) {
            row.assign(std::size_t(f.count), 0.0f);
            f.add_row(k, row);
            rows.emplace_back(row.begin(), row.end());
        }
        return rows;
    }
    RowErrors errors_of_rows(const std::vector<Row>& rows) const {
        RowErrors sum;
        for (std::size_t k = 0; k < rows.size(); ++k) {
            std::vector<double> patch(std::size_t(patches_), 0.0);
            double elements = 0, patches = 0, light = 0, all = 0;
            for (std::size_t j = 0; j < rows[k].size(); ++j) {
                const double d = rows[k][j] - truth_[k][j];
                elements += std::fabs(d), patch[std::size_t(patch_[j])] += d, light += d * light_[j], all += truth_[k][j] * light_[j];
            }
            for (const double d : patch) patches += std::fabs(d);
            sum.elements += squared(elements), sum.patches += squared(patches), sum.light += squared(light / all);
        }
        const double n = double(rows.size());
        return {std::sqrt(sum.elements / n), std::sqrt(sum.patches / n), std::sqrt(sum.light / n)};
    }

    const RunOptions options_;
    RunOptions one_thread_;
    int repeats_;
    Box box_;
    std::vector<int> eyes_, timed_eyes_;  // elements whose rows are compared, and timed
    raster::Surfaces surfaces_;
    std::vector<double> light_;           // luminance of what each element reflects
    std::vector<int> patch_;              // of each element
    int patches_ = 0;
    std::vector<Row> truth_;
};

constexpr std::array<double RowErrors::*, 3> error_kinds = {&RowErrors::elements, &RowErrors::patches, &RowErrors::light};
constexpr std::array error_names = {"elements", "patches", "light"};

void add_measured(IprSheet& sheet, const std::string& name, const Measured& m) {
    sheet.rows.push_back({name, "", {m.samples, 1e6 * m.seconds}, {}});
    for (const auto kind : error_kinds) sheet.rows.back().values.push_back(100 * m.errors.*kind);
}

page::ChartLine error_line(const std::string& name, const std::vector<Measured>& all, double RowErrors::* kind) {
    page::ChartLine line{name, {}};
    for (const Measured& m : all) line.points.push_back({1e6 * m.seconds, 100 * m.errors.*kind, {{"samples", fmt::format("{:.0f}", m.samples)}}});
    return line;
}

}  // namespace

std::optional<double> where_it_falls_to(const std::vector<double>& x, const std::vector<double>& y, double level) {
    for (std::size_t i = 1; i < x.size(); ++i) {
        if (!(y[i - 1] >= level && y[i] <= level)) continue;
        const double a = host::log(y[i - 1]), b = host::log(y[i]), share = a > b ? (a - host::log(level)) / (a - b) : 0;
        return host::exp(host::log(x[i - 1]) + share * (host::log(x[i]) - host::log(x[i - 1])));
    }
    return std::nullopt;
}

IprSheet measure_rows(const HemicubeRequest& request, const RunOptions& options, const Tell& tell) {
    const RowStudy study(request, options, tell);
    std::vector<Measured> hemicubes, rays;
    for (const int size : hemicube_sizes) {
        if (request.quick && size > 64) continue;
        tell(fmt::format("rows: hemicubes of {}", size));
        hemicubes.push_back(study.hemicube(size));
    }
    for (int count = fewest_rays; count <= (request.quick ? 1 << 16 : most_rays); count *= more_rays) {
        tell(fmt::format("rows: {} rays", count));
        rays.push_back(study.rays(count));
    }
    IprSheet sheet{"rows", "a row of form factors by a hemicube, and by rays from its eye",
                   fmt::format("the box of {} vertices and {} triangles, one thread, seconds of the processor; root mean square over {} eyes against hemicubes of {}", study.box().elements.count(),
                               study.box().elements.geometry.triangles.size(), study.eyes(), study.truth_size(request.quick)),
                   {{"texels, rays"}, {"a row: us", 1}}, {}, {}, {}};
    for (const char* name : error_names) sheet.heads.push_back({fmt::format("{}: error %", name), 3});
    for (const char* name : error_names) sheet.heads.insert(sheet.heads.end(), {{fmt::format("rays as good, {}", name)}, {fmt::format("their time / ours, {}", name), 1}});
    const auto of_rays = [&](const std::function<double(const Measured&)>& value) {
        std::vector<double> all;
        for (const Measured& m : rays) all.push_back(value(m));
        return all;
    };
    for (std::size_t i = 0; i < hemicubes.size(); ++i) {
        const Measured& h = hemicubes[i];
        add_measured(sheet, fmt::format("hemicube {}", hemicube_sizes[i]), h);
        for (const auto kind : error_kinds) {
            const std::vector<double> errors = of_rays([&](const Measured& m) { return m.errors.*kind; });
            const auto count = where_it_falls_to(of_rays([](const Measured& m) { return m.samples; }), errors, h.errors.*kind);
            const auto seconds = where_it_falls_to(of_rays([](const Measured& m) { return m.seconds; }), errors, h.errors.*kind);
            sheet.rows.back().values.push_back(count);
            sheet.rows.back().values.push_back(seconds ? std::optional(*seconds / h.seconds) : std::nullopt);
        }
    }
    for (const Measured& m : rays) {
        add_measured(sheet, fmt::format("{:.0f} rays", m.samples), m);
        sheet.rows.back().values.resize(sheet.heads.size());
    }
    sheet.lines = {
        fmt::format("elements: sum over elements of |F - truth|; patches: the same of {} patches of the walls; light: what the row makes of all that the box reflects.", study.patches()),
        "Rays are stratified and have no other work than to be traced and to be added to the row: their directions are made once and sorted. Rays as good: where the curve of "
        "rays, straight between what was measured, has the hemicube's error; - is beyond it."};
    for (std::size_t k = 0; k < error_kinds.size(); ++k)
        sheet.charts.push_back({fmt::format("error of a row: {}", error_names[k]), "a row, us", "%", true, true,
                                {error_line("hemicubes", hemicubes, error_kinds[k]), error_line("rays", rays, error_kinds[k])}});
    return sheet;
}

}  // namespace plumb::cli
