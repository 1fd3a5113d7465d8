// Shapes that several of the city's buildings are made of.
#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "io/scenes/city_parts.h"

namespace plumb::io::scenes::town {

double Grade::power(double ratio) const { return host::pow(ratio, fine / 4); }

void slab(Builder& b, int material, const Place& place, const Point& l, const Point& h) {
    const Point sides[5][4] = {{{l.x, l.y, h.z}, {h.x, l.y, h.z}, {h.x, h.y, h.z}, {l.x, h.y, h.z}},
                               {{l.x, h.y, h.z}, {h.x, h.y, h.z}, {h.x, h.y, l.z}, {l.x, h.y, l.z}},
                               {{l.x, l.y, l.z}, {h.x, l.y, l.z}, {h.x, l.y, h.z}, {l.x, l.y, h.z}},
                               {{h.x, l.y, h.z}, {h.x, l.y, l.z}, {h.x, h.y, l.z}, {h.x, h.y, h.z}},
                               {{l.x, l.y, l.z}, {l.x, l.y, h.z}, {l.x, h.y, h.z}, {l.x, h.y, l.z}}};
    for (const auto& side : sides) b.quad(material, place, side, 1, 1, 2);
}

Place wall_frame(const glm::dvec2& from, const glm::dvec2& to, double base) {
    const glm::dvec2 along = (to - from) / std::max(1e-9, std::sqrt(glm::dot(to - from, to - from)));
    Place m(1);
    m[0] = {along.x, 0, along.y, 0};
    m[2] = {-along.y, 0, along.x, 0};
    m[3] = {from.x, base, from.y, 1};
    return m;
}

void arch(Builder& b, int material, const Arch& a, const Bend& bend) {
    const double middle = (a.x0 + a.x1) / 2;
    // The edge of the opening and the edge of the stretch, from the left foot over the top to the right foot.
    std::vector<glm::dvec2> inner{{middle - a.half_width, a.y0}}, outer{{a.x0, a.y0}};
    for (int k = 0; k <= a.arc; ++k) {
        const double turn = host::pi * (1 - double(k) / a.arc), quarter = a.arc / 4.0;
        inner.push_back({middle + a.half_width * host::cos(turn), a.springing + a.half_width * host::sin(turn)});
        const double top = std::clamp((k - quarter) / (2 * quarter), 0.0, 1.0);
        const double rise = std::min({k / quarter, 1.0, (a.arc - k) / quarter});
        outer.push_back({a.x0 + top * (a.x1 - a.x0), a.springing + rise * (a.y1 - a.springing)});
    }
    inner.push_back({middle + a.half_width, a.y0});
    outer.push_back({a.x1, a.y0});

    Grid g;
    g.columns = a.arc + 2;
    const auto at = [&](const std::vector<glm::dvec2>& edge, double u) {
        return edge[std::size_t(u * g.columns + 0.5)];
    };
    g.texture = {2 * (a.y1 - a.y0) / a.texture_size, (middle - a.half_width - a.x0) / a.texture_size};
    b.grid(material, Place(1), g, [&](double u, double v) {
        const glm::dvec2 p = at(inner, u) + v * (at(outer, u) - at(inner, u));
        return bend(p.x, p.y, 0);
    });
    if (a.back)
        b.grid(material, Place(1), g, [&](double u, double v) {
            const glm::dvec2 p = at(inner, 1 - u) + v * (at(outer, 1 - u) - at(inner, 1 - u));
            return bend(p.x, p.y, -a.depth);
        });
    g.texture.y = a.depth / a.texture_size;
    b.grid(material, Place(1), g, [&](double u, double v) {
        const glm::dvec2 p = at(inner, u);
        return bend(p.x, p.y, -a.depth * (1 - v));
    });
}

void moulding(Builder& b, int material, double x0, double x1, int columns, const std::vector<glm::dvec2>& profile,
              const Bend& bend, double texture_length) {
    // Each face of the profile is flat: its edges stay sharp.
    for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
        const glm::dvec2 low = profile[k], high = profile[k + 1];
        Grid g;
        g.columns = columns;
        g.texture = {texture_length, std::sqrt(glm::dot(high - low, high - low)) / 2};
        b.grid(material, Place(1), g, [&](double u, double v) {
            const glm::dvec2 p = low + v * (high - low);
            return bend(x0 + u * (x1 - x0), p.y, p.x);
        });
    }
}

void column(Builder& b, int material, const Place& place, double height, double radius, int segments) {
    const double r = radius, h = height;
    std::vector<glm::dvec2> profile;
    if (segments < 7)
        profile = {{r, 0}, {0.85 * r, h}};
    else
        profile = {{1.3 * r, 0},        {1.3 * r, 0.3 * r},      {1.1 * r, 0.5 * r},      {r, 0.6 * r},
                   {r, 0.4 * h},        {0.85 * r, h - 1.6 * r}, {0.9 * r, h - 1.2 * r},  {1.25 * r, h - 0.3 * r},
                   {1.35 * r, h - 0.3 * r}, {1.35 * r, h}};
    b.lathe(material, place, profile, segments, 3);
}

}  // namespace plumb::io::scenes::town
