#include "gi/zbuffer/normal_lines.h"

#include <algorithm>
#include <cmath>

namespace plumb::zbuffer {

namespace {

const glm::vec4 red(1, 0, 0, 1);
constexpr double hidden_behind = 1e-3;  // of the depth: what is no farther behind a surface lies on it

class Lines {
  public:
    Lines(const View& view, const Image4& position, Image4& picture)
        : to_clip_(view.world_to_clip()), eye_(view.eye), forward_(view.forward), position_(position), picture_(picture) {}

    void draw(const glm::dvec3& a, const glm::dvec3& b) const {
        const int steps = steps_of(a, b);
        for (int k = 0; k <= steps; ++k) dot(a + (b - a) * (double(k) / steps));
    }

  private:
    bool pixel_of(const glm::dvec3& p, glm::dvec2& at) const {
        const glm::dvec4 clip = to_clip_ * glm::dvec4(p, 1);
        if (!(clip.w > 0)) return false;
        at = {(clip.x / clip.w + 1) / 2 * picture_.width, (clip.y / clip.w + 1) / 2 * picture_.height};
        return true;
    }
    // Two a pixel; of what begins behind the eye as many as the picture is wide.
    int steps_of(const glm::dvec3& a, const glm::dvec3& b) const {
        glm::dvec2 from, to;
        const int most = 2 * std::max(picture_.width, picture_.height);
        if (!pixel_of(a, from) || !pixel_of(b, to)) return most;
        return int(std::clamp(2 * std::max(std::fabs(to.x - from.x), std::fabs(to.y - from.y)), 1.0, double(most)));
    }
    void dot(const glm::dvec3& p) const {
        glm::dvec2 at;
        if (!pixel_of(p, at) || !(at.x >= 0 && at.y >= 0 && at.x < picture_.width && at.y < picture_.height)) return;
        const int x = int(at.x), y = int(at.y);
        const glm::dvec3 d = p - eye_;
        const double depth = d.x * forward_.x + d.y * forward_.y + d.z * forward_.z, seen = double(position_(x, y).w);
        if (seen > 0 && depth > seen * (1 + hidden_behind)) return;
        picture_(x, y) = red;
    }

    glm::dmat4 to_clip_;
    glm::dvec3 eye_, forward_;
    const Image4& position_;
    Image4& picture_;
};

}  // namespace

void draw_normals(const VertexTable& table, const View& view, const Image4& position, double length_m, Image4& picture) {
    const Lines lines(view, position, picture);
    for (std::size_t i = 0; i + 1 < table.vertices.size(); i += 2) {
        const glm::dvec3 a(table.vertices[i]);
        lines.draw(a, a + length_m * glm::dvec3(table.vertices[i + 1]));
    }
}

}  // namespace plumb::zbuffer
