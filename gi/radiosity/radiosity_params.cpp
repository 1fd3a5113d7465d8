#include "gi/radiosity/radiosity_params.h"


namespace plumb::radiosity {

std::vector<Field> fields(RadiosityParams& p) {
    using Role = SweepRange::Role;
    return {
        {"elements", as_int(p.kind), "", "where irradiance is computed: at vertices, linear between them, or in the middle of triangles (HEM 4.5.4, 6.4)", -unbounded,
         unbounded, {"vertices", "triangles"}, false},
        {"edge", &p.edge, "m", "triangles with longer edges are split; 0: a twentieth of the scene's diagonal (HEM 4.5.4, step 1)", 0, 1e9, {}, false},
        {"cut", &p.cut, "", "whether surfaces are cut where others stand on them", -unbounded, unbounded, {}, false},
        {"refine", &p.refine, "", "rounds of splitting triangles on which irradiance changes (HEM 4.5.4)", 0, 16, {}, false},
        {"refine_tolerance", &p.refine_tolerance, "", "how much irradiance may differ on a triangle, of its mean", 0, 1e9, {}, false},
        {"least_edge", &p.least_edge, "m", "no edge shorter than twice that is split by refine; 0: an eighth of edge", 0, 1e9, {}, false},
        {"most_triangles", &p.most_triangles, "", "more are refused", 1, 7e8, {}, false},
        {"small_emitters", &p.small_emitters, "", "share of the scene's area up to which what emits is integrated by outlines and rays, not by texels", 0, 1, {}, false},
        {"size", &p.size, "", "texels of a hemicube's side, an even number (HEM 5.8)", 2, largest_hemicube, {}, false, {Role::along, {8, 16, 32, 64, 128, 256}}},
        {"weights", as_int(p.weights), "", "share of a hemisphere that a texel stands for: its integral, its value in the middle, or as published (HEM 5.5, 5.7)", -unbounded,
         unbounded, {"exact", "centre", "published"}, false},
        {"crease_deg", &p.crease_deg, "deg", "triangles whose normals differ by more are no one surface", 0, 180, {}, false},
        {"offset", &p.offset, "", "how far off its surface an element looks from, of the scene's diagonal (HEM 4.5.3: one unit)", 0, 0.1, {}, false},
        {"inset", &p.inset, "", "whether an element on a border looks from within its surface, too; off: along the normal alone (HEM 5.6)", -unbounded, unbounded, {}, false},
        {"split", &p.split, "", "whether vertices are split at creases; off: a mean normal at each position (HEM 5.6)", -unbounded, unbounded, {}, false},
        {"solver", as_int(p.solver), "", "how light that is reflected on and on is solved for; auto: by what each is expected to take (README.md, Solvers)", -unbounded,
         unbounded, {"auto", "passes", "shooting", "gauss_seidel", "bicgstab", "conjugate_gradients", "direct"}, false},
        {"tolerance", &p.tolerance, "", "estimated relative error of the solution; 0: as many passes as `passes` says, from black", 0, 1, {}, false},
        {"passes", &p.passes, "", "passes, or products with all rows, at most (HEM 4.5.4: 4 to 16)", 1, 1e6, {}, false},
        {"memory_mb", &p.memory_mb, "MB", "that rows of form factors may take in memory; further ones are read from the cache, and change no bit", 1, 1 << 20, {}, false},
        {"audit", &p.audit, "", "whether run.json says where all power goes, which reads all rows once more", -unbounded, unbounded, {}, false},
    };
}

}  // namespace plumb::radiosity
