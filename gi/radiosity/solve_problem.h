// What the solvers share: a checked system in doubles, products with its rows, norms and bounds of the radius.
#pragma once

#include "gi/radiosity/solve.h"

namespace plumb::radiosity {

using Channels = std::vector<glm::dvec3>;  // [element]

struct Problem {
    int count;
    const Transport& transport;
    RunOptions options;                    // tells no progress
    std::function<void(double)> progress;  // of the solver
    Channels exitance, incident;           // W/m2
    Channels emission;                     // M + rho H0, W/m2
    Channels reflectance;
    std::vector<double> area;    // m2
    std::vector<double> weight;  // of norms: the area, no less than 2^-40 of the mean; they sum to one
    double bound = 0;            // of the radius: the largest reflectance, times its row's sum where that is known
    double products = 0;         // done so far
    glm::dvec3 rounding{0};      // norm of what the last times() may have lost in floats, by channel

    // Throws InputError; solve.h.
    Problem(const System& system, const Transport& transport, const RunOptions& options);

    void gather(const Channels& b, Channels& h);  // h = F b
    void times(const Channels& b, Channels& y);   // y = diag(rho) F b
    Channels residual(const Channels& b);         // M + rho (H0 + F b) - b
    // The same of decoded rows, summed in double: the system of the solvers that ask for rows.
    Channels residual_of_rows(const Channels& b);
    // Throws InputError, the first time that a row is asked for, if it holds what is no form factor.
    void row(int i, std::vector<float>& row) const;

    glm::dvec3 norm(const Channels& x) const;  // root of the weighted mean of squares
    double power(const Channels& x) const;     // W, all channels
    // How far a solver has come on its way from an error of 1 to the tolerance.
    void report(double error, double tolerance) const;

  private:
    mutable std::vector<unsigned char> row_is_checked_;
};

// |x| / |b| in the worst channel; channels without light count for nothing.
double relative(const glm::dvec3& x, const glm::dvec3& b);
double estimated_error(double residual, const Radius& radius);

// Bounds of the radius of T from x, T x, T T x, ..., no element of x negative.
class RadiusTracker {
  public:
    void add(const Channels& power, const Problem& problem);
    Radius radius(double bound) const;

  private:
    Channels last_, before_;
    int products_ = -1;
    glm::dvec3 value_{0}, low_{0}, high_{0};
};

// Throws InputError where light grows.
Radius power_iteration(Problem& problem, int most_products);

// An element of a set from which no light is lost, or -1.
int element_without_loss(const Problem& problem);

// Whether it has converged and what is to be said of it; `why` it stopped, if it has not.
void finish(const Problem& problem, const SolveParams& params, const std::string& why, Solution& solution);

Solution solve_passes(Problem& problem, const SolveParams& params);
Solution solve_shooting(Problem& problem, const SolveParams& params);
Solution solve_gauss_seidel(Problem& problem, const SolveParams& params);
Solution solve_bicgstab(Problem& problem, const SolveParams& params);
Solution solve_conjugate_gradients(Problem& problem, const SolveParams& params);
Solution solve_direct(Problem& problem, const SolveParams& params);

}  // namespace plumb::radiosity
