// Vertices' normals as red lines over a picture (HEM plate C.8).
#pragma once

#include "core/image.h"
#include "core/view.h"
#include "gi/zbuffer/vertex_table.h"

namespace plumb::zbuffer {

// Draws a line of that length from each vertex along its normal, where nothing is in front of it. position: of the G-buffer, w
// linear depth, m, 0 where nothing is. Lines are one pixel wide.
void draw_normals(const VertexTable& table, const View& view, const Image4& position, double length_m, Image4& picture);

}  // namespace plumb::zbuffer
