#include "gi/probes/pack.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <set>

namespace plumb::probes {
namespace {

struct FreeRectangle {
    glm::ivec2 origin, size;
};

// Free rectangles by one of their sides: finds the one whose side `key` is the least that is enough, and whose other
// side is the least that is enough among those, in logarithmic time.
class FreeList {
  public:
    FreeList(int key, int longest)
        : key_(key), leaves_(std::bit_ceil(unsigned(longest) + 1)), lists_(leaves_), most_(2 * leaves_, 0) {}

    void add(const FreeRectangle& r) {
        const unsigned at = unsigned(r.size[key_]);
        lists_[at].insert(entry(r));
        update(at);
    }
    void remove(const FreeRectangle& r) {
        const unsigned at = unsigned(r.size[key_]);
        lists_[at].erase(entry(r));
        update(at);
    }
    bool find(const glm::ivec2& size, FreeRectangle& found) const {
        const int other = 1 - key_;
        const unsigned at = first_from(unsigned(size[key_]), size[other]);
        if (at == leaves_) return false;
        const Entry e = *lists_[at].lower_bound({size[other], 0, 0});
        found.size[key_] = int(at), found.size[other] = e[0];
        found.origin = {e[2], e[1]};
        return true;
    }

  private:
    using Entry = std::array<int, 3>;  // the other side, y, x
    Entry entry(const FreeRectangle& r) const { return {r.size[1 - key_], r.origin.y, r.origin.x}; }

    void update(unsigned at) {
        unsigned node = at + leaves_;
        most_[node] = lists_[at].empty() ? 0 : (*lists_[at].rbegin())[0];
        while (node >>= 1) most_[node] = std::max(most_[2 * node], most_[2 * node + 1]);
    }
    // The first list from `at` on that has an entry of `least` or more; leaves_ where there is none.
    unsigned first_from(unsigned at, int least) const {
        if (at >= leaves_) return leaves_;
        unsigned node = at + leaves_;
        while (most_[node] < least) {
            // Up while it is a right child, then to the right.
            while (node & 1) node >>= 1;
            if (node == 0) return leaves_;
            ++node;
        }
        while (node < leaves_) node = most_[2 * node] >= least ? 2 * node : 2 * node + 1;
        return node - leaves_;
    }

    int key_;
    unsigned leaves_;
    std::vector<std::set<Entry>> lists_;
    std::vector<int> most_;  // a tree over the lists: the largest other side below a node
};

class Canvas {
  public:
    explicit Canvas(int max_side) : by_height_(1, max_side), by_width_(0, max_side) {}
    glm::ivec2 size{0};

    void free(const FreeRectangle& r) {
        if (r.size.x <= 0 || r.size.y <= 0) return;
        by_height_.add(r), by_width_.add(r);
    }

    // Rule 2. False where no free rectangle has room.
    bool fill(const glm::ivec2& piece, PackedRectangle& placed) {
        FreeRectangle best{};
        int best_rest = -1;
        for (const bool turned : {false, true}) {
            const glm::ivec2 shape = turned ? glm::ivec2(piece.y, piece.x) : piece;
            for (const FreeList* list : {&by_height_, &by_width_}) {
                FreeRectangle found;
                if (!list->find(shape, found)) continue;
                const int rest = std::min(found.size.x - shape.x, found.size.y - shape.y);
                if (best_rest >= 0 && rest >= best_rest) continue;
                best = found, best_rest = rest, placed = {found.origin, turned};
            }
        }
        if (best_rest < 0) return false;
        by_height_.remove(best), by_width_.remove(best);
        split(best, placed.turned ? glm::ivec2(piece.y, piece.x) : piece);
        return true;
    }

    // Rule 1, with the rectangle turned so that the canvas stays nearest to a square.
    void extend(const glm::ivec2& piece, PackedRectangle& placed) {
        auto longest = [&](const glm::ivec2& by) { return std::max(size.x + by.x, size.y + by.y); };
        const glm::ivec2 across(piece.y, piece.x);
        placed = {size, longest(across) < longest(piece)};
        const glm::ivec2 by = placed.turned ? across : piece;
        free({{size.x, 0}, {by.x, size.y}}), free({{0, size.y}, {size.x, by.y}});
        size += by;
    }

  private:
    // Cuts what is left so that the larger part is as large as it can be.
    void split(const FreeRectangle& r, const glm::ivec2& piece) {
        const glm::ivec2 rest = r.size - piece;
        const bool beside_is_tall = std::int64_t(rest.x) * r.size.y > std::int64_t(rest.y) * r.size.x;
        free({{r.origin.x + piece.x, r.origin.y}, {rest.x, beside_is_tall ? r.size.y : piece.y}});
        free({{r.origin.x, r.origin.y + piece.y}, {beside_is_tall ? piece.x : r.size.x, rest.y}});
    }

    FreeList by_height_, by_width_;
};

void free_holes(Canvas& canvas, const RectangleToPack& r, const PackedRectangle& placed, int gap) {
    for (const TexelHole& hole : r.holes) {
        FreeRectangle free{hole.origin, hole.size};
        if (placed.turned) free = {{r.size.y - hole.origin.y - hole.size.y, hole.origin.x}, {hole.size.y, hole.size.x}};
        // Whoever comes brings the gap to its right and below; here it may lie outside of the hole.
        canvas.free({placed.origin + free.origin, free.size + gap});
    }
}

}  // namespace

Packing pack_rectangles(const std::vector<RectangleToPack>& rectangles, int gap, int side, int max_side) {
    std::vector<std::uint32_t> order(rectangles.size());
    std::iota(order.begin(), order.end(), 0u);
    auto key = [&](std::uint32_t i) {
        const glm::ivec2 s = rectangles[i].size;
        return std::array{-std::max(s.x, s.y), -std::min(s.x, s.y), int(i)};
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    // Every rectangle brings the gap to its right and below; the canvas has one too much there.
    const int limit = (side > 0 ? side : max_side) + gap;
    Canvas canvas(limit);
    if (side > 0) {
        canvas.free({{0, 0}, {limit, limit}});
        canvas.size = glm::ivec2(limit);
    }
    Packing packing;
    packing.placed.resize(rectangles.size());
    for (std::uint32_t i : order) {
        const glm::ivec2 piece = rectangles[i].size + gap;
        if (std::max(piece.x, piece.y) > limit) return {};
        if (!canvas.fill(piece, packing.placed[i])) {
            if (side > 0) return {};
            canvas.extend(piece, packing.placed[i]);
            if (std::max(canvas.size.x, canvas.size.y) > limit) return {};
        }
        free_holes(canvas, rectangles[i], packing.placed[i], gap);
    }
    packing.side = std::max(1, std::max(canvas.size.x, canvas.size.y) - gap);
    return packing;
}

Packing pack_closer(const std::vector<RectangleToPack>& rectangles, int gap, const Packing& packing) {
    Packing best = packing;
    for (int too_small = packing.side * 3 / 4; too_small + 1 < best.side;) {
        const int side = (too_small + best.side) / 2;
        Packing closer = pack_rectangles(rectangles, gap, side, side);
        if (closer.placed.empty())
            too_small = side;
        else
            best = std::move(closer);
    }
    return best;
}

}  // namespace plumb::probes
