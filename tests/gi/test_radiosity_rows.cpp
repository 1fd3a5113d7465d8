// Rows of form factors: what hemicubes see, summed and packed, against sums over the items of each texel.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/formats.h"
#include "gi/lend.h"
#include "gi/radiosity/gather_kernel.h"
#include "gi/radiosity/rows.h"
#include "tests/gi/radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;

namespace {

// A cube whose faces are cut unevenly, a smaller one in it whose backs are seen, too, and two sheets that lie upon each other: of what is
// equally near the first triangle counts.
Scene cubes() {
    Scene s = test::cube(3, {});
    for (Mesh m : test::cube(2, {}, 0.3).meshes) {
        for (Vertex& v : m.vertices) v.position += glm::vec3(0.4f, 0.1f, 0.3f);
        s.meshes.push_back(m);
    }
    for (int k = 0; k < 2; ++k) s.meshes.push_back(test::grid({0.1, 0.8, 0.1}, {0, 0, 0.5}, {0.5, 0, 0}, 3, 3, test::add_material(s, 0.5)));
    return s;
}

struct Sums {
    std::vector<DenseRow> rows;
    int texels = 0, backs = 0, ties = 0;
};

// Texel after texel of the items, in the kernel's words.
Sums sums_of(const Elements& e, int size) {
    Buffer<glm::vec4> vertices;
    Buffer<glm::ivec4> triangles;
    for (const Vertex& v : e.geometry.vertices) vertices.push_back(glm::vec4(v.position, 0));
    for (const glm::uvec3& t : e.geometry.triangles) triangles.push_back(glm::ivec4(glm::ivec3(t), 0));
    const Buffer<glm::vec4> eyes = eyes_of(e.eye, e.normal);
    const std::vector<double> weights = texel_weights(size, Weights::exact);
    const float texel = 2.0f / float(size);
    const ItemsView v{{size, rows_of_hemicube(size) * e.count(), int(vertices.size()), int(triangles.size()), texel, texel / 64, {}},
                      &eyes[0].x, &vertices[0].x, &triangles[0].x, nullptr, nullptr};
    Sums sums;
    NoTap tap;
    double all = 0, all_floats = 0;
    for (const double weight : weights) all += weight, all_floats += double(float(weight));
    for (int i = 0; i < e.count(); ++i) {
        DenseRow& row = sums.rows.emplace_back();
        row.share.assign(std::size_t(e.count()), 0.0f);
        for (int y = 0; y < rows_of_hemicube(size); ++y)
            for (int x = 0; x < size; ++x, ++sums.texels) {
                const Item<float> item = radiosity::item<float>(v, x, y + i * rows_of_hemicube(size), tap);
                const float weight = float(weights[std::size_t(y * size + x)]);
                sums.backs += item.seen.w < 0 ? 1 : 0;
                if (!(item.seen.w > 0)) {
                    (item.seen.w < 0 ? row.back : row.escaped) += double(weight);
                    continue;
                }
                const glm::uvec3& of = e.of[std::size_t(item.triangle)];
                sums.ties += item.triangle >= int(triangles.size()) - 36 ? 1 : 0;
                row.share[of.x] += weight * (1.0f - item.seen.x - item.seen.y);
                row.share[of.y] += weight * item.seen.x;
                row.share[of.z] += weight * item.seen.y;
            }
        // What floats lose of weights, and of sums of them, is not lost of the row.
        row.sum = all * std::max(0.0, 1 - (row.escaped + row.back) / all_floats);
    }
    return sums;
}

template <class T>
bool same_list(const T& a, const T& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}
bool same_rows(const RowBlock& a, const RowBlock& b) {
    return a.first == b.first && a.count == b.count && same_list(a.rows, b.rows) && same_list(a.runs, b.runs) && same_list(a.weights, b.weights) &&
           same_list(a.scale, b.scale) && same_list(a.sum, b.sum) && same_list(a.escaped, b.escaped) && same_list(a.back, b.back);
}

RowBlock packed(const std::vector<float>& share) {
    RowBlock block;
    pack({share, 0, 0}, block);
    return block;
}

}  // namespace

TEST_CASE("radiosity rows: the same bits as texel after texel of the kernel's items, in any order of triangles", "[radiosity][HEM 5.6][bits]") {
    const Elements e = elements_of(cubes(), {});
    REQUIRE(e.count() < rows_of_block);
    for (const int size : {2, 6, 14}) {
        const Sums sums = sums_of(e, size);
        CAPTURE(size, e.count(), sums.texels, sums.backs, sums.ties);
        CHECK(sums.backs > sums.texels / 100);
        CHECK((size == 2 || sums.ties > sums.texels / 200));
        RowBlock expected;
        for (const DenseRow& row : sums.rows) pack(row, expected);
        expected.weights.resize(expected.weights.size() + row_lanes, Half{0});
        for (const Isa isa : supported_isas())
            for (const int threads : {1, 2}) {
                RunOptions options;
                options.isa = isa, options.threads = threads;
                const FormFactors f = form_factors(e, {size, Weights::exact}, options);
                CAPTURE(isa_name(isa), threads);
                REQUIRE(f.blocks.size() == 1);
                CHECK(same_rows(f.blocks[0], expected));
            }
    }
}

TEST_CASE("radiosity rows: many blocks are those of one", "[radiosity][bits]") {
    const Elements e = elements_of(test::cube(9, {}), {});
    REQUIRE(e.count() > 2 * rows_of_block);
    RunOptions one, three;
    one.threads = 1, three.threads = 3;
    const FormFactors a = form_factors(e, {8, Weights::exact}, one), b = form_factors(e, {8, Weights::exact}, three);
    REQUIRE(a.blocks.size() == std::size_t((e.count() + rows_of_block - 1) / rows_of_block));
    int next = 0;
    for (std::size_t k = 0; k < a.blocks.size(); ++k) {
        CHECK(a.blocks[k].first == next);
        CHECK(same_rows(a.blocks[k], b.blocks[k]));
        next += a.blocks[k].count;
    }
    CHECK(next == e.count());
    // All that a closed cube's vertex sees is the cube.
    for (int i = 0; i < e.count(); i += 37) {
        std::vector<float> row(std::size_t(e.count()), 0.0f);
        a.add_row(i, row);
        double sum = 0;
        for (const float f : row) sum += double(f);
        CHECK(sum == Approx(1).epsilon(2e-6));
    }
}

TEST_CASE("radiosity rows: runs, gaps, and halves that keep the row's sum", "[radiosity][analytic]") {
    // A gap of three zeros is kept, one of four begins another run; runs go over words of sixteen.
    std::vector<float> share(70, 0.0f);
    for (const int j : {3, 7, 12, 13, 14, 15, 16, 17, 31, 32, 48, 69}) share[std::size_t(j)] = 0.25f;
    const RowBlock b = packed(share);
    REQUIRE(b.count == 1);
    const std::vector<glm::ivec2> runs = {{3, 5}, {12, 6}, {31, 2}, {48, 1}, {69, 1}};
    CHECK(std::vector<glm::ivec2>(b.runs.begin(), b.runs.end()) == runs);
    CHECK(b.rows[0] == glm::ivec4(0, 5, 0, 15));
    for (int k = 0; k < 15; ++k) CHECK(half_to_float(b.weights[std::size_t(k)]) == (k >= 1 && k <= 3 ? 0.0f : 0x1p15f));
    CHECK(b.scale[0] == 0x1p-17f);

    // 2^15 stands for the largest; below 2^-14 nothing is kept, and its share goes to the others.
    const RowBlock small = packed({1, 0, 0x1p-29f, 0, 0, 0, 0, 0x1p-30f});
    CHECK(small.runs.size() == 1);
    CHECK(small.rows[0] == glm::ivec4(0, 1, 0, 3));
    CHECK(half_to_float(small.weights[2]) == 0x1p-14f);
    CHECK(double(small.scale[0]) * (0x1p15 + 0x1p-14) == Approx(1 + 0x1p-29 + 0x1p-30).epsilon(1e-7));

    // Rounded to the nearest half, ties to the even one, by each instruction set as float_to_half() says.
    std::vector<float> uneven;
    for (int j = 0; j < 333; ++j) uneven.push_back(j % 5 == 1 ? 0.0f : std::ldexp(1.0f + float(j * 2654435761u % 65536u) / 65536.0f, -(j % 19)));
    uneven[200] = 1 + 0x1p-11f, uneven[201] = 1 + 3 * 0x1p-11f, uneven[202] = 2;
    const RowBlock u = packed(uneven);
    double all = 0, kept = 0;
    for (const float s : uneven) all += double(s);
    std::size_t at = 0;
    for (const glm::ivec2& run : u.runs)
        for (int k = 0; k < run.y; ++k) {
            const Half half = u.weights[at++];
            CHECK(half.bits == float_to_half(uneven[std::size_t(run.x + k)] * 0x1p14f).bits);
            kept += double(half_to_float(half));
        }
    CHECK(at == u.weights.size());
    CHECK(double(u.scale[0]) * kept == Approx(all).epsilon(1e-7));

    CHECK(packed(std::vector<float>(40, 0.0f)).rows[0] == glm::ivec4(0));
    CHECK(packed(std::vector<float>(40, 0.0f)).scale[0] == 0);
}
