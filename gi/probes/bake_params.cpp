#include "gi/probes/bake_params.h"

namespace plumb::probes {

std::vector<Field> fields(BakeParams& p) {
    std::vector<Field> all = {
        {"receivers_per_m2", &p.receivers_per_m2, "1/m2", "texels of the lightmap on a square metre (IPR 3.1.1)", 1e-12, 1e12, {}},
        {"lightmap_size", &p.lightmap_size, "texels", "side of the lightmap; 0: what the density asks for", 0, 16384, {}},
        {"gap", &p.gap, "texels", "between charts (IPR 3.2.1.1)", 0, 64, {}},
        {"chart_angle", &p.chart_angle, "degrees", "by which normals of a planar chart may differ from its own", 1, 80, {}},
        {"test_rays", &p.test_rays, "", "of each receiver, to tell whether it lies inside of something; 0: not asked", 0, 4096, {}},
        {"back_share", &p.back_share, "", "share of them that start inside of something where the receiver does (IPR 5.1.4: 0.6)", 0.01, 1, {}},
    };
    for (Field& f : fields(p.placement)) all.push_back(f);
    const std::vector<Field> rest = {
        {"relight_rays", &p.relight_rays, "", "of each probe; prefixes of 64, 128, 256, 512 are uniform (IPR 3.2.3.1)", 1, 32768, {}},
        {"receiver_rays", &p.receiver_rays, "", "of each receiver (IPR 3.2.3.2)", 1, 32767, {}},
        {"degree", &p.degree, "", "of the spherical harmonics: (degree + 1)^2 coefficients", 0, 7, {}},
        {"distribution", as_int(p.distribution), "", "of a receiver's rays about its normal", -unbounded, unbounded,
         {"cosine", "uniform"}},
        {"escapes", as_int(p.escapes), "", "what rays that meet nothing bring (IPR 5.1.3.1); automatic: sky, a probe at infinity, under a "
         "sky that sends light, else nothing", -unbounded, unbounded,
         {"automatic", "nothing", "same_direction", "visible_probes", "all_probes", "sky"}},
        {"weighting", as_int(p.weighting), "", "of rays by their length (IPR 5.1.3.2); published depends on the unit of length",
         -unbounded, unbounded, {"none", "published"}},
        {"gather", as_int(p.gather), "", "how receivers gather from probes: fitted, so that they err least, where rays that meet nothing ask the sky or "
         "nobody and weigh by nothing else; interpolated: IPR (9)", -unbounded, unbounded, {"fitted", "interpolated"}},
        {"singular_values", &p.singular_values, "", "kept of a cluster's transport (IPR 3.2.4.2)", 4, 64, {}},
        {"threshold", &p.threshold, "", "1 - sqrt(share of the kept singular values) below which a cluster is accepted", 0, 1, {}},
        {"cluster_receivers", &p.cluster_receivers, "", "a cluster has fewer (IPR 3.2.4)", 2, 4096, {}},
        {"by_size_only", &p.by_size_only, "", "clusters are split by their number of receivers alone (figure 3.18)", -unbounded, unbounded, {}},
        {"spatial_receivers", &p.spatial_receivers, "", "about how many places of a grid over the scene have receivers in six directions, for "
         "dynamic objects (IPR 4.1); 0: none", 0, 1 << 20, {}},
        {"spatial_back_share", &p.spatial_back_share, "", "share of a place's test rays that meet something which start inside of it where the place "
         "does (IPR 4.1.1)", 0.01, 1, {}},
        {"spatial_weight", as_int(p.spatial_weight), "", "of radiance by its angle: corrected: its cosine; published: 1 - 2 theta / pi (IPR 4.1)",
         -unbounded, unbounded, {"corrected", "published"}},
        {"rays", as_int(p.rays), "", "exact: the same bits on every processor; native: faster", -unbounded, unbounded,
         {"exact", "native"}},
    };
    all.insert(all.end(), rest.begin(), rest.end());
    for (Field& f : all) f.uniform = false;
    return all;
}

void validate(const BakeParams& params) {
    BakeParams copy = params;
    validate_fields("probes", fields(copy));
}

}  // namespace plumb::probes
