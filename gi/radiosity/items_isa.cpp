#include "core/shade_rows.h"
// After core/wide.h, so that the kernel sees its number.
#include "gi/radiosity/items_draw.h"
#include "gi/radiosity/row_kernel.h"

namespace plumb {

using namespace radiosity;

template <>
void Rows<ItemsKernel, Isa::PLUMB_ISA>::run(const ItemsView& in, int first, int last, const Tiles&, float* scratch) {
    const int rows = rows_of_hemicube(in.u.width);
    Drawing drawing(in, scratch);
    for (int row = first; row < last;) {
        const int cube = row / rows, end = min(last, (cube + 1) * rows);
        drawing.draw(in.eyes + 16 * std::ptrdiff_t(cube), row - cube * rows, end - cube * rows);
        for (; row < end; ++row)
            for (int x = 0; x < in.u.width; x += N::width)
                ItemsKernel::store<F>(in, I(row * in.u.width) + N::iota(x), drawing.resolve(row - cube * rows, x), N::iota(x) < I(in.u.width));
    }
}

}  // namespace plumb

namespace plumb::radiosity {

// Texels in their order: so each sum has one, too.
template <>
RowShares RowMaker<Isa::PLUMB_ISA>::run(const RowArgs& in, int i, float* share, float* memory) {
    const int size = in.items.u.width, rows = rows_of_hemicube(size);
    Drawing drawing(in.items, memory);
    drawing.draw(in.items.eyes + 16 * std::ptrdiff_t(i), 0, rows);
    RowShares shares{0, 0};
    alignas(64) std::int32_t triangle[N::width];
    alignas(64) float b1[N::width], b2[N::width], side[N::width];
    for (int row = 0; row < rows; ++row)
        for (int x = 0; x < size; x += N::width) {
            const Item<F> item = drawing.resolve(row, x);
            std::memcpy(triangle, &item.triangle, sizeof triangle);
            N::save(b1, item.seen.x), N::save(b2, item.seen.y), N::save(side, item.seen.w);
            const float* weight = in.weights + std::ptrdiff_t(row) * size + x;
            for (int k = 0; k < N::width && x + k < size; ++k) {
                if (side[k] > 0) {
                    const std::int32_t* of = in.of + 4 * std::ptrdiff_t(triangle[k]);
                    share[of[0]] += weight[k] * (1.0f - b1[k] - b2[k]);
                    share[of[1]] += weight[k] * b1[k];
                    share[of[2]] += weight[k] * b2[k];
                } else {
                    (side[k] < 0 ? shares.back : shares.escaped) += double(weight[k]);
                }
            }
        }
    return shares;
}

}  // namespace plumb::radiosity
