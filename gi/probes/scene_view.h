// Pictures of the scene whose surfaces have the colours of a lightmap, with balls and lines in it.
#pragma once

#include "core/view.h"
#include "gi/probes/atlas.h"
#include "raster/gbuffer.h"

namespace plumb::probes {

inline const glm::vec4 nothing(0.06f, 0.06f, 0.08f, 1), grey(0.7f, 0.7f, 0.7f, 1);  // no surface; one without a colour

class SceneView {
  public:
    // The atlas must outlive it.
    SceneView(const Atlas& atlas, const raster::Surfaces& surfaces, const View& view, glm::ivec2 size, const RunOptions& options);

    // Surfaces in the colours of a lightmap, shaded by how much they face the camera; grey where it is none, or has no chart.
    Image4 with(const Image4* lightmap) const;
    // A ball, where nothing is in front of it.
    void ball(Image4& picture, const glm::dvec3& centre, double radius, const glm::vec4& colour) const;
    // The outline of a sphere, through everything.
    void outline(Image4& picture, const glm::dvec3& centre, double radius, const glm::vec4& colour) const;
    // Where nothing is in front of it.
    void line(Image4& picture, const glm::dvec3& a, const glm::dvec3& b, const glm::vec4& colour) const;
    // Of points (w unused) the one that is seen nearest to the middle of the picture; the first where none is seen.
    int in_sight(const Buffer<glm::vec4>& points) const;

  private:
    // Of a point that is drawn at a place of the picture: whether nothing hides it.
    bool in_front(const glm::dvec3& p, const glm::dvec2& at) const;
    glm::dvec3 ray(int x, int y) const;
    bool pixel_of(const glm::dvec3& p, glm::dvec2& at) const;
    bool pixels_of(const glm::dvec3& centre, double radius, glm::ivec2& low, glm::ivec2& high) const;
    void put(Image4& picture, const glm::dvec2& at, const glm::vec4& colour) const;
    glm::vec4 texel_at(const Image4& lightmap, int triangle, const glm::dvec3& p) const;

    const Atlas& atlas_;
    View view_;
    glm::ivec2 size_;
    glm::dmat4 to_world_;  // from clip space
    raster::GBuffer seen_;
};

}  // namespace plumb::probes
