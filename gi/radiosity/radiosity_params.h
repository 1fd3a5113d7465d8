// The parameters of hemicube radiosity: the table [radiosity] of a scene file.
#pragma once

#include <vector>

#include "core/fields.h"
#include "gi/radiosity/elements.h"
#include "gi/radiosity/rows.h"

namespace plumb::radiosity {

// How the system is solved: as recommend() (solve_choose.h) says, or by the Solver of that name, which is one less.
enum class SolverChoice : int { automatic, passes, shooting, gauss_seidel, bicgstab, conjugate_gradients, direct };

struct RadiosityParams {
    Kind kind = Kind::vertices;
    float edge = 0;                    // m: triangles with longer ones are split before anything is drawn; 0: automatic_edges
    bool cut = true;                   // surfaces where others stand on them
    int refine = 2;                    // rounds of splitting where irradiance changes
    float refine_tolerance = 0.25f;    // of differences()
    float least_edge = 0;              // m; 0: an eighth of `edge`
    int most_triangles = 4'000'000;
    float small_emitters = 0.02f;      // of the scene's area: up to it, emitters are lamps (emitters.h)
    int size = 64;                     // texels of a hemicube's side
    Weights weights = Weights::exact;
    float crease_deg = 30;
    float offset = 1e-4f;              // of the scene's diagonal
    bool inset = true;
    bool split = true;
    SolverChoice solver = SolverChoice::automatic;
    float tolerance = 1e-4f;           // estimated relative error of what is solved; 0: as many passes as `passes` says
    int passes = 1000;                 // products with all rows, at most
    int memory_mb = 2048;              // that rows may take in memory; further ones are read from the store
    bool audit = true;                 // the run's report says where all power goes
};
std::vector<Field> fields(RadiosityParams& params);
// Edges along a scene's diagonal where nobody says how long they may be.
inline constexpr double automatic_edges = 20;
// A scene as the method draws it: no edge longer than `edge`, cut at contacts, and smaller triangles where light changes. Throws
// what tessellate() throws; for moving meshes, whose triangles would be others in every frame, InputError.
Scene drawn_by_radiosity(const Scene& scene, const RadiosityParams& params, const RunOptions& options = {});

inline ElementParams element_params(const RadiosityParams& p) { return {p.kind, p.crease_deg, p.offset, p.inset, p.split, false, p.small_emitters}; }
inline RowParams row_params(const RadiosityParams& p) { return {p.size, p.weights}; }

}  // namespace plumb::radiosity
