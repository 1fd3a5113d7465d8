#include "gi/probes/textures.h"

#include <algorithm>

#include "core/error.h"
#include "gi/probes/texture_items.h"

namespace plumb::probes {
namespace {

constexpr const char* rgba = "R32G32B32A32_SFLOAT";

// Calls put(item, x, y, texel) for every texel of every item; what it does not write stays padding.
template <class T, class Put>
Array filled(TextureId id, const TextureCounts& counts, Put put) {
    const TextureInfo& info = info_of(id);
    const ItemGrid grid = grid_of(id, counts);
    Bundle one;
    Array& array = add(one, info.name, dtype_of<T>, grid.shape(info.channels));
    T* texels = reinterpret_cast<T*>(array.bytes.data());
    std::fill_n(texels, array.bytes.size() / sizeof(T), dtype_of<T> == DType::i32 ? T(-1) : T(0));
    for (std::int64_t item = 0; item < grid.items; ++item)
        for (std::int64_t y = 0; y < grid.height; ++y) {
            T* texel = texels + grid.texel(item, 0, y) * std::size_t(info.channels);
            for (std::int64_t x = 0; x < grid.width; ++x, texel += info.channels)
                put(std::size_t(item), std::size_t(x), std::size_t(y), texel);
        }
    return std::move(one.arrays[0]);
}

void put_position(const glm::vec3& position, float* texel) {
    texel[0] = position.x, texel[1] = position.y, texel[2] = position.z, texel[3] = 1;
}

Array probe_texture(TextureId id, const BakeArrays& a, const TextureCounts& counts) {
    const auto ray_of = [&](std::size_t probe, std::size_t ray) -> const BakedRay& {
        return a.relight[probe * std::size_t(a.rays) + ray];
    };
    if (id == TextureId::probe_rays)
        return filled<float>(id, counts, [&](std::size_t probe, std::size_t ray, std::size_t, float* texel) {
            const BakedRay& r = ray_of(probe, ray);
            texel[0] = float(r.material), texel[1] = r.uv.x, texel[2] = r.uv.y;
        });
    if (id == TextureId::hit_position)
        return filled<float>(id, counts, [&](std::size_t probe, std::size_t ray, std::size_t, float* texel) {
            const BakedRay& r = ray_of(probe, ray);
            if (r.material >= 0) put_position(r.position, texel);
        });
    if (id == TextureId::probe_position)
        return filled<float>(id, counts, [&](std::size_t probe, std::size_t, std::size_t, float* texel) {
            put_position(a.probes[probe], texel);
        });
    return filled<float>(id, counts, [&](std::size_t, std::size_t ray, std::size_t j, float* texel) {
        *texel = a.sh[ray * std::size_t(a.coefficients) + j];
    });
}

Array cluster_texture(TextureId id, const BakeArrays& a, const TextureCounts& counts) {
    // Sigma V^T stands upright: a column a singular value, a row a coefficient of a probe.
    if (id == TextureId::cluster_matrix)
        return filled<float>(id, counts, [&](std::size_t cluster, std::size_t x, std::size_t y, float* texel) {
            const BakedCluster& c = a.clusters[cluster];
            const std::size_t rows = c.probes.size() * std::size_t(a.coefficients);
            if (y < rows && x < std::size_t(c.rank)) *texel = c.sigma_vt[x * rows + y];
        });
    if (id == TextureId::cluster_size)
        return filled<std::int32_t>(id, counts,
                                    [&](std::size_t cluster, std::size_t, std::size_t, std::int32_t* texel) {
                                        *texel = std::int32_t(a.clusters[cluster].probes.size());
                                    });
    if (id == TextureId::cluster_probes)
        return filled<std::int32_t>(id, counts,
                                    [&](std::size_t cluster, std::size_t, std::size_t k, std::int32_t* texel) {
                                        const std::vector<int>& probes = a.clusters[cluster].probes;
                                        if (k < probes.size()) *texel = probes[k];
                                    });
    return filled<float>(id, counts, [&](std::size_t cluster, std::size_t corner, std::size_t, float* texel) {
        const BakedCluster& c = a.clusters[cluster];
        glm::vec3 p = c.low;
        for (int axis = 0; axis < 3; ++axis)
            if (corner >> axis & 1) p[axis] = c.high[axis];
        put_position(p, texel);
    });
}

Array receiver_texture(TextureId id, const BakeArrays& a, const TextureCounts& counts) {
    if (id == TextureId::receiver_map)
        return filled<std::int32_t>(id, counts,
                                    [&](std::size_t receiver, std::size_t, std::size_t, std::int32_t* texel) {
                                        const BakedReceiver& r = a.receivers[receiver];
                                        const int columns = int(counts.cluster_columns);
                                        if (r.cluster >= 0)
                                            texel[0] = r.cluster % columns, texel[1] = r.cluster / columns;
                                        texel[2] = r.texel.x, texel[3] = r.texel.y;
                                    });
    if (id == TextureId::receiver_transport)
        return filled<float>(id, counts, [&](std::size_t receiver, std::size_t x, std::size_t, float* texel) {
            *texel = a.u[receiver * std::size_t(a.singular_values) + x];
        });
    if (id == TextureId::receiver_material)
        return filled<std::int32_t>(
            id, counts, [&](std::size_t receiver, std::size_t, std::size_t, std::int32_t* texel) {
                texel[0] = a.receivers[receiver].material, texel[1] = std::int32_t(a.receivers[receiver].border);
            });
    return filled<float>(id, counts, [&](std::size_t receiver, std::size_t, std::size_t, float* texel) {
        put_position(a.receivers[receiver].position, texel);
    });
}

Array checked_texture(TextureId id, const BakeArrays& arrays, const TextureLayout& layout) {
    const TextureInfo& info = info_of(id);
    const TextureCounts counts = counts_of(arrays, layout);
    const Shape shape = grid_of(id, counts).shape(info.channels);
    if (shape[0] > layout.largest || shape[1] > layout.largest)
        throw InputError("texture \"" + std::string(info.name) + "\": " + std::to_string(shape[1]) + " x " +
                         std::to_string(shape[0]) + " texels; a side has at most " + std::to_string(layout.largest));
    const std::string name = info.name;
    if (name.starts_with("cluster")) return cluster_texture(id, arrays, counts);
    if (name.starts_with("receiver")) return receiver_texture(id, arrays, counts);
    return probe_texture(id, arrays, counts);
}

}  // namespace

const std::vector<TextureInfo>& textures() {
    static const std::vector<TextureInfo> all = {
        {"probe_rays", "IPR 3.2.5.1", rgba, DType::f32, 4, "",
         "ray x of probe y: material of its hit (-1: none; -2: the back of a surface), u, v of the lightmap; w: 0"},
        {"spherical_harmonics", "IPR 3.2.5.2", "R32_SFLOAT", DType::f32, 1, "", "Y_j in the direction of ray x, j = y"},
        {"cluster_matrix", "IPR 3.2.5.3", "R32_SFLOAT", DType::f32, 1, "",
         "a cluster: Sigma V^T upright, x: singular value, y: probe * coefficients + coefficient"},
        {"cluster_size", "IPR 3.2.5.4", "R32_SINT", DType::i32, 1, "", "a cluster: how many probes support it"},
        {"cluster_probes", "IPR 3.2.5.5", "R32_SINT", DType::i32, 1, "",
         "a cluster: the probes that support it, one below the other, in the order of its matrix"},
        {"receiver_map", "IPR 3.2.5.6", "R32G32B32A32_SINT", DType::i32, 4, "",
         "a receiver: c_x, c_y of its cluster (-1, -1: no probe supports it), x, y of its texel in the lightmap"},
        {"receiver_transport", "IPR 3.2.5.7", "R32_SFLOAT", DType::f32, 1, "",
         "a receiver: its row of U, x: singular value"},
        {"receiver_material", "IPR 3.2.5.8", "R32G32_SINT", DType::i32, 2, "",
         "a receiver: its material; extend: 4 bits, neighbours to extend into"},
        {"probe_position", "IPR 3.2.5.9 1)", rgba, DType::f32, 4, "m", "probe x; w: 1"},
        {"hit_position", "IPR 3.2.5.9 2)", rgba, DType::f32, 4, "m",
         "hit of ray x of probe y; w: 1, 0 where there is none"},
        {"receiver_position", "IPR 3.2.5.9 3)", rgba, DType::f32, 4, "m", "a receiver; w: 1"},
        {"cluster_bounds", "IPR 3.2.5.9 4)", rgba, DType::f32, 4, "m",
         "a cluster: 8 corners of its box, corner x at the high end of axis k where bit k of x is set; w: 1"},
    };
    return all;
}

Array texture(const std::string& name, const BakeArrays& arrays, const TextureLayout& layout) {
    check(arrays);
    return checked_texture(texture_id(name), arrays, layout);
}

Bundle all_textures(const BakeArrays& arrays, const TextureLayout& layout) {
    check(arrays);
    Bundle bundle;
    for (int id = 0; id < texture_count; ++id) bundle.arrays.push_back(checked_texture(TextureId(id), arrays, layout));
    return bundle;
}

}  // namespace plumb::probes
