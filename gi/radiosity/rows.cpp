#include "gi/radiosity/rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "core/formats.h"
#include "core/parallel.h"
#include "gi/radiosity/gather_kernel.h"
#include "gi/radiosity/row_kernel.h"

namespace plumb::radiosity {

namespace {

// Zeros between two runs that are kept as one: a run costs 8 bytes, a zero 2.
constexpr int shortest_gap = 4;

std::size_t padded(int n) { return std::size_t((n + row_packet - 1) / row_packet * row_packet); }

// Every third bit of a 10-bit number, from the first.
std::uint32_t spread(std::uint32_t x) {
    x = (x | x << 16) & 0x030000ff, x = (x | x << 8) & 0x0300f00f, x = (x | x << 4) & 0x030c30c3;
    return (x | x << 2) & 0x09249249;
}

// Triangles along Morton's curve: a packet of neighbours reaches one or two faces, and reads a few lines of memory. Of 30,000 in no
// order a hemicube takes twice as long.
std::vector<std::int32_t> drawing_order(const Geometry& g) {
    const auto middle = [&](const glm::uvec3& t) {
        return (glm::dvec3(g.vertices[t.x].position) + glm::dvec3(g.vertices[t.y].position)) + glm::dvec3(g.vertices[t.z].position);
    };
    glm::dvec3 low(1e300), high(-1e300);
    for (const glm::uvec3& t : g.triangles) low = glm::min(low, middle(t)), high = glm::max(high, middle(t));
    std::vector<std::pair<std::uint32_t, std::int32_t>> keys;
    for (std::size_t i = 0; i < g.triangles.size(); ++i) {
        std::uint32_t key = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double extent = high[axis] - low[axis];
            if (extent > 0) key |= spread(std::uint32_t(1023 * ((middle(g.triangles[i])[axis] - low[axis]) / extent))) << axis;
        }
        keys.emplace_back(key, std::int32_t(i));
    }
    std::sort(keys.begin(), keys.end());
    std::vector<std::int32_t> order;
    for (const auto& [key, number] : keys) order.push_back(number);
    return order;
}

struct World {
    Buffer<glm::vec4> vertices, eyes;
    Buffer<std::int32_t> corner[3], number;
    Buffer<float> plane[6];
    Buffer<glm::ivec4> of;
    Buffer<float> weights;
    double all = 0, all_floats = 0;  // sum of texels' weights, in double and as floats
    RowArgs args{};

    // Of a row through whose texels that share of all is lost: floats round weights, and sums of them.
    double row_sum(const RowShares& lost) const { return all * std::max(0.0, 1 - (lost.escaped + lost.back) / all_floats); }
};

World world_of(const Elements& e, const RowParams& params) {
    if (params.size < 2 || params.size > largest_hemicube || params.size % 2 != 0)
        throw InputError(fmt::format("radiosity: size = {}: expected an even number of 2 to {} texels", params.size, largest_hemicube));
    World w;
    for (const Vertex& v : e.geometry.vertices) w.vertices.push_back(glm::vec4(v.position, 0));
    for (const glm::uvec3& t : e.of) w.of.push_back(glm::ivec4(glm::ivec3(t), 0));
    w.eyes = eyes_of(e.eye, e.normal);
    for (const double weight : texel_weights(params.size, params.weights)) {
        w.weights.push_back(float(weight));
        w.all += weight, w.all_floats += double(w.weights.back());
    }
    w.weights.resize(w.weights.size() + row_lanes);
    const std::size_t triangles = e.geometry.triangles.size();
    for (const std::int32_t number : drawing_order(e.geometry)) {
        const glm::uvec3& t = e.geometry.triangles[std::size_t(number)];
        const auto at = [&](int k) { return e.geometry.vertices[t[k]].position; };
        const glm::vec3 normal = normal_of<float>(at(0), at(1), at(2));
        for (int k = 0; k < 3; ++k) {
            w.corner[k].push_back(std::int32_t(t[k]));
            w.plane[k].push_back(normal[k]), w.plane[k + 3].push_back(at(0)[k]);
        }
        w.number.push_back(number);
    }
    for (auto* list : {&w.corner[0], &w.corner[1], &w.corner[2], &w.number}) list->resize(DrawList::padded(triangles), 0);
    for (Buffer<float>& list : w.plane) list.resize(DrawList::padded(triangles), 0.0f);
    const float texel = 2.0f / float(params.size);
    w.args.u = {params.size, rows_of_hemicube(params.size), int(w.vertices.size()), int(triangles), texel, texel / 64, {}};
    w.args.eyes = &w.eyes[0].x, w.args.vertices = &w.vertices[0].x;
    w.args.list = {{w.corner[0].data(), w.corner[1].data(), w.corner[2].data()}, w.number.data(), {}, int(w.number.size())};
    for (int k = 0; k < 6; ++k) w.args.list.plane[k] = w.plane[k].data();
    w.args.of = &w.of[0].x, w.args.weights = w.weights.data();
    return w;
}

// What a thread makes a row in.
struct RowMemory {
    Buffer<float> share, drawing;
    std::vector<std::uint16_t> half, kept;

    explicit RowMemory(int n, std::size_t floats = 0)
        : share(padded(n)), drawing(floats), half(padded(n)), kept(padded(n) / row_packet) {}
};

// Numbers [first, end) of `of` that are all kept, the first such at or after `from`; none: [n, n).
std::pair<int, int> kept_from(const std::vector<std::uint16_t>& of, int from, int n) {
    const auto next = [&](int at, unsigned flip) {
        while (at < n) {
            const unsigned bits = ((of[std::size_t(at / row_packet)] ^ flip) & 0xffffu) >> (at % row_packet);
            if (bits != 0) return std::min(n, at + std::countr_zero(bits));
            at = (at / row_packet + 1) * row_packet;
        }
        return n;
    };
    const int first = next(from, 0);
    return {first, next(first, 0xffff)};
}

// Appends the row whose shares m.share holds; their sum, where it is known better than floats tell, or below 0.
void append(RowMemory& m, int n, const RowShares& lost, double sum, Isa isa, RowBlock& block) {
    const RowSums sums =
        dispatch(isa, [&](auto of) { return RowMaker<decltype(of)::value>::halve(m.share.data(), n, {m.half.data(), m.kept.data()}); });
    const glm::ivec2 start(int(block.runs.size()), int(block.weights.size()));
    const auto* half = reinterpret_cast<const Half*>(m.half.data());
    for (auto [first, end] = kept_from(m.kept, 0, n); first < n;) {
        auto next = kept_from(m.kept, end, n);
        for (; next.first < n && next.first - end < shortest_gap; next = kept_from(m.kept, end, n)) end = next.second;
        block.runs.push_back({first, end - first});
        block.weights.insert(block.weights.end(), half + first, half + end);
        std::tie(first, end) = next;
    }
    block.rows.push_back({start.x, int(block.runs.size()) - start.x, start.y, int(block.weights.size()) - start.y});
    if (sum < 0) sum = sums.shares;
    block.scale.push_back(sums.halves > 0 ? float(sum / sums.halves) : 0.0f);
    block.sum.push_back(sums.halves > 0 ? sum : 0);
    block.escaped.push_back(float(lost.escaped)), block.back.push_back(float(lost.back));
    ++block.count;
}

// Rows [first, end), in memory of their size.
RowBlock make_block(const World& world, int n, int first, int end, Isa isa, RowMemory& m, RowBlock& room) {
    room.first = first, room.count = 0;
    room.rows.clear(), room.runs.clear(), room.weights.clear(), room.scale.clear(), room.sum.clear(), room.escaped.clear(), room.back.clear();
    for (int i = first; i < end; ++i) {
        std::fill(m.share.begin(), m.share.end(), 0.0f);
        const RowShares shares =
            dispatch(isa, [&](auto of) { return RowMaker<decltype(of)::value>::run(world.args, i, m.share.data(), m.drawing.data()); });
        append(m, n, shares, world.row_sum(shares), isa, room);
    }
    room.weights.insert(room.weights.end(), row_lanes, Half{0});
    return room;
}

}  // namespace

std::size_t RowBlock::bytes() const {
    return rows.size() * sizeof rows[0] + runs.size() * sizeof runs[0] + weights.size() * sizeof(Half) + 20 * scale.size();
}

std::size_t FormFactors::bytes() const {
    std::size_t all = 0;
    for (const RowBlock& b : blocks) all += b.bytes();
    return all;
}

std::size_t FormFactors::all_bytes() const { return bytes() + (further ? further->bytes() : 0); }

int FormFactors::block_count() const { return blocks_of(count); }

void FormFactors::with_block(int block, const std::function<void(const RowBlock&)>& look) const {
    if (std::size_t(block) < blocks.size())
        look(blocks[std::size_t(block)]);
    else
        further->with_block(block, look);
}

void FormFactors::each_block(const std::function<void(const RowBlock&)>& look) const {
    for (int block = 0; block < block_count(); ++block) with_block(block, look);
}

void FormFactors::add_row(int i, std::vector<float>& dense) const {
    with_block(i / rows_of_block, [&](const RowBlock& b) {
        const glm::ivec4 row = b.rows[std::size_t(i - b.first)];
        const float scale = b.scale[std::size_t(i - b.first)];
        const Half* weight = b.weights.data() + row.z;
        for (int r = 0; r < row.y; ++r) {
            const glm::ivec2 run = b.runs[std::size_t(row.x + r)];
            for (int k = 0; k < run.y; ++k) dense[std::size_t(run.x + k)] += scale * half_to_float(*weight++);
        }
    });
}

void FormFactors::add_facts(const RowBlock& block) {
    escaped.insert(escaped.end(), block.escaped.begin(), block.escaped.end());
    sums.insert(sums.end(), block.sum.begin(), block.sum.end());
    for (const glm::ivec4& row : block.rows) longest = std::max(longest, row.w);
}

void pack(const DenseRow& row, RowBlock& block) {
    RowMemory m(int(row.share.size()));
    std::copy(row.share.begin(), row.share.end(), m.share.begin());
    append(m, int(row.share.size()), {row.escaped, row.back}, row.sum, best_isa(), block);
}

namespace {

constexpr std::uint64_t bytes_of_row = 36;  // beside runs and weights

std::uint64_t most_seen(int elements, int size) {
    return std::min<std::uint64_t>(std::uint64_t(elements), std::uint64_t(rows_of_hemicube(size)) * std::uint64_t(size) * 3);
}

}  // namespace

std::uint64_t bytes_expected(int elements, int size) { return std::uint64_t(elements) * (2 * most_seen(elements, size) + bytes_of_row); }

std::uint64_t bytes_at_most(int elements, int size) {
    const std::uint64_t n = std::uint64_t(elements), seen = most_seen(elements, size);
    const std::uint64_t weights = std::min(n, seen * shortest_gap), runs = std::min(seen, n / (1 + shortest_gap) + 1);
    return n * (2 * weights + 8 * runs + bytes_of_row) + std::uint64_t(blocks_of(elements)) * 2 * row_lanes;
}

FormFactors form_factors(const Elements& elements, const RowParams& params, const RunOptions& options, std::uint64_t limit) {
    const int n = elements.count();
    const std::uint64_t expected = bytes_expected(n, params.size);
    if (limit > 0 && expected > limit)
        throw InputError(fmt::format("radiosity: {} elements with hemicubes of {} texels: form factors may take {:.1f} MB; at most {:.1f} are allowed",
                                     n, params.size, double(expected) * 1e-6, double(limit) * 1e-6));
    FormFactors f;
    f.count = n;
    f.blocks = row_blocks(elements, params, options, 0, blocks_of(n));
    for (const RowBlock& block : f.blocks) f.add_facts(block);
    return f;
}

std::vector<RowBlock> row_blocks(const Elements& elements, const RowParams& params, const RunOptions& options, int first, int last) {
    std::vector<RowBlock> blocks(std::size_t(last - first));
    if (blocks.empty()) return blocks;
    const int n = elements.count();
    const World world = world_of(elements, params);
    parallel_bands(last - first, 1, options, [&](int from, int to) {
        RowMemory memory(n, DrawMemory::floats(world.args.u.vertices, params.size));
        RowBlock room;
        for (int b = from; b < to; ++b) {
            const int row = (first + b) * rows_of_block;
            blocks[std::size_t(b)] = make_block(world, n, row, std::min(n, row + rows_of_block), options.isa, memory, room);
        }
    });
    return blocks;
}

}  // namespace plumb::radiosity
