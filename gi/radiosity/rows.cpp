#include "gi/radiosity/rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/formats.h"
#include "core/parallel.h"
#include "gi/radiosity/gather_kernel.h"
#include "gi/radiosity/row_kernel.h"

namespace plumb::radiosity {

namespace {

// Zeros between two runs that are kept as one: a run costs 8 bytes, a zero 2.
constexpr int shortest_gap = 4;
constexpr float largest_weight = 0x1p15f;  // of a row, as it is stored
constexpr float least_weight = 0x1p-14f;   // below it halves lose bits, and some devices all of them

RowShares make_row(const RowArgs& in, int i, float* share, float* memory, Isa isa) {
    return dispatch(isa, [&](auto of) { return RowMaker<decltype(of)::value>::run(in, i, share, memory); });
}

struct World {
    Buffer<glm::vec4> vertices, eyes;
    Buffer<glm::ivec4> triangles, of;
    Buffer<float> weights;
    RowArgs args{};
};

World world_of(const Elements& e, const RowParams& params) {
    World w;
    for (const Vertex& v : e.geometry.vertices) w.vertices.push_back(glm::vec4(v.position, 0));
    for (const glm::uvec3& t : e.geometry.triangles) w.triangles.push_back(glm::ivec4(glm::ivec3(t), 0));
    for (const glm::uvec3& t : e.of) w.of.push_back(glm::ivec4(glm::ivec3(t), 0));
    w.eyes = eyes_of(e.eye, e.normal);
    for (const double weight : texel_weights(params.size, params.weights)) w.weights.push_back(float(weight));
    w.weights.resize(w.weights.size() + row_lanes);
    const float texel = 2.0f / float(params.size);
    ItemsView& v = w.args.items;
    v.u = {params.size, rows_of_hemicube(params.size), int(w.vertices.size()), int(w.triangles.size()), texel, texel / 64, {}};
    v.eyes = &w.eyes[0].x, v.vertices = &w.vertices[0].x, v.triangles = &w.triangles[0].x;
    w.args.of = &w.of[0].x, w.args.weights = w.weights.data();
    return w;
}

}  // namespace

std::size_t RowBlock::bytes() const {
    return rows.size() * sizeof rows[0] + runs.size() * sizeof runs[0] + weights.size() * sizeof(Half) + 12 * scale.size();
}

std::size_t FormFactors::bytes() const {
    std::size_t all = 0;
    for (const RowBlock& b : blocks) all += b.bytes();
    return all;
}

void FormFactors::add_row(int i, std::vector<float>& dense) const {
    const RowBlock& b = blocks[std::size_t(i / rows_of_block)];
    const glm::ivec4 row = b.rows[std::size_t(i - b.first)];
    const float scale = b.scale[std::size_t(i - b.first)];
    const Half* weight = b.weights.data() + row.z;
    for (int r = 0; r < row.y; ++r) {
        const glm::ivec2 run = b.runs[std::size_t(row.x + r)];
        for (int k = 0; k < run.y; ++k) dense[std::size_t(run.x + k)] += scale * half_to_float(*weight++);
    }
}

void pack(const DenseRow& row, RowBlock& block) {
    const int n = int(row.share.size());
    float most = 0;
    for (const float s : row.share) most = std::max(most, s);
    const float up = most > 0 ? largest_weight / most : 0;
    const glm::ivec2 start(int(block.runs.size()), int(block.weights.size()));
    double sum = 0, kept = 0;
    for (const float s : row.share) sum += double(s);
    int end = -shortest_gap;  // of the last run
    for (int j = 0; j < n; ++j) {
        const float value = row.share[std::size_t(j)] * up;
        if (!(value >= least_weight)) continue;
        if (j - end >= shortest_gap || int(block.runs.size()) == start.x) {
            block.runs.push_back({j, 0});
        } else {
            block.weights.insert(block.weights.end(), std::size_t(j - end), Half{0});
            block.runs.back().y += j - end;
        }
        const Half h = float_to_half(value);
        block.weights.push_back(h);
        block.runs.back().y += 1;
        kept += double(half_to_float(h));
        end = j + 1;
    }
    block.rows.push_back({start.x, int(block.runs.size()) - start.x, start.y, int(block.weights.size()) - start.y});
    block.scale.push_back(kept > 0 ? float(sum / kept) : 0.0f);
    block.escaped.push_back(float(row.escaped)), block.back.push_back(float(row.back));
    ++block.count;
}

std::uint64_t bytes_expected(int elements, int size) {
    const std::uint64_t n = std::uint64_t(elements), seen = std::min<std::uint64_t>(n, std::uint64_t(rows_of_hemicube(size)) * std::uint64_t(size) * 3);
    return n * (2 * seen + 28);
}

FormFactors form_factors(const Elements& elements, const RowParams& params, const RunOptions& options, std::uint64_t limit) {
    const int n = elements.count();
    const std::uint64_t expected = bytes_expected(n, params.size);
    if (limit > 0 && expected > limit)
        throw InputError(fmt::format("radiosity: {} elements with hemicubes of {} texels: form factors may take {:.1f} MB; at most {:.1f} are allowed",
                                     n, params.size, double(expected) * 1e-6, double(limit) * 1e-6));
    FormFactors f;
    f.count = n;
    if (n == 0) return f;
    const World world = world_of(elements, params);
    const Isa isa = options.isa;
    f.blocks.resize(std::size_t((n + rows_of_block - 1) / rows_of_block));
    parallel_bands(int(f.blocks.size()), 1, options, [&](int first, int last) {
        Buffer<float> memory(DrawMemory::floats(world.args.items.u.vertices, params.size));
        DenseRow row;
        for (int b = first; b < last; ++b) {
            RowBlock& block = f.blocks[std::size_t(b)];
            block.first = b * rows_of_block;
            for (int i = block.first; i < std::min(n, block.first + rows_of_block); ++i) {
                row.share.assign(std::size_t(n), 0.0f);
                const RowShares shares = make_row(world.args, i, row.share.data(), memory.data(), isa);
                row.escaped = shares.escaped, row.back = shares.back;
                pack(row, block);
            }
            block.weights.resize(block.weights.size() + row_lanes, Half{0});
            block.weights.shrink_to_fit(), block.runs.shrink_to_fit();
        }
    });
    return f;
}

}  // namespace plumb::radiosity
