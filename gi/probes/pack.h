// Packs rectangles of whole texels into a square by the two rules of IPR 3.2.1.1.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "gi/probes/chart_layout.h"

namespace plumb::probes {

struct RectangleToPack {
    glm::ivec2 size{1};
    std::vector<TexelHole> holes;  // free for others
};

struct PackedRectangle {
    glm::ivec2 origin{0};
    bool turned = false;  // by a quarter: its width runs down
};

struct Packing {
    std::vector<PackedRectangle> placed;  // empty: they do not fit
    int side = 0;                         // of the square that holds them, texels
};

// The biggest first: by the longer side, then by the shorter one, then in their order. A rectangle goes to the top left
// corner of the free rectangle that it fills best; the rest of that is cut in two (rule 2, figure 3.8; differs: figures
// have y up, so theirs is the bottom left), and its holes become free. Where none has room, the canvas grows at its
// bottom right corner by the rectangle, and what lies beside and below the old canvas is free (rule 1, figure 3.7).
// `gap` texels stay free between any two. `side` 0: the canvas begins empty; above 0: it is free and of that side, and
// does not grow. Where the canvas would become larger than max_side, or they do not fit, nothing is placed.
Packing pack_rectangles(const std::vector<RectangleToPack>& rectangles, int gap, int side, int max_side);

// The same in the smallest square between three quarters of the packing's side and that side, found by halving; the
// packing itself where none is smaller. differs: rule 1 leaves much empty where charts are few.
Packing pack_closer(const std::vector<RectangleToPack>& rectangles, int gap, const Packing& packing);

}  // namespace plumb::probes
