#include "gi/radiosity/emitters.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/ray_query.h"
#include "gi/radiosity/contour.h"
#include "gi/radiosity/triangle_places.h"
#include "gi/reference/ray_query.h"
#include "raster/surfaces.h"

namespace plumb::radiosity {
namespace {

using Point = glm::dvec3;

constexpr int rays_to_emitters = 64;
constexpr double end_of_ray = 0.25;  // of the elements' offset: so far in front of an emitter rays end, and it does not hide itself

Point exitance_of(const Elements& e, std::size_t t) {
    Point sum(0);
    for (int k = 0; k < 3; ++k) sum += Point(e.lamp_exitance[e.of[t][k]]) / 3.0;
    return sum;
}

struct Emitter {
    Polygon corners;
    Point normal{0};  // times twice the area
    Point exitance{0};
    std::vector<Point> places;  // that rays go to
};

Point place_on(const Polygon& p, int k) {
    const Point w = triangle_place(k);
    return w.x * p[0] + w.y * p[1] + w.z * p[2];
}

std::vector<Emitter> emitters_of(const Elements& e) {
    std::vector<Emitter> all;
    if (e.lamp_exitance.empty()) return all;
    std::vector<double> power;
    double total = 0;
    for (std::size_t t = 0; t < e.of.size(); ++t) {
        const Point m = exitance_of(e, t);
        Emitter one{{}, {}, m, {}};
        for (int k = 0; k < 3; ++k) one.corners.push_back(Point(e.geometry.vertices[e.geometry.triangles[t][k]].position));
        one.normal = glm::cross(one.corners[1] - one.corners[0], one.corners[2] - one.corners[0]);
        power.push_back((m.x + m.y + m.z) * std::sqrt(glm::dot(one.normal, one.normal)));
        if (!(power.back() > 0)) {
            power.pop_back();
            continue;
        }
        total += power.back();
        all.push_back(std::move(one));
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
        const int rays = std::max(1, int(std::floor(rays_to_emitters * power[i] / total + 0.5)));
        for (int k = 0; k < rays; ++k) all[i].places.push_back(place_on(all[i].corners, k));
    }
    return all;
}

// Rays from one element, eight at a time; what is found is added to the emitters that they were sent to.
class Sight {
  public:
    Sight(const RayQuery& query, double gap_m) : query_(query), gap_m_(gap_m) {}

    void send(const Point& from, const Point& to, double weight, std::size_t emitter) {
        const glm::vec3 origin(from), way(to - from);
        const int k = count_++;
        rays_.origin_x[k] = origin.x, rays_.origin_y[k] = origin.y, rays_.origin_z[k] = origin.z;
        rays_.direction_x[k] = way.x, rays_.direction_y[k] = way.y, rays_.direction_z[k] = way.z;
        rays_.t_near[k] = 0, rays_.t_far[k] = float(std::max(0.0, 1 - gap_m_ / glm::length(to - from)));
        weight_[k] = weight, emitter_[k] = emitter;
    }
    bool full() const { return count_ == width; }
    // add(emitter, weight) for each ray that meets nothing.
    template <class Add>
    void flush(const Add& add) {
        alignas(32) std::int32_t active[width];
        for (int k = 0; k < width; ++k) active[k] = k < count_ ? -1 : 0;
        query_.occluded(active, rays_);
        for (int k = 0; k < count_; ++k)
            if (!(rays_.t_far[k] < 0)) add(emitter_[k], weight_[k]);
        count_ = 0;
    }

  private:
    static constexpr int width = 8;
    const RayQuery& query_;
    const double gap_m_;
    RayPacket<width> rays_{};
    double weight_[width] = {};
    std::size_t emitter_[width] = {};
    int count_ = 0;
};

struct Share {
    double form = 0, all = 0, seen = 0;  // F; weights of its rays, and of those that meet nothing
};

// What a place brings: the cosines at both ends over the distance's square.
double weight_of(const Point& eye, const Point& normal, const Emitter& e, const Point& place) {
    const Point way = place - eye;
    const double squared = glm::dot(way, way), here = glm::dot(way, normal), there = -glm::dot(way, e.normal);
    return here > 0 && there > 0 && squared > 0 ? here * there / (squared * squared) : 0;
}

glm::vec4 at_element(const std::vector<Emitter>& emitters, const Point& eye, const Point& normal, std::vector<Share>& shares, Sight& sight) {
    const auto found = [&](std::size_t emitter, double weight) { shares[emitter].seen += weight; };
    for (std::size_t i = 0; i < emitters.size(); ++i) {
        const Emitter& e = emitters[i];
        shares[i] = {};
        if (!(glm::dot(eye - e.corners[0], e.normal) > 0)) continue;
        if (std::none_of(e.corners.begin(), e.corners.end(), [&](const Point& p) { return glm::dot(p - eye, normal) > 0; })) continue;
        shares[i].form = point_form_factor(eye, normal, e.corners, Sides::front);
        if (!(shares[i].form > 0)) continue;
        for (const Point& place : e.places) {
            const double weight = weight_of(eye, normal, e, place);
            if (!(weight > 0)) continue;
            shares[i].all += weight;
            sight.send(eye, place, weight, i);
            if (sight.full()) sight.flush(found);
        }
    }
    sight.flush(found);
    Point sum(0);
    for (std::size_t i = 0; i < emitters.size(); ++i)
        if (shares[i].all > 0) sum += emitters[i].exitance * (shares[i].form * (shares[i].seen / shares[i].all));
    return glm::vec4(glm::vec3(sum), 0);
}

}  // namespace

Buffer<glm::vec4> emitters_at(const Scene& scene, const Elements& elements, const RunOptions& options) {
    Buffer<glm::vec4> out(std::size_t(elements.count()), glm::vec4(0));
    const std::vector<Emitter> emitters = emitters_of(elements);
    if (emitters.empty()) return out;
    const raster::Surfaces surfaces = raster::prepare(scene, elements.geometry);
    const auto query = reference::build_ray_query(elements.geometry, surfaces, Rays::exact);
    parallel_bands(elements.count(), 64, options, [&](int first, int last) {
        std::vector<Share> shares(emitters.size());
        Sight sight(*query, end_of_ray * elements.offset_m);
        for (std::size_t i = std::size_t(first); i < std::size_t(last); ++i) {
            const Point normal(elements.normal[i]);
            if (glm::dot(normal, normal) > 0) out[i] = at_element(emitters, Point(elements.eye[i]), normal, shares, sight);
        }
    });
    return out;
}

}  // namespace plumb::radiosity
