// Data textures back to the arrays of a bake.
#include <algorithm>
#include <bit>

#include "core/error.h"
#include "gi/probes/texture_items.h"

namespace plumb::probes {
namespace {

[[noreturn]] void fail(TextureId id, const std::string& cause) {
    throw InputError("texture \"" + std::string(info_of(id).name) + "\": " + cause);
}

// Reads the texels of items, whose grid the sizes of the textures imply.
class TextureReader {
  public:
    explicit TextureReader(const Bundle& textures) {
        for (int id = 0; id < texture_count; ++id) {
            const TextureInfo& info = info_of(TextureId(id));
            const Array& array = at(textures, info.name);
            require(array, info.dtype, {any_extent, any_extent, info.channels});
            if (array.bytes.empty()) fail(TextureId(id), "has no texels");
            arrays_[id] = &array;
        }
        counts_.probes = height(TextureId::probe_rays), counts_.rays = width(TextureId::probe_rays);
        counts_.coefficients = height(TextureId::spherical_harmonics);
        counts_.cluster_columns = width(TextureId::cluster_size);
        counts_.receiver_columns = width(TextureId::receiver_map);
        counts_.clusters = count<1>(TextureId::cluster_size, 0);
        counts_.receivers = count<4>(TextureId::receiver_map, 2);
        counts_.singular_values =
            share(TextureId::receiver_transport, width(TextureId::receiver_transport), counts_.receiver_columns);
        counts_.cluster_probes =
            share(TextureId::cluster_probes, height(TextureId::cluster_probes), height(TextureId::cluster_size));
        for (int id = 0; id < texture_count; ++id) {
            grids_.push_back(grid_of(TextureId(id), counts_));
            require(*arrays_[id], arrays_[id]->dtype, grids_.back().shape(info_of(TextureId(id)).channels));
        }
    }
    const TextureCounts& counts() const { return counts_; }

    template <class T>
    const T* texel(TextureId id, std::size_t item, std::size_t x = 0, std::size_t y = 0) const {
        const Array& array = *arrays_[int(id)];
        return reinterpret_cast<const T*>(array.bytes.data()) +
               grids_[std::size_t(id)].texel(std::int64_t(item), std::int64_t(x), std::int64_t(y)) *
                   std::size_t(array.shape[2]);
    }
    glm::vec3 position(TextureId id, std::size_t item, std::size_t x = 0) const {
        const float* p = texel<float>(id, item, x);
        return {p[0], p[1], p[2]};
    }

  private:
    std::int64_t height(TextureId id) const { return arrays_[int(id)]->shape[0]; }
    std::int64_t width(TextureId id) const { return arrays_[int(id)]->shape[1]; }

    // The texels of an item, where `items` lie side by side.
    static std::int64_t share(TextureId id, std::int64_t texels, std::int64_t items) {
        if (texels % items != 0)
            fail(id, std::to_string(texels) + " texels are not a multiple of " + std::to_string(items) + " items");
        return texels / items;
    }

    // Counts the texels before the first whose channel is negative: what follows is padding.
    template <int Channels>
    std::int64_t count(TextureId id, int channel) const {
        const auto values = elements<std::int32_t>(*arrays_[int(id)], {any_extent, any_extent, Channels});
        std::int64_t n = 0;
        while (std::size_t(n * Channels) < values.size() && values[std::size_t(n * Channels + channel)] >= 0) ++n;
        if (n == 0) fail(id, "has nothing but padding");
        return n;
    }

    const Array* arrays_[texture_count] = {};
    std::vector<ItemGrid> grids_;
    TextureCounts counts_;
};

void read_receivers(const TextureReader& in, BakeArrays& a) {
    const TextureCounts& n = in.counts();
    a.receivers.resize(std::size_t(n.receivers));
    for (std::size_t i = 0; i < a.receivers.size(); ++i) {
        BakedReceiver& r = a.receivers[i];
        const std::int32_t* map = in.texel<std::int32_t>(TextureId::receiver_map, i);
        if (map[0] >= 0 && map[1] >= 0 && map[0] < n.cluster_columns) {
            const std::int64_t cluster = map[1] * n.cluster_columns + map[0];
            r.cluster = int(std::min<std::int64_t>(cluster, n.clusters));  // too large stays too large
        }
        r.texel = {map[2], map[3]};
        r.material = in.texel<std::int32_t>(TextureId::receiver_material, i)[0];
        r.border = unsigned(in.texel<std::int32_t>(TextureId::receiver_material, i)[1]);
        r.position = in.position(TextureId::receiver_position, i);
        const float* u = in.texel<float>(TextureId::receiver_transport, i);
        a.u.insert(a.u.end(), u, u + n.singular_values);
    }
}

void read_probes(const TextureReader& in, BakeArrays& a) {
    const TextureCounts& n = in.counts();
    for (std::size_t probe = 0; probe < std::size_t(n.probes); ++probe) {
        a.probes.push_back(in.position(TextureId::probe_position, probe));
        for (std::size_t ray = 0; ray < std::size_t(n.rays); ++ray) {
            const float* hit = in.texel<float>(TextureId::probe_rays, probe, ray);
            if (!(hit[0] >= -2 && hit[0] < 0x1p24f)) fail(TextureId::probe_rays, "a material is no index");
            a.relight.push_back({int(hit[0]), {hit[1], hit[2]}, in.position(TextureId::hit_position, probe, ray)});
        }
    }
    for (std::size_t ray = 0; ray < std::size_t(n.rays); ++ray)
        for (std::size_t j = 0; j < std::size_t(n.coefficients); ++j)
            a.sh.push_back(*in.texel<float>(TextureId::spherical_harmonics, 0, ray, j));
}

void read_clusters(const TextureReader& in, BakeArrays& a) {
    const TextureCounts& n = in.counts();
    a.clusters.resize(std::size_t(n.clusters));
    for (std::size_t i = 0; i < a.clusters.size(); ++i) {
        BakedCluster& c = a.clusters[i];
        const std::int32_t size = *in.texel<std::int32_t>(TextureId::cluster_size, i);
        if (size > n.cluster_probes)
            fail(TextureId::cluster_size, "a cluster has more probes than \"cluster_probes\" holds");
        for (std::size_t k = 0; k < std::size_t(size); ++k)
            c.probes.push_back(*in.texel<std::int32_t>(TextureId::cluster_probes, i, 0, k));

        // The rank ends with the last column that is not all zeros.
        const std::size_t rows = c.probes.size() * std::size_t(n.coefficients);
        for (std::size_t s = 0; s < std::size_t(n.singular_values); ++s)
            for (std::size_t y = 0; y < rows; ++y)
                if (std::bit_cast<std::uint32_t>(*in.texel<float>(TextureId::cluster_matrix, i, s, y)))
                    c.rank = int(s) + 1;
        for (std::size_t s = 0; s < std::size_t(c.rank); ++s)
            for (std::size_t y = 0; y < rows; ++y)
                c.sigma_vt.push_back(*in.texel<float>(TextureId::cluster_matrix, i, s, y));
        c.low = in.position(TextureId::cluster_bounds, i, 0), c.high = in.position(TextureId::cluster_bounds, i, 7);
    }
}

// The same arrays make the same textures: a texel that says something else says what no bake can.
void require_same(const Bundle& textures, const BakeArrays& arrays, const TextureCounts& counts) {
    const TextureLayout layout{int(counts.cluster_columns), int(counts.receiver_columns), 0x7fffffff};
    for (int id = 0; id < texture_count; ++id) {
        const TextureInfo& info = info_of(TextureId(id));
        const Array made = texture(info.name, arrays, layout);
        const Array& given = at(textures, info.name);
        require(given, made.dtype, made.shape);
        const auto [a, b] = std::mismatch(made.bytes.begin(), made.bytes.end(), given.bytes.begin());
        if (a == made.bytes.end()) continue;
        const std::int64_t i = (a - made.bytes.begin()) / std::int64_t(dtype_size(info.dtype)) / info.channels;
        fail(TextureId(id), "texel " + std::to_string(i % made.shape[1]) + ", " + std::to_string(i / made.shape[1]) +
                                " does not fit the others");
    }
}

}  // namespace

BakeArrays arrays_of(const Bundle& textures) {
    const TextureReader in(textures);
    BakeArrays a;
    a.rays = int(in.counts().rays), a.coefficients = int(in.counts().coefficients);
    a.singular_values = int(in.counts().singular_values);
    read_receivers(in, a);
    read_probes(in, a);
    read_clusters(in, a);
    require_same(textures, a, in.counts());
    return a;
}

}  // namespace plumb::probes
