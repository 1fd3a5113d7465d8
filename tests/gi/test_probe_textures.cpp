// The data textures of IPR 3.2.5: what lies where, and back.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <functional>
#include <limits>

#include "core/error.h"
#include "core/hash.h"
#include "gi/probes/textures.h"

using namespace plumb;
using namespace plumb::probes;

namespace {

// Numbers that are not 0, each another.
struct Dice {
    int i = 0;
    float operator()() { return 0.25f + unit_float<float>(pcg3d(i++, 5, 7).x); }
    glm::vec3 vector() { return {(*this)(), (*this)(), (*this)()}; }
    int below(int n) { return int(std::uint32_t(pcg3d(i++, 11, 13).x) % std::uint32_t(n)); }
};

struct Sizes {
    int receivers = 7, probes = 6, clusters = 5, rays = 3, coefficients = 4, singular_values = 3;
};

// Cluster i has i % 4 probes, so that some have none; the last receiver belongs to no cluster; every third ray hits
// nothing.
BakeArrays sample(const Sizes& n = {}) {
    Dice dice;
    BakeArrays a;
    a.rays = n.rays, a.coefficients = n.coefficients, a.singular_values = n.singular_values;
    for (int i = 0; i < n.probes; ++i) a.probes.push_back(dice.vector());
    for (int i = 0; i < n.probes * n.rays; ++i) {
        BakedRay ray{i % 3 == 2 ? -1 : dice.below(9), {dice(), dice()}, {}};
        if (ray.material >= 0) ray.position = dice.vector();
        a.relight.push_back(ray);
    }
    for (int i = 0; i < n.rays * n.coefficients; ++i) a.sh.push_back(dice());
    for (int i = 0; i < n.clusters; ++i) {
        BakedCluster c;
        for (int k = 0; k < i % 4; ++k) c.probes.push_back((i + 2 * k) % n.probes);
        c.rank = c.probes.empty() ? 0 : 1 + i % n.singular_values;
        for (int k = 0; k < c.rank * int(c.probes.size()) * n.coefficients; ++k) c.sigma_vt.push_back(dice());
        c.low = dice.vector(), c.high = c.low + dice.vector();
        a.clusters.push_back(c);
    }
    for (int i = 0; i < n.receivers; ++i) {
        a.receivers.push_back({dice.vector(),
                               {i, 2 * i + 1},
                               dice.below(9),
                               unsigned(dice.below(16)),
                               i + 1 < n.receivers ? i % n.clusters : -1});
        for (int s = 0; s < n.singular_values; ++s) a.u.push_back(dice());
    }
    return a;
}

bool same(const BakeArrays& a, const BakeArrays& b) {
    const auto receiver = [](const BakedReceiver& p, const BakedReceiver& q) {
        return p.position == q.position && p.texel == q.texel && p.material == q.material && p.border == q.border &&
               p.cluster == q.cluster;
    };
    const auto ray = [](const BakedRay& p, const BakedRay& q) {
        return p.material == q.material && p.uv == q.uv && p.position == q.position;
    };
    const auto cluster = [](const BakedCluster& p, const BakedCluster& q) {
        return p.probes == q.probes && p.rank == q.rank && p.sigma_vt == q.sigma_vt && p.low == q.low &&
               p.high == q.high;
    };
    const auto equal = [](const auto& p, const auto& q, const auto& one) {
        return std::equal(p.begin(), p.end(), q.begin(), q.end(), one);
    };
    return a.rays == b.rays && a.coefficients == b.coefficients && a.singular_values == b.singular_values &&
           equal(a.receivers, b.receivers, receiver) && a.u == b.u && a.probes == b.probes &&
           equal(a.relight, b.relight, ray) && a.sh == b.sh && equal(a.clusters, b.clusters, cluster);
}

template <class Action>
std::string error_of(Action action) {
    try {
        action();
        return "";
    } catch (const InputError& e) {
        return e.what();
    }
}

// texelFetch of a shader.
template <class T>
const T* fetch(const Bundle& textures, const char* name, int x, int y) {
    const Array& array = at(textures, name);
    REQUIRE((x >= 0 && y >= 0 && x < array.shape[1] && y < array.shape[0]));
    return reinterpret_cast<const T*>(array.bytes.data()) + (y * array.shape[1] + x) * array.shape[2];
}

}  // namespace

TEST_CASE("probe textures: twelve, each in its place with its format", "[probes][IPR 3.2.5]") {
    // Sizes by hand: 5 clusters in rows of 2 make 3 rows, the largest has 3 probes: 12 rows of 4 coefficients. 7
    // receivers in rows of 4 make 2 rows.
    const Bundle all = all_textures(sample(), {.clusters_in_row = 2, .receivers_in_row = 4});
    const std::vector<std::tuple<std::string, DType, Shape>> expected = {
        {"probe_rays", DType::f32, {6, 3, 4}},          {"spherical_harmonics", DType::f32, {4, 3, 1}},
        {"cluster_matrix", DType::f32, {36, 6, 1}},     {"cluster_size", DType::i32, {3, 2, 1}},
        {"cluster_probes", DType::i32, {9, 2, 1}},      {"receiver_map", DType::i32, {2, 4, 4}},
        {"receiver_transport", DType::f32, {2, 12, 1}}, {"receiver_material", DType::i32, {2, 4, 2}},
        {"probe_position", DType::f32, {1, 6, 4}},      {"hit_position", DType::f32, {6, 3, 4}},
        {"receiver_position", DType::f32, {2, 4, 4}},   {"cluster_bounds", DType::f32, {3, 16, 4}},
    };
    REQUIRE(all.arrays.size() == expected.size());
    REQUIRE(textures().size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const auto& [name, dtype, shape] = expected[i];
        CAPTURE(name);
        CHECK(all.arrays[i].name == name);
        CHECK(all.arrays[i].dtype == dtype);
        CHECK(all.arrays[i].shape == shape);
        // One by one, it is the same.
        const Array one = texture(name, sample(), {.clusters_in_row = 2, .receivers_in_row = 4});
        CHECK(content_hash(one) == content_hash(all.arrays[i]));
        // The format says what the array is: R32 four times over, float or signed.
        const std::string format = textures()[i].vk_format;
        CHECK(format == std::string("R32G32B32A32").substr(0, std::size_t(3 * shape[2])) +
                            (dtype == DType::f32 ? "_SFLOAT" : "_SINT"));
    }
}

TEST_CASE("probe textures: every item lies where the table says", "[probes][IPR 3.2.5]") {
    const BakeArrays a = sample();
    const Bundle t = all_textures(a, {.clusters_in_row = 2, .receivers_in_row = 4});
    // Ray 1 of probe 4; of probe 2, whose ray 2 is the ninth of all, it hits nothing.
    const BakedRay& hit = a.relight[4 * 3 + 1];
    CHECK(fetch<float>(t, "probe_rays", 1, 4)[0] == float(hit.material));
    CHECK(fetch<float>(t, "probe_rays", 1, 4)[1] == hit.uv.x);
    CHECK(fetch<float>(t, "probe_rays", 1, 4)[2] == hit.uv.y);
    CHECK(fetch<float>(t, "hit_position", 1, 4)[2] == hit.position.z);
    CHECK(fetch<float>(t, "hit_position", 1, 4)[3] == 1);
    CHECK(fetch<float>(t, "probe_rays", 2, 2)[0] == -1);
    CHECK(fetch<float>(t, "probe_rays", 2, 2)[1] == a.relight[8].uv.x);
    CHECK(fetch<float>(t, "hit_position", 2, 2)[3] == 0);
    // Y_3 of ray 2.
    CHECK(*fetch<float>(t, "spherical_harmonics", 2, 3) == a.sh[2 * 4 + 3]);
    // Cluster 3 has index (1, 1), three probes and rank 1; row 1 of its Sigma V^T is not there.
    const BakedCluster& c = a.clusters[3];
    REQUIRE((c.probes.size() == 3 && c.rank == 1));
    CHECK(*fetch<std::int32_t>(t, "cluster_size", 1, 1) == 3);
    CHECK(*fetch<std::int32_t>(t, "cluster_probes", 1, 3 + 2) == c.probes[2]);
    CHECK(*fetch<float>(t, "cluster_matrix", 3 + 0, 12 + 2 * 4 + 1) == c.sigma_vt[2 * 4 + 1]);
    CHECK(*fetch<float>(t, "cluster_matrix", 3 + 1, 12 + 2 * 4 + 1) == 0);
    // Corner 5 = 101 in binary: high in x and z.
    CHECK(fetch<float>(t, "cluster_bounds", 8 + 5, 1)[0] == c.high.x);
    CHECK(fetch<float>(t, "cluster_bounds", 8 + 5, 1)[1] == c.low.y);
    CHECK(fetch<float>(t, "cluster_bounds", 8 + 5, 1)[2] == c.high.z);
    // Receiver 5 is the second of the second row, and of cluster 0; receiver 3 of cluster (1, 1).
    CHECK(fetch<std::int32_t>(t, "receiver_map", 1, 1)[2] == 5);
    CHECK(fetch<std::int32_t>(t, "receiver_map", 1, 1)[3] == 11);
    CHECK(fetch<std::int32_t>(t, "receiver_map", 1, 1)[0] == 0);
    CHECK(fetch<std::int32_t>(t, "receiver_map", 3, 0)[0] == 1);
    CHECK(fetch<std::int32_t>(t, "receiver_map", 3, 0)[1] == 1);
    CHECK(*fetch<float>(t, "receiver_transport", 1 * 3 + 2, 1) == a.u[5 * 3 + 2]);
    CHECK(fetch<std::int32_t>(t, "receiver_material", 1, 1)[1] == std::int32_t(a.receivers[5].border));
    // Receiver 6 has no probe; receiver 7 is not there.
    CHECK(fetch<std::int32_t>(t, "receiver_map", 2, 1)[0] == -1);
    CHECK(fetch<std::int32_t>(t, "receiver_map", 2, 1)[2] == 6);
    for (int k = 0; k < 4; ++k) CHECK(fetch<std::int32_t>(t, "receiver_map", 3, 1)[k] == -1);
    CHECK(fetch<std::int32_t>(t, "receiver_material", 3, 1)[0] == -1);
    CHECK(*fetch<float>(t, "receiver_transport", 3 * 3, 1) == 0);
    CHECK(fetch<float>(t, "receiver_position", 3, 1)[3] == 0);
    CHECK(fetch<float>(t, "receiver_position", 2, 1)[3] == 1);
    // Cluster 5 is not there; cluster 0 is, without probes.
    CHECK(*fetch<std::int32_t>(t, "cluster_size", 1, 2) == -1);
    CHECK(*fetch<std::int32_t>(t, "cluster_size", 0, 0) == 0);
    CHECK(*fetch<std::int32_t>(t, "cluster_probes", 0, 0) == -1);
    CHECK(fetch<float>(t, "cluster_bounds", 8, 2)[3] == 0);
}

TEST_CASE("probe textures: back they are the arrays, for every width of rows", "[probes][IPR 3.2.5]") {
    for (const Sizes& sizes :
         {Sizes{}, Sizes{1, 1, 1, 1, 1, 1}, Sizes{300, 20, 131, 16, 9, 32}, Sizes{129, 3, 2, 2, 64, 8}})
        for (int clusters_in_row : {1, 2, 5, 128})
            for (int receivers_in_row : {1, 4, 128}) {
                const BakeArrays a = sample(sizes);
                const TextureLayout layout{clusters_in_row, receivers_in_row, 65536};
                const Bundle made = all_textures(a, layout);
                const BakeArrays back = arrays_of(made);
                CHECK(same(back, a));
                CHECK(content_hash(all_textures(back, layout)) == content_hash(made));
            }
    // The order of a bundle does not count.
    Bundle reversed = all_textures(sample());
    std::reverse(reversed.arrays.begin(), reversed.arrays.end());
    CHECK(same(arrays_of(reversed), sample()));
    // A rank ends where rows of zeros begin, and only there.
    BakeArrays zeros = sample();
    BakedCluster& c = zeros.clusters[2];  // rank 3, 2 probes
    REQUIRE(c.sigma_vt.size() == 24);
    std::fill(c.sigma_vt.begin() + 8, c.sigma_vt.begin() + 16, 0.f);
    CHECK(same(arrays_of(all_textures(zeros)), zeros));
    std::fill(c.sigma_vt.begin() + 16, c.sigma_vt.end(), 0.f);
    const BakeArrays shorter = arrays_of(all_textures(zeros));
    CHECK(shorter.clusters[2].rank == 1);
    CHECK(content_hash(all_textures(shorter)) == content_hash(all_textures(zeros)));
}

// What the three passes of the run time do (IPR 3.3.1.2, 3.3.1.3): a shader that sees nothing but the textures gets the
// bits that the arrays give, summed in the same order.
TEST_CASE("probe textures: irradiance from texels is that of the arrays", "[probes][IPR 3.3.1]") {
    const Sizes sizes{300, 20, 131, 16, 9, 32};
    const BakeArrays a = sample(sizes);
    const TextureLayout layout{16, 128, 16384};
    const Bundle t = all_textures(a, layout);
    Dice dice{1000};
    std::vector<float> lambda(a.probes.size() * 9);
    for (float& x : lambda) x = dice();

    const std::int64_t height = at(t, "cluster_matrix").shape[0] / at(t, "cluster_size").shape[0];
    const std::int64_t most_probes = at(t, "cluster_probes").shape[0] / at(t, "cluster_size").shape[0];
    std::size_t lit = 0, differ = 0;
    for (int i = 0; i < 384; ++i) {
        const std::int32_t* map = fetch<std::int32_t>(t, "receiver_map", i % 128, i / 128);
        if (map[2] < 0) continue;                   // padding
        const std::size_t r = std::size_t(map[2]);  // sample() numbers texels so
        const BakedReceiver& receiver = a.receivers[r];
        float from_texels = 0, from_arrays = 0;
        for (int s = 0; s < 32; ++s) {
            float b = 0;
            const int size = map[0] < 0 ? 0 : *fetch<std::int32_t>(t, "cluster_size", map[0], map[1]);
            for (int k = 0; k < size; ++k) {
                const int probe = *fetch<std::int32_t>(t, "cluster_probes", map[0], int(map[1] * most_probes + k));
                for (int j = 0; j < 9; ++j)
                    b += *fetch<float>(t, "cluster_matrix", map[0] * 32 + s, int(map[1] * height + k * 9 + j)) *
                         lambda[std::size_t(probe * 9 + j)];
            }
            from_texels += *fetch<float>(t, "receiver_transport", i % 128 * 32 + s, i / 128) * b;
        }
        if (receiver.cluster >= 0) {
            const BakedCluster& c = a.clusters[std::size_t(receiver.cluster)];
            for (int s = 0; s < c.rank; ++s) {
                float b = 0;
                for (std::size_t k = 0; k < c.probes.size() * 9; ++k)
                    b += c.sigma_vt[std::size_t(s) * c.probes.size() * 9 + k] *
                         lambda[std::size_t(c.probes[k / 9]) * 9 + k % 9];
                from_arrays += a.u[r * 32 + std::size_t(s)] * b;
            }
        }
        lit += from_arrays > 0;
        differ += from_texels != from_arrays;
    }
    // Of 299 receivers with a cluster, those of cluster 4 k have no probe: 33 clusters twice, the first 10 of them
    // thrice.
    CHECK(lit == 299 - 76);
    CHECK(differ == 0);
}

TEST_CASE("probe textures: what a GPU cannot hold is one line", "[probes][robustness]") {
    const auto refused = [](const Sizes& sizes, const char* name, const TextureLayout& layout = {}) {
        return error_of([&] { texture(name, sample(sizes), layout); });
    };
    // 65 clusters in rows of 1 with 3 probes of 64 coefficients: 65 * 192 rows; 86 clusters are 16512.
    CHECK(refused({1, 4, 85, 1, 64, 1}, "cluster_matrix", {.clusters_in_row = 1}) == "");
    CHECK(refused({1, 4, 86, 1, 64, 1}, "cluster_matrix", {.clusters_in_row = 1}) ==
          "texture \"cluster_matrix\": 1 x 16512 texels; a side has at most 16384");
    CHECK(refused({1, 4, 86, 1, 64, 1}, "cluster_matrix") == "");
    CHECK(refused({600, 1, 1, 1, 1, 32}, "receiver_transport", {.receivers_in_row = 512}) == "");
    CHECK(refused({600, 1, 1, 1, 1, 32}, "receiver_transport", {.receivers_in_row = 513}) ==
          "texture \"receiver_transport\": 16416 x 2 texels; a side has at most 16384");
    CHECK(refused({1, 1, 1, 16385, 1, 1}, "probe_rays") ==
          "texture \"probe_rays\": 16385 x 1 texels; a side has at most 16384");
    CHECK(refused({1, 16385, 1, 1, 1, 1}, "probe_position") ==
          "texture \"probe_position\": 16385 x 1 texels; a side has at most 16384");
    CHECK(refused({}, "cluster_matrix", {.largest = 8}) ==
          "texture \"cluster_matrix\": 15 x 12 texels; a side has at most 8");
    CHECK(refused({}, "cluster_map") ==
          "texture \"cluster_map\" is unknown; expected one of probe_rays, spherical_harmonics, cluster_matrix, "
          "cluster_size, cluster_probes, receiver_map, receiver_transport, receiver_material, probe_position, "
          "hit_position, receiver_position, cluster_bounds");
    CHECK(refused({}, "cluster_size", {.clusters_in_row = 0}) ==
          "textures: a row has at least one cluster and one receiver");
}

TEST_CASE("probe textures: arrays that are no bake's are one line", "[probes][robustness]") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
    const std::vector<std::pair<std::string, std::function<void(BakeArrays&)>>> cases = {
        {"bake: no receivers: a texture has at least one texel", [](BakeArrays& a) { a.receivers.clear(); }},
        {"bake: no probes: a texture has at least one texel", [](BakeArrays& a) { a.probes.clear(); }},
        {"bake: no clusters: a texture has at least one texel", [](BakeArrays& a) { a.clusters.clear(); }},
        {"bake: no rays: a texture has at least one texel", [](BakeArrays& a) { a.rays = -3; }},
        {"bake: u: 20 values; expected 21", [](BakeArrays& a) { a.u.pop_back(); }},
        {"bake: relight rays: 18 values; expected 24", [](BakeArrays& a) { a.rays = 4; }},
        {"bake: spherical harmonics: 12 values; expected 15", [](BakeArrays& a) { a.coefficients = 5; }},
        {"bake: receiver 3: its position is not finite", [=](BakeArrays& a) { a.receivers[3].position.y = nan; }},
        {"bake: receiver 3: its texel is negative", [](BakeArrays& a) { a.receivers[3].texel.y = -1; }},
        {"bake: receiver 3: material -1", [](BakeArrays& a) { a.receivers[3].material = -1; }},
        {"bake: receiver 3: material 16777216", [](BakeArrays& a) { a.receivers[3].material = 1 << 24; }},
        {"bake: receiver 3: border 16; expected 4 bits", [](BakeArrays& a) { a.receivers[3].border = 16; }},
        {"bake: receiver 3: cluster 5 of 5", [](BakeArrays& a) { a.receivers[3].cluster = 5; }},
        {"bake: receiver 3: cluster -2 of 5", [](BakeArrays& a) { a.receivers[3].cluster = -2; }},
        {"bake: u: a value is not finite", [=](BakeArrays& a) { a.u[20] = infinite; }},
        {"bake: probe 5: its position is not finite", [=](BakeArrays& a) { a.probes[5].z = -infinite; }},
        {"bake: relight ray 4: material -3", [](BakeArrays& a) { a.relight[4].material = -3; }},
        {"bake: relight ray 8: its u or v is not finite", [=](BakeArrays& a) { a.relight[8].uv.y = nan; }},
        {"bake: relight ray 4: its hit is not finite", [=](BakeArrays& a) { a.relight[4].position.x = nan; }},
        {"bake: spherical harmonics: a value is not finite", [=](BakeArrays& a) { a.sh[11] = nan; }},
        {"bake: cluster 3: rank 4; expected 0 to 3", [](BakeArrays& a) { a.clusters[3].rank = 4; }},
        {"bake: cluster 3: 12 values; expected 24", [](BakeArrays& a) { a.clusters[3].rank = 2; }},
        {"bake: cluster 3: probe 6 of 6", [](BakeArrays& a) { a.clusters[3].probes[1] = 6; }},
        {"bake: cluster 3: probe -1 of 6", [](BakeArrays& a) { a.clusters[3].probes[1] = -1; }},
        {"bake: cluster 3: a value of Sigma V^T is not finite",
         [=](BakeArrays& a) { a.clusters[3].sigma_vt[7] = nan; }},
        {"bake: cluster 3: its box is not finite", [=](BakeArrays& a) { a.clusters[3].high.x = infinite; }},
    };
    for (const auto& [message, change] : cases) {
        BakeArrays a = sample();
        change(a);
        CHECK(error_of([&] { all_textures(a); }) == message);
    }
}

TEST_CASE("probe textures: a changed texel is refused or is another bake's", "[probes][robustness]") {
    const TextureLayout layout{2, 4, 16384};
    const Bundle good = all_textures(sample(), layout);
    std::size_t refused = 0, read = 0, same_arrays = 0, other_textures = 0;
    for (std::size_t i = 0; i < good.arrays.size(); ++i)
        for (std::size_t byte = 0; byte < good.arrays[i].bytes.size(); ++byte) {
            Bundle changed = good;
            changed.arrays[i].bytes[byte] ^= static_cast<unsigned char>(1 << byte % 8);
            BakeArrays a;
            if (!error_of([&] { a = arrays_of(changed); }).empty()) {
                ++refused;
                continue;
            }
            ++read;
            same_arrays += same(a, sample());
            other_textures += content_hash(all_textures(a, layout)) != content_hash(changed);
        }
    INFO(refused << " refused, " << read << " read");
    CHECK(refused > 0);
    CHECK(read > 0);
    CHECK(same_arrays == 0);
    CHECK(other_textures == 0);
}

TEST_CASE("probe textures: what does not fit together is one line that names the texture", "[probes][robustness]") {
    const auto refuse = [](const char* name, const std::function<void(Array&)>& change) {
        Bundle bundle = all_textures(sample(), {.clusters_in_row = 2, .receivers_in_row = 4});
        for (Array& array : bundle.arrays)
            if (array.name == name) change(array);
        return error_of([&] { arrays_of(bundle); });
    };
    const auto word = [](std::size_t i, std::int32_t value) {
        return [=](Array& array) { std::memcpy(array.bytes.data() + 4 * i, &value, 4); };
    };
    const auto reshaped = [](Shape shape) {
        return [=](Array& array) {
            array.shape = shape;
            array.bytes = Bytes(element_count("x", shape) * dtype_size(array.dtype));
        };
    };
    CHECK(refuse("receiver_map", [](Array& array) { array.name = "map"; }).find("array \"receiver_map\" is missing") ==
          0);
    CHECK(refuse("cluster_size", [](Array& array) { array.dtype = DType::u32; }) ==
          "array \"cluster_size\": expected i32 [*, *, 1], got u32 [3, 2, 1]");
    CHECK(refuse("receiver_map", reshaped({2, 4, 3})) ==
          "array \"receiver_map\": expected i32 [*, *, 4], got i32 [2, 4, 3]");
    CHECK(refuse("cluster_size", reshaped({0, 2, 1})) == "texture \"cluster_size\": has no texels");
    CHECK(refuse("cluster_size", word(0, -1)) == "texture \"cluster_size\": has nothing but padding");
    CHECK(refuse("receiver_transport", reshaped({2, 11, 1})) ==
          "texture \"receiver_transport\": 11 texels are not a multiple of 4 items");
    CHECK(refuse("cluster_probes", reshaped({8, 2, 1})) ==
          "texture \"cluster_probes\": 8 texels are not a multiple of 3 items");
    CHECK(refuse("cluster_matrix", reshaped({36, 5, 1})) ==
          "array \"cluster_matrix\": expected f32 [36, 6, 1], got f32 [36, 5, 1]");
    CHECK(refuse("receiver_position", reshaped({1, 4, 4})) ==
          "array \"receiver_position\": expected f32 [2, 4, 4], got f32 [1, 4, 4]");
    CHECK(refuse("cluster_size", word(3, 4)) ==
          "texture \"cluster_size\": a cluster has more probes than \"cluster_probes\" holds");
    CHECK(refuse("probe_rays", word(0, 0x7fc00000)) == "texture \"probe_rays\": a material is no index");
    CHECK(refuse("probe_rays", word(3, 1)) == "texture \"probe_rays\": texel 0, 0 does not fit the others");
    // Receiver 6, the last, names cluster (1, 2), the first that is not there.
    CHECK(refuse("receiver_map", word(4 * 3 + 0, 7)) == "texture \"receiver_map\": texel 3, 0 does not fit the others");
    CHECK(refuse("receiver_map", word(4 * 3 + 1, 2)) == "bake: receiver 3: cluster 5 of 5");
    // Corner 5 of cluster (1, 1) is no corner of the box; a padding texel is written.
    CHECK(refuse("cluster_bounds", word(4 * (16 + 13), 0)) ==
          "texture \"cluster_bounds\": texel 13, 1 does not fit the others");
    CHECK(refuse("receiver_transport", word(12 + 9, 1)) ==
          "texture \"receiver_transport\": texel 9, 1 does not fit the others");
}
