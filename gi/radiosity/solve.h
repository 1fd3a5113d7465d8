// Solvers of the radiosity system B_i = M_i + rho_i (H0_i + sum_j F_ij B_j), three channels at once.
//
//     passes               as published (HEM 4.5.4): each computes all elements from the pass before, from black
//     shooting             progressive refinement (Cohen, Chen, Wallace and Greenberg 1988): a row a step, and a picture
//                          after each; F_ji = F_ij A_i / A_j
//     gauss_seidel         passes that use what they have just computed
//     bicgstab             van der Vorst 1992, on the rows as they are
//     conjugate_gradients  Hestenes and Stiefel 1952, on rows made reciprocal by averaging
//     direct               LU, for small scenes
//
// They know no hemicube: rows come from a Transport. The same bits for every number of threads and instruction set, as
// long as the transport has that property. README.md derives what is below and says which to take.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/isa.h"

namespace plumb::radiosity {

// F of `count` elements: no entry is negative, a row sums to one at most, up to what a hemicube's weights are off.
struct Transport {
    int count = 0;
    // h_i = sum_j F_ij b_j; h comes with `count` elements, xyz used.
    std::function<void(const Buffer<glm::vec4>& b, Buffer<glm::vec4>& h, const RunOptions&)> gather;
    // Row i, `count` numbers; called by several threads at once.
    std::function<void(int i, std::vector<float>& row)> row;
    const std::vector<double>* area = nullptr;  // m2, each 0 or more
    // Of each irradiance, what gather() is expected to lose: sums in floats lose 2^-24 an addition, and signs differ.
    double gather_loss = 0x1p-24;
    // The same as gather() with less rounding; may be empty. gather() limits the error to about gather_loss / (1 - radius).
    std::function<void(const Buffer<glm::dvec4>& b, Buffer<glm::dvec4>& h, const RunOptions&)> gather_double;
    // Of each row; may be null. With them gather() is asked for what differs from the mean alone, and that limit is gone
    // where light is nearly the same everywhere, as it is where the radius is near one.
    const std::vector<double>* row_sums = nullptr;
};

// xyz used. What is empty is zero.
struct System {
    const Buffer<glm::vec4>* reflectance = nullptr;  // 0..1
    const Buffer<glm::vec4>* exitance = nullptr;     // W/m2, emitted
    const Buffer<glm::vec4>* incident = nullptr;     // W/m2, from lamps and the environment; may be null
};

enum class Solver : int { passes, shooting, gauss_seidel, bicgstab, conjugate_gradients, direct };
const char* solver_name(Solver solver);
Solver parse_solver(const std::string& name);  // throws InputError that lists them

struct SolveParams {
    Solver solver = Solver::bicgstab;
    double tolerance = 1e-4;  // stops where the estimated relative error is no larger; 0: after most_products
    int most_products = 1000;  // products with all rows; n passes as published: tolerance 0, most_products n
    // passes: what becomes of radiosities that are kept in something else than floats, after each pass. May be empty.
    std::function<void(Buffer<glm::vec4>&)> store;
    std::int64_t most_bytes = std::int64_t(1) << 29;  // direct: of the matrix
};

// Of diag(rho) F, the largest of the channels.
struct Radius {
    double value = 0;      // estimate, usually from below
    double high = 1;       // from above: a bound, up to rounding (Collatz 1942); of what light reaches, for passes
    double low = 0;        // from below: a bound
    int products = 0;      // that it took
    bool settled = false;  // 1 / (1 - radius) is known to 10 %
};

// After `products` products. Relative ones are of the norm of B, weighted by area, in the worst channel.
struct CurvePoint {
    double products = 0;
    double residual = 0;  // relative, of M + rho (H0 + F B) - B
    double step = 0;      // relative; 0 where a solver does not see its radiosities (bicgstab, conjugate_gradients)
    // Relative, estimated: (residual + what products in floats have lost) / (1 - radius); infinite where no bound is below 1.
    double error = 0;
    double power = 0;     // W: what leaves all elements, sum of channels; 0 like step
};

struct Solution {
    std::vector<glm::dvec3> radiosity;  // W/m2
    std::vector<CurvePoint> curve;
    Radius radius;
    double products = 0;      // with all rows: gathered, or decoded once
    double residual = 0;      // relative, of the system that was solved
    double row_residual = 0;  // relative, by gather(): more where the solver takes rows as reciprocal
    double error = 0;         // relative, estimated, of the system that was solved
    bool converged = false;   // error <= tolerance
    std::string why;          // it stopped, half a sentence
    glm::dvec3 ambient{0};    // W/m2, shooting: add reflectance * ambient for display
    double unshot = 0;        // shooting: share of the power that has left no element yet
};
Buffer<glm::vec4> floats_of(const Solution& solution);

// Throws InputError for values that are not finite, negative, of another count, reflectances beyond 0..1, light that
// grows without end (naming an element), and a direct solve beyond most_bytes (saying how many are needed).
Solution solve(const System& system, const Transport& transport, const SolveParams& params,
               const RunOptions& options = {});

// By power iteration from ones.
Radius spectral_radius(const System& system, const Transport& transport, int most_products = 64,
                       const RunOptions& options = {});

// B' = B + rho ambient: what progressive refinement shows before it has finished.
Buffer<glm::vec4> shown(const Solution& solution, const System& system);

std::int64_t direct_bytes(int count);  // of the matrix of a direct solve

}  // namespace plumb::radiosity
