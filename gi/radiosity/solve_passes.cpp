// Passes as published, and progressive refinement.
#include <algorithm>
#include <cmath>

#include "gi/radiosity/solve_problem.h"

namespace plumb::radiosity {

namespace {

// Radiosities as the caller keeps them between two passes.
Channels stored(const Channels& b, const SolveParams& params) {
    Buffer<glm::vec4> floats;
    for (const glm::dvec3& v : b) floats.push_back(glm::vec4(glm::vec3(v), 0));
    params.store(floats);
    Channels out;
    for (std::size_t i = 0; i < b.size(); ++i) out.push_back(glm::dvec3(floats.at(i)));
    return out;
}

// Pass k makes B_k = E + T B_(k-1) of B_0 = 0, so that it adds T^(k-1) E, and what pass k + 1 will add is the residual of
// B_k. differs: what is added is computed, not B_k, so that rounding is that of the small number.
struct Passes {
    Problem& problem;
    const SolveParams& params;
    Channels b, added, next;  // next: the residual of b

    Passes(Problem& p, const SolveParams& s) : problem(p), params(s), b(p.emission.size(), glm::dvec3(0)), next(p.emission) {}

    void pass() {
        Channels sum = b;
        for (std::size_t i = 0; i < b.size(); ++i) sum[i] += next[i];
        if (!params.store) {
            b.swap(sum), added.swap(next);
            return problem.times(added, next);
        }
        sum = stored(sum, params);
        added = sum;
        for (std::size_t i = 0; i < b.size(); ++i) added[i] -= b[i];
        b.swap(sum);
        next = problem.residual(b);
    }
};

}  // namespace

Solution solve_passes(Problem& problem, const SolveParams& params) {
    Passes passes(problem, params);
    Solution s;
    RadiusTracker tracker;
    std::string why = "all passes done";
    glm::dvec3 rounding(0);  // of all products: what is lost in one is in all radiosities after it
    for (int k = 1; k <= params.most_products; ++k) {
        passes.pass();
        tracker.add(passes.added, problem);
        s.radius = tracker.radius(problem.bound);
        // What is stored is no power of T times the light: there is no bound, nothing settles.
        if (params.store) s.radius.high = problem.bound, s.radius.low = 0, s.radius.settled = false;
        const glm::dvec3 norm = problem.norm(passes.b);
        s.residual = relative(problem.norm(passes.next), norm);
        rounding = params.store ? problem.rounding : rounding + problem.rounding;
        const double lost = relative(rounding, norm);
        s.error = estimated_error(s.residual + lost, s.radius);
        s.curve.push_back({double(k), s.residual, relative(problem.norm(passes.added), norm), s.error,
                           problem.power(passes.b)});
        problem.report(s.error, params.tolerance);
        if (params.tolerance > 0 && s.error <= params.tolerance) break;
        if (params.tolerance > 0 && s.residual < 0.1 * lost) {
            why = "no nearer: products are rounded";
            break;
        }
        if (problem.power(passes.b) > 1e30 * problem.power(problem.emission)) {
            why = "light grows with each pass";
            break;
        }
    }
    s.radiosity = std::move(passes.b);
    s.row_residual = s.residual;
    finish(problem, params, why, s);
    return s;
}

namespace {

struct Shooting {
    Problem& problem;
    Channels b, unshot;
    std::vector<float> row;

    explicit Shooting(Problem& p) : problem(p), b(p.emission), unshot(p.emission) {}

    // The element with the largest unshot power, of equals the first; -1: nothing is left.
    int brightest() const {
        int best = -1;
        double most = 0;
        for (int i = 0; i < problem.count; ++i) {
            const double power = problem.area[i] * ((unshot[i].x + unshot[i].y) + unshot[i].z);
            if (power > most) most = power, best = i;
        }
        return best;
    }

    void shoot(int i) {
        problem.row(i, row);
        const glm::dvec3 power = problem.area[i] * unshot[i];
        unshot[i] = glm::dvec3(0);
        for (int j = 0; j < problem.count; ++j) {
            if (row[j] == 0 || problem.area[j] == 0) continue;
            const glm::dvec3 d = problem.reflectance[j] * (row[j] / problem.area[j] * power);
            b[j] += d, unshot[j] += d;
        }
        problem.products += 1.0 / problem.count;
    }

    // Irradiance everywhere if all unshot power were reflected by the mean reflectance on and on (Cohen et al. 1988),
    // and by how much that would raise the mean radiosity, relative.
    glm::dvec3 ambient(double& rise) const {
        glm::dvec3 left(0), mean(0), all(0), out(0);
        double area = 0;
        for (int i = 0; i < problem.count; ++i) {
            left += problem.area[i] * unshot[i], mean += problem.area[i] * problem.reflectance[i];
            all += problem.area[i] * b[i], area += problem.area[i];
        }
        rise = 0;
        if (!(area > 0)) return out;
        for (int c = 0; c < 3; ++c) {
            if (!(left[c] > 0)) continue;
            out[c] = left[c] / (area - mean[c]);
            rise = std::max(rise, mean[c] * out[c] / all[c]);
        }
        return out;
    }
};

}  // namespace

Solution solve_shooting(Problem& problem, const SolveParams& params) {
    Shooting shooting(problem);
    Solution s;
    s.radius.high = problem.bound;
    const std::int64_t most = std::int64_t(params.most_products) * problem.count;
    const int between = std::max(1, problem.count / 16);  // shots between two looks
    std::string why = "all shots done";
    for (std::int64_t shots = 0;; ++shots) {
        const int i = shots < most ? shooting.brightest() : -1;
        if (shots % between == 0 || i < 0) {
            s.ambient = shooting.ambient(s.error);
            s.residual = relative(problem.norm(shooting.unshot), problem.norm(shooting.b));
            s.curve.push_back({problem.products, s.residual, 0, s.error, problem.power(shooting.b)});
            problem.report(s.error, params.tolerance);
            if (i < 0 || (params.tolerance > 0 && s.error <= params.tolerance)) break;
        }
        shooting.shoot(i);
    }
    const double all = problem.power(shooting.b);
    s.unshot = all > 0 ? problem.power(shooting.unshot) / all : 0;
    finish(problem, params, why, s);

    // What no row can be turned round for gathers once; the others show how far rows are from reciprocal.
    Channels rest = problem.residual(shooting.b);
    for (int i = 0; i < problem.count; ++i)
        if (problem.area[i] == 0) shooting.b[i] += rest[i], rest[i] = glm::dvec3(0);
    s.row_residual = relative(problem.norm(rest), problem.norm(shooting.b));
    s.radiosity = std::move(shooting.b);
    return s;
}

}  // namespace plumb::radiosity
