#include "gi/radiosity/solve_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/host_math.h"
#include "core/parallel.h"

namespace plumb::radiosity {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

[[noreturn]] void refuse(const std::string& cause) { throw InputError("radiosity: " + cause); }

// `most`: what no value is above.
Channels checked(const char* name, const Buffer<glm::vec4>* values, int count, float most) {
    Channels out(std::size_t(count), glm::dvec3(0));
    if (!values) return out;
    if (values->size() != std::size_t(count))
        refuse(fmt::format("{}: {} elements: {} expected", name, values->size(), count));
    for (int i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) {
            const float x = (*values)[i][c];
            if (!(x >= 0 && x <= most))
                refuse(fmt::format("{}: element {} is {:g}: expected {}", name, i, x,
                                   most == 1 ? "0 to 1" : "0 or more, finite"));
            out[i][c] = x;
        }
    return out;
}

std::vector<double> checked(const char* name, const std::vector<double>& values, int count) {
    if (values.size() != std::size_t(count))
        refuse(fmt::format("{}: {} elements: {} expected", name, values.size(), count));
    for (int i = 0; i < count; ++i)
        if (!(values[i] >= 0 && values[i] <= std::numeric_limits<float>::max()))
            refuse(fmt::format("{}: element {} is {:g}: expected 0 or more, finite", name, i, values[i]));
    return values;
}

double sum_of(const std::vector<double>& values) {
    double sum = 0;
    for (double v : values) sum += v;
    return sum;
}

void require_finite(const Channels& x) {
    for (std::size_t i = 0; i < x.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (!(std::fabs(x[i][c]) < infinite))
                refuse(fmt::format("element {} gathers {:g}: expected a finite irradiance", i, x[i][c]));
}

// The power of two that brings the largest to [1, 2).
double scale_of(const Channels& x) {
    double largest = 0, scale = 1;
    for (const glm::dvec3& v : x)
        for (int c = 0; c < 3; ++c) largest = std::max(largest, std::fabs(v[c]));
    if (!(largest > 0) || !(largest < infinite)) return 1;
    while (largest * scale >= 2) scale *= 0.5;
    while (largest * scale < 1 && scale < 0x1p1000) scale *= 2;
    return scale;
}

}  // namespace

Problem::Problem(const System& system, const Transport& t, const RunOptions& run)
    : count(t.count), transport(t), options(run), progress(run.progress) {
    options.progress = nullptr;
    if (count < 0) refuse(fmt::format("{} elements: expected 0 or more", count));
    if (!t.area || !t.gather || !t.row) refuse("a transport without areas, rows or gathering");
    constexpr float most = std::numeric_limits<float>::max();
    reflectance = checked("reflectance", system.reflectance, count, 1);
    exitance = checked("exitance", system.exitance, count, most);
    incident = checked("incident irradiance", system.incident, count, most);
    area = checked("area", *t.area, count);
    if (t.row_sums) checked("row sums", *t.row_sums, count);

    emission.resize(std::size_t(count));
    const double mean = sum_of(area) / std::max(count, 1);
    for (int i = 0; i < count; ++i) {
        emission[i] = exitance[i] + reflectance[i] * incident[i];
        weight.push_back(mean > 0 ? std::max(area[i], 0x1p-40 * mean) : 1.0);
        for (int c = 0; c < 3; ++c) bound = std::max(bound, reflectance[i][c] * (t.row_sums ? (*t.row_sums)[i] : 1.0));
    }
    const double all = sum_of(weight);
    for (double& w : weight) w /= all;
    row_is_checked_.assign(std::size_t(count), 0);
}

void Problem::gather(const Channels& b, Channels& h) {
    products += 1;
    h.resize(std::size_t(count));
    if (transport.gather_double) {
        Buffer<glm::dvec4> in(std::size_t(count), glm::dvec4(0)), out(std::size_t(count), glm::dvec4(0));
        for (int i = 0; i < count; ++i) in[i] = glm::dvec4(b[i], 0);
        transport.gather_double(in, out, options);
        for (int i = 0; i < count; ++i) h[i] = glm::dvec3(out[i]);
        rounding = glm::dvec3(0);
        return require_finite(h);
    }
    glm::dvec3 mean(0);
    Channels differing = b;
    if (transport.row_sums) {
        for (int i = 0; i < count; ++i) mean += weight[i] * b[i];
        for (glm::dvec3& v : differing) v -= mean;
    }
    const double scale = scale_of(differing);
    Buffer<glm::vec4> in(std::size_t(count), glm::vec4(0)), out(std::size_t(count), glm::vec4(0));
    for (int i = 0; i < count; ++i) in[i] = glm::vec4(glm::vec3(scale * differing[i]), 0);
    transport.gather(in, out, options);
    for (int i = 0; i < count; ++i) h[i] = glm::dvec3(out[i]) / scale, differing[i] = reflectance[i] * h[i];
    rounding = transport.gather_loss * norm(differing);
    if (transport.row_sums)
        for (int i = 0; i < count; ++i) h[i] += (*transport.row_sums)[i] * mean;
    require_finite(h);
}

void Problem::times(const Channels& b, Channels& y) {
    gather(b, y);
    for (int i = 0; i < count; ++i) y[i] *= reflectance[i];
}

Channels Problem::residual(const Channels& b) {
    Channels r;
    times(b, r);
    for (int i = 0; i < count; ++i) r[i] = (emission[i] - b[i]) + r[i];
    return r;
}

Channels Problem::residual_of_rows(const Channels& b) {
    products += 1;
    Channels r(b.size());
    parallel_bands(count, 16, options.threads, [&](int first, int last) {
        std::vector<float> f;
        for (int i = first; i < last; ++i) {
            row(i, f);
            glm::dvec3 h(0);
            for (int j = 0; j < count; ++j) h += double(f[j]) * b[j];
            r[i] = (emission[i] - b[i]) + reflectance[i] * h;
        }
    });
    return r;
}

void Problem::row(int i, std::vector<float>& row) const {
    transport.row(i, row);
    if (row_is_checked_[i]) return;
    if (row.size() != std::size_t(count)) refuse(fmt::format("row {}: {} numbers: {} expected", i, row.size(), count));
    for (int j = 0; j < count; ++j)
        if (!(row[j] >= 0 && row[j] <= std::numeric_limits<float>::max()))
            refuse(fmt::format("row {}: number {} is {:g}: expected a form factor", i, j, row[j]));
    row_is_checked_[i] = 1;
}

glm::dvec3 Problem::norm(const Channels& x) const {
    glm::dvec3 sum(0);
    for (int i = 0; i < count; ++i) sum += weight[i] * (x[i] * x[i]);
    return {std::sqrt(sum.x), std::sqrt(sum.y), std::sqrt(sum.z)};
}

double Problem::power(const Channels& x) const {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += area[i] * ((x[i].x + x[i].y) + x[i].z);
    return sum;
}

void Problem::report(double error, double tolerance) const {
    if (!progress || !(tolerance > 0 && tolerance < 1)) return;
    const double e = std::min(1.0, std::max(error, tolerance));
    progress(host::log(e) / host::log(tolerance));
}

double relative(const glm::dvec3& x, const glm::dvec3& b) {
    double worst = 0;
    for (int c = 0; c < 3; ++c)
        if (x[c] > 0) worst = std::max(worst, b[c] > 0 ? x[c] / b[c] : infinite);
    return worst;
}

double estimated_error(double residual, const Radius& radius) {
    if (residual == 0) return 0;
    return radius.high < 1 ? residual / (1 - radius.high) : infinite;
}

// ---- Radius ---------------------------------------------------------------------------------------------------------

// Two products at once: where light goes to and fro between two sides, one alone never settles.
void RadiusTracker::add(const Channels& power, const Problem& problem) {
    if (++products_ >= 2) {
        glm::dvec3 now = problem.norm(power), then = problem.norm(before_);
        for (int c = 0; c < 3; ++c) {
            double low = infinite, high = 0;
            for (int i = 0; i < problem.count; ++i) {
                const double x = before_[i][c], y = power[i][c];
                if (x > 0 && y >= 0) low = std::min(low, y / x), high = std::max(high, y / x);
                else if (y != 0) high = infinite;  // where no light was yet, or less than none: no bound
            }
            value_[c] = then[c] > 0 ? std::sqrt(now[c] / then[c]) : 0;
            low_[c] = low < infinite ? std::sqrt(low) : 0;
            high_[c] = std::sqrt(high);
        }
    }
    before_ = std::move(last_);
    last_ = power;
}

Radius RadiusTracker::radius(double bound) const {
    Radius r;
    r.products = std::max(products_, 0);
    r.high = bound;
    if (products_ < 2) return r;
    const auto largest = [](const glm::dvec3& v) { return std::max(v.x, std::max(v.y, v.z)); };
    r.value = largest(value_), r.low = largest(low_);
    r.high = std::max(r.low, std::min(largest(high_), bound));
    r.settled = r.high < 1 && r.high - r.value <= 0.1 * (1 - r.high);
    return r;
}

Radius power_iteration(Problem& problem, int most_products) {
    RadiusTracker tracker;
    Channels x(std::size_t(problem.count), glm::dvec3(1)), y;
    tracker.add(x, problem);
    Radius radius = tracker.radius(problem.bound);
    while (!radius.settled && radius.products < most_products) {
        problem.times(x, y);
        x.swap(y);
        tracker.add(x, problem);
        radius = tracker.radius(problem.bound);
        if (radius.low >= 1)
            refuse(fmt::format("light grows: each reflection returns {:.9g} times what came: rows sum to too much for "
                               "these reflectances", radius.low));
    }
    return radius;
}

// Of the elements that return all they get, drops those that see another, until all see only themselves.
int element_without_loss(const Problem& problem) {
    constexpr double all = 1 - 0x1p-22;  // floats' rounding in rows and reflectances
    std::vector<float> row;
    for (int c = 0; c < 3; ++c) {
        std::vector<int> kept;
        std::vector<unsigned char> is_kept(std::size_t(problem.count), 0);
        for (int i = 0; i < problem.count; ++i)
            if (problem.reflectance[i][c] > 0.99) kept.push_back(i), is_kept[i] = 1;
        // Chains of mirrors could take more rounds; the power iteration is there for them.
        for (int round = 0, before = -1; round < 64 && int(kept.size()) != before; ++round) {
            before = int(kept.size());
            std::vector<int> still;
            for (int i : kept) {
                problem.row(i, row);
                double sum = 0;
                for (int j = 0; j < problem.count; ++j)
                    if (is_kept[j]) sum += row[j];
                if (problem.reflectance[i][c] * sum >= all) still.push_back(i);
                else is_kept[i] = 0;
            }
            kept.swap(still);
            if (int(kept.size()) == before && before > 0) return kept[0];
        }
    }
    return -1;
}

void finish(const Problem& problem, const SolveParams& params, const std::string& why, Solution& s) {
    s.converged = params.tolerance > 0 && s.error <= params.tolerance;
    s.products = problem.products;
    s.why = s.converged ? fmt::format("estimated error {:.2g} after {:.4g} products with all rows", s.error, s.products)
                        : fmt::format("{}: estimated error {:.2g}", why, s.error);
}

}  // namespace plumb::radiosity
