// Where a solution's power goes, and whether its rows are form factors.
#pragma once

#include "gi/radiosity/solve.h"

namespace plumb::radiosity {

// Powers in W, sum of channels. For any rows and radiosities, to rounding:
//     emitted + incident = absorbed + escaped + not_arrived + not_reciprocal + unsolved
struct Audit {
    double emitted = 0;         // sum A M
    double incident = 0;        // sum A H0, of lamps and the environment
    double not_arrived = 0;     // of what small emitters emit: to nothing and to backs, and what outlines and rays are off (emitters.h)
    double absorbed = 0;        // sum A (1 - rho) H, H = H0 + F B
    double escaped = 0;         // sum A B (1 - row sum): what leaves elements and meets none
    double not_reciprocal = 0;  // sum_j B_j (A_j row sum_j - sum_i A_i F_ij): counted out, never counted in
    double unsolved = 0;        // sum A (M + rho H - B): of the solver's residual
    double unbalanced = 0;      // left minus right side

    double least_row = 0, mean_row = 0, largest_row = 0;  // row sums
    int largest_row_at = -1;
    int rows_of_nothing = 0;  // elements that see nothing

    // |A_i F_ij - A_j F_ji| over pairs, m2, and that of the mean square of A_i F_ij over the same pairs.
    double defect_rms = 0, defect_worst = 0, exchange_rms = 0;
    int worst_i = -1, worst_j = -1;
    std::int64_t pairs = 0;
    bool all_pairs = false;

    double gather_off = 0;  // largest |h by gather() - h by rows|, relative to the largest h
};

// What small emitters send, whose light the system has in `incident`: the audit counts it as emitted. Null: there are none.
struct SmallEmitters {
    const Buffer<glm::vec4>* exitance = nullptr;    // W/m2, of each element
    const Buffer<glm::vec4>* irradiance = nullptr;  // W/m2, by them
};

// Looks at the pairs among `sample` elements, evenly spread in their order; at all where there are no more.
Audit audit(const System& system, const Transport& transport, const std::vector<glm::dvec3>& radiosity, int sample = 512,
            const RunOptions& options = {}, const SmallEmitters& small = {});

}  // namespace plumb::radiosity
