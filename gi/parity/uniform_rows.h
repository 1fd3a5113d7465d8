// Rows of a uniform block that take points to texels, under whatever name they are members. Private to gi/parity/.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "gi/parity/hypothesis.h"

namespace plumb::parity {

using Row = std::array<double, 4>;

inline Row operator+(const Row& a, const Row& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]}; }
inline Row operator*(double s, const Row& a) { return {s * a[0], s * a[1], s * a[2], s * a[3]}; }
inline double dot3(const Row& a, const Row& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// x = (to_x . (p, 1)) / (to_w . (p, 1)), and y.
struct Rows {
    std::string name;      // "map", "view"
    std::string stem;      // "map.": of the other members of the struct
    std::string x, y, w;   // members
    std::string size;      // the member that says how many texels a side has; "": width and height do
    double width, height;  // texels
};

// Projection (raster/project.glsl) and SeenFrom (gi/screen/seen_from.glsl).
std::vector<Rows> find_rows(const StageBinding& binding, const StageData& data);
// The whole matrix to clip space by rows for columns. Its rows of depth are not in the block: usual planes are tried.
std::vector<Hypothesis> row_major_hypotheses(const StageBinding& binding, const StageData& data);
Row row_of(const StageBinding& binding, const StageData& data, const std::string& member);

}  // namespace plumb::parity
