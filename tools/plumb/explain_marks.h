// What is drawn over the pictures of a stage, as SVG in the picture's texels.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/binding.h"
#include "tools/plumb/explain_samples.h"

namespace plumb::cli {

// Of the drawing: how many texels lie under one px of the page, so that marks have the same size everywhere.
struct Scale {
    double texels_a_px = 1;
};

// The pixel: a frame around its texel, and a cross hair that leads to it.
std::string pixel_mark(glm::ivec2 pixel, glm::ivec2 size, Scale scale);
// A point that is no whole texel: where x is projected to.
std::string point_mark(glm::dvec2 point, Scale scale);

// A circle a sample: its area goes by what it brought, and it is grey where that is nothing. Those of one path are
// joined. `key`: in front of a sample's place in `samples.all`, for data-key.
std::string sample_marks(const Samples& samples, const std::string& key, Scale scale);
inline constexpr double largest_mark_px = 14, least_mark_px = 2.5, no_mark_px = 2;

// Least and largest corner of the texels that are read, and of the point; empty without one.
struct Extent {
    glm::dvec2 low{0}, high{0};
};
std::optional<Extent> extent_of(const Samples& samples, std::optional<glm::dvec2> point);

// A triangle as it is drawn: its corners in clip space (y down, 0 <= z <= w), cut where they lie behind the eye; "" where
// nothing of it is left.
std::string triangle_mark(const glm::dvec4 corners[3], glm::ivec2 size);
// The same of the triangle of that index, of a raster stage's data; "" where there is no such triangle.
std::string triangle_mark(const StageData& data, int triangle);

}  // namespace plumb::cli
