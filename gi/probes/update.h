// The run time's update, from coefficients of probes to the lightmap (IPR 3.3.1.2, 3.3.1.3): probes.basis, probes.irradiance and
// probes.lightmap.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/basis_kernel.h"
#include "gi/probes/irradiance_kernel.h"
#include "gi/probes/lightmap_write_kernel.h"
#include "gi/probes/run_data.h"

namespace plumb::probes {

// What all three are given in this order: lists that must outlive the run.
struct BasisInputs {
    using Kernel = BasisKernel;
    const ClusterData* clusters = nullptr;
    const std::int32_t* cluster_level = nullptr;  // [clusters]: 0 to 3; another: no coefficients, basis 0
    const glm::vec4* lambda = nullptr;            // [probes][clusters->coefficients]: xyz W/m2
    int probes = 0;
    glm::ivec4 coefficients{64};                  // that are used, by level of detail; at most clusters->coefficients are
};
struct IrradianceInputs {
    using Kernel = IrradianceKernel;
    const ClusterData* clusters = nullptr;
    const std::int32_t* cluster_level = nullptr;   // [clusters]
    const std::int32_t* receiver_level = nullptr;  // [places]: computed where it is at least the cluster's
    const glm::vec4* basis = nullptr;              // [clusters][clusters->singular_values]: xyz W/m2
};
struct LightmapInputs {
    using Kernel = LightmapKernel;
    const Image<std::int32_t>* cover = nullptr;
    const glm::vec4* irradiance = nullptr;  // [places]: xyz W/m2
    int places = 0;
};

// Throws InputError for a cluster whose matrix or probes lie beyond what an index reaches, or whose rank is out of range.
std::size_t numbers_of_matrices(const BasisView& view);
std::size_t probes_of_clusters(const BasisView& view);
// Refuses an index of a probe that is not there. Throws InputError.
void check_basis(BasisView& view, Buffer<float>& own);
// Refuses a rank that is out of range. Throws InputError.
void check_irradiance(IrradianceView& view, Buffer<float>& own);

inline StageDescription<BasisView> describe(BasisKernel) {
    using View = BasisView;
    const auto one_each = [](const View& v) { return std::size_t(v.u.height); };
    return {
        .name = "probes.basis",
        .source = "IPR 3.3.1.2, figure 3.31",
        .domain = "singular value of a cluster",
        .inputs = {{.name = "clusters", .at = &View::clusters,
                    .meaning = "[cluster] first number of its matrix, first of its probes, probes, rank", .count = one_each,
                    .why = "one a cluster"},
                   {.name = "cluster_probes", .at = &View::cluster_probes, .meaning = "probes, cluster by cluster",
                    .count = probes_of_clusters, .why = "all clusters' probes"},
                   {.name = "cluster_level", .at = &View::cluster_level,
                    .meaning = "[cluster] level of detail, 0 to 3; of another it takes no coefficients", .count = one_each,
                    .why = "one a cluster"},
                   {.name = "matrix", .at = &View::matrix, .meaning = "Sigma V^T, cluster by cluster: [probe, coefficient][rank]",
                    .count = numbers_of_matrices, .why = "all clusters' matrices"},
                   {.name = "lambda", .at = &View::lambda, .unit = "W/m2", .meaning = "[probe][coefficient] xyz lambda_ij; w unused",
                    .fixed = 8,
                    .count = [](const View& v) { return std::size_t(v.u.probes) * std::size_t(v.u.coefficients); },
                    .why = "coefficients of each probe"}},
        .outputs = {{.name = "basis", .at = &View::basis, .unit = "W/m2",
                     .meaning = "[cluster][singular value] xyz b_c; 0 beyond the rank"}},
        .uniforms = {{"coefficients", 1, 64}, {"probes", 1, 1 << 20}, {"coefficients_0", 0, 64}, {"coefficients_1", 0, 64},
                     {"coefficients_2", 0, 64}, {"coefficients_3", 0, 64}},
        .refuses =
            [](const View& v, glm::ivec2 size) {
                if (size.x > most_singular_values) return std::string("more than 64 singular values");
                for (const int used : {v.u.coefficients_0, v.u.coefficients_1, v.u.coefficients_2, v.u.coefficients_3})
                    if (used > v.u.coefficients) return std::string("a level of detail with more coefficients than probes have");
                return std::string();
            },
        .prepare = check_basis,
        .cost = {3, "coefficients of clusters' probes"},
    };
}

inline StageDescription<IrradianceView> describe(IrradianceKernel) {
    using View = IrradianceView;
    const auto clusters = [](const View& v) { return std::size_t(v.u.clusters); };
    const auto places = [](const View& v) { return std::size_t(v.u.count); };
    return {
        .name = "probes.irradiance",
        .source = "IPR 3.3.1.3; levels of detail 4.2.3",
        .domain = "place of a receiver",
        .inputs = {{.name = "clusters", .at = &View::clusters, .meaning = "[cluster] w its rank; xyz unused", .count = clusters,
                    .why = "one a cluster"},
                   {.name = "cluster_level", .at = &View::cluster_level, .meaning = "[cluster] level of detail", .count = clusters,
                    .why = "one a cluster"},
                   {.name = "cluster", .at = &View::cluster, .meaning = "[place] the receiver's cluster; -1: none", .count = places,
                    .why = "one a place"},
                   {.name = "receiver_level", .at = &View::receiver_level,
                    .meaning = "[place] the coarsest level of detail that shows it", .count = places, .why = "one a place"},
                   {.name = "transport", .at = &View::transport, .meaning = "[singular value][place] U",
                    .count = [](const View& v) { return std::size_t(v.u.singular_values) * std::size_t(v.u.count); },
                    .why = "singular values of each place"},
                   {.name = "basis", .at = &View::basis, .unit = "W/m2", .meaning = "[cluster][singular value] xyz b_c; w unused",
                    .fixed = 8,
                    .count = [](const View& v) { return std::size_t(v.u.clusters) * std::size_t(v.u.singular_values); },
                    .why = "singular values of each cluster"}},
        .outputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2",
                     .meaning = "[place] xyz I, w 1; what is not computed is 0", .fixed = 8}},
        .uniforms = {{"count", 1, 0x7fffffff}, {"clusters", 1, 524280}, {"singular_values", 1, most_singular_values}},
        .refuses =
            [](const View& v, glm::ivec2 size) {
                if (std::int64_t(size.x) * size.y < v.u.count) return std::string("fewer items than places");
                if (std::int64_t(v.u.singular_values) * v.u.count > 0x7fffffff) return std::string("more than 2^31 numbers of U");
                return std::string();
            },
        .prepare = check_irradiance,
        .cost = {0.5, "singular values of receivers"},
    };
}

inline StageDescription<LightmapView> describe(LightmapKernel) {
    using View = LightmapView;
    return {
        .name = "probes.lightmap",
        .source = "IPR 3.2.1.1, figure 3.12; levels of detail 4.2.3",
        .domain = "texel",
        .inputs = {{.name = "cover", .at = &View::cover,
                    .meaning = "[texel] place of the receiver; -2 beside receivers, -3 beside those, else nothing",
                    .count = [](const View& v) { return std::size_t(v.u.width) * std::size_t(v.u.height); }, .why = "one a texel"},
                   {.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "[place] xyz; w unused", .fixed = 8,
                    .count = [](const View& v) { return std::size_t(v.u.places); }, .why = "one a place"}},
        .outputs = {{.name = "lightmap", .at = &View::lightmap, .unit = "W/m2",
                     .meaning = "levels below each other: xyz irradiance, w 1 on receivers and both rings; else 0", .fixed = 8}},
        .uniforms = {{"places", 1, 0x7fffffff}},
        .cost = {1, "texels"},
    };
}

// The domain of probes.irradiance: the list of places, folded to rows.
glm::ivec2 irradiance_size(int places);

StageData data_of(const BasisInputs& in);
StageData data_of(const IrradianceInputs& in);
StageData data_of(const LightmapInputs& in);

// [clusters][singular_values]
void run(const BasisInputs& in, const RunOptions& options, Buffer<glm::vec4>& basis);
// [places]
void run(const IrradianceInputs& in, const RunOptions& options, Buffer<glm::vec4>& irradiance);
void run(const LightmapInputs& in, const RunOptions& options, Image4& lightmap);

}  // namespace plumb::probes
