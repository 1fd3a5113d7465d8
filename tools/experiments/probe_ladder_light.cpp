// plumb experiment probe-ladder: the radiance that is known, and rays that fetch it.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "core/sequences.h"
#include "core/sh.h"
#include "gi/probes/receiver_rays_kernel.h"
#include "gi/probes/sky_probe.h"
#include "gi/probes/stand_in.h"
#include "gi/reference/light_kernel.h"
#include "gi/reference/lights.h"
#include "gi/reference/ray_query.h"
#include "tools/experiments/probe_ladder.h"
#include "tools/experiments/some_receivers.h"

namespace plumb::cli {

namespace {

double luminance(const glm::vec3& rgb) { return glm::dot(glm::dvec3(0.2126, 0.7152, 0.0722), glm::dvec3(rgb)); }

// Traces one ray after the other.
class Fetcher {
  public:
    Fetcher(const LadderWorld& world, const Radiance& radiance)
        : surfaces_(world.args()), tracer_(*world.query), radiance_(radiance) {}

    double operator()(const glm::vec3& origin, const glm::vec3& direction) {
        const RayHit<float> hit = probes::is_sky(glm::vec4(origin, 0)) ? RayHit<float>{} : tracer_.nearest(origin, direction, true);
        RayEnd& end = last = {};
        end.direction = direction;
        if (hit.found) {
            const probes::Met<float> met = probes::met_by<float>(surfaces_, hit, direction);
            end.found = true, end.front = met.front;
            ++found;
            end.triangle = hit.triangle, end.barycentrics = hit.barycentrics, end.position = met.point;
        }
        return radiance_(end);
    }

    std::int64_t found = 0;  // rays that met something
    RayEnd last;

  private:
    raster::SurfaceArgs surfaces_;
    RayTracer<float> tracer_;
    const Radiance& radiance_;
};

class DirectLight {
  public:
    explicit DirectLight(const LadderWorld& world)
        : world_(world),
          surfaces_(world.args()),
          sky_(reference::environment_table(world.scene.environment)),
          table_(reference::light_table(world.scene, world.geometry, world.surfaces, sky_)) {
        sky_args_ = reference::environment_args(sky_);
        lights_ = {};
        lights_.count = table_.count, lights_.rows = table_.rows.data(), lights_.cdf = table_.cdf.data();
        lights_.triangle_pdf = table_.triangle_pdf.data(), lights_.any_radius = table_.any_radius ? 1 : 0;
    }
    DirectLight(const DirectLight&) = delete;

    double operator()(const RayEnd& end) const {
        if (!end.found) return luminance(reference::environment_radiance<float>(sky_args_, end.direction));
        if (!end.front) return 0;
        NoTap quiet;
        const raster::Surface<float> s =
            raster::surface<float>(surfaces_, end.triangle, end.barycentrics, glm::vec4(-end.direction, 0), quiet);
        return luminance(s.emission + s.albedo * by_lamps(s, end.direction)) / host::pi;
    }

  private:
    glm::vec3 by_lamps(const raster::Surface<float>& s, const glm::vec3& direction) const {
        // The triangle's own normal, on the side that is seen.
        const float length = std::sqrt(dot3(s.face, s.face));
        const glm::vec3 face = s.face * (-raster::side_of(dot3(s.face, direction)) / std::max(length, 1e-30f));
        const glm::vec3 start = s.position + face * reference::ray_offset(s.extent);
        RayTracer<float> tracer(*world_.query);
        glm::vec3 irradiance(0);
        for (int i = 0; i < lights_.count; ++i) {
            const auto kind = reference::LightKind(int(lights_.rows[16 * i + 11]));
            if (kind != reference::LightKind::lamp && kind != reference::LightKind::directional) continue;
            const reference::LightSample<float> l =
                reference::sample_light<float>(lights_, surfaces_, sky_args_, {i, 1.0f, 0.0f}, 0.0f, s.position);
            const float cosine = dot3(s.normal, l.direction);
            if (!(cosine > 0) || !(dot3(face, l.direction) > 0) || l.radiance == glm::vec3(0)) continue;
            const glm::vec3 towards = l.infinite ? l.direction : l.target - start;
            if (tracer.visible(start, towards, 0, l.infinite ? __builtin_inff() : 1.0f, true))
                irradiance += l.radiance * cosine;
        }
        return irradiance;
    }

    const LadderWorld& world_;
    const raster::SurfaceArgs surfaces_;
    const reference::EnvironmentTable sky_;
    const reference::LightTable table_;
    reference::EnvironmentArgs sky_args_;
    reference::LightArgs lights_;
};

// Aligned runs of Sobol's sequence that no bake's rays come from: two halves, each as uniform as its number allows.
constexpr std::uint32_t first_of_truth = 1u << 20;

glm::vec3 direction_of_truth(int k) {
    return glm::vec3(sample_cosine_hemisphere(sobol(first_of_truth + std::uint32_t(k)) + glm::dvec2(0x1p-25)));
}

}  // namespace

LadderWorld::LadderWorld(const Scene& s, Rays rays)
    : scene(s),
      geometry(flatten(s)),
      surfaces(raster::prepare(s, geometry)),
      query(reference::build_ray_query(geometry, surfaces, rays)),
      offset(probes::offset_of(probes::extent_of(geometry))) {}

Radiance direct_light(const LadderWorld& world) {
    return [light = std::make_shared<const DirectLight>(world)](const RayEnd& end) { return (*light)(end); };
}

namespace {

// Leaves out receivers that see too much of the sky.
void leave_out(const std::vector<bool>& out, CheckedReceivers& c) {
    CheckedReceivers kept;
    std::vector<int> index;
    for (std::size_t i = 0; i < out.size(); ++i) {
        if (out[i]) continue;
        index.push_back(int(i));
        kept.index.push_back(c.index[i]), kept.truth.push_back(c.truth[i]), kept.uncertainty.push_back(c.uncertainty[i]);
        const auto first = c.radiance.begin() + std::ptrdiff_t(i) * c.rays;
        kept.radiance.insert(kept.radiance.end(), first, first + c.rays);
    }
    if (index.empty()) throw InputError("probe-ladder: every receiver sees more of the sky than --most-sky allows");
    kept.receivers = some_of(c.receivers, index), kept.rays = c.rays, kept.directions = c.directions;
    kept.before_sky = c.count() - kept.count();
    c = std::move(kept);
}

}  // namespace

CheckedReceivers check_receivers(const LadderWorld& world, const Radiance& radiance, const probes::Receivers& all,
                                 const CheckRequest& request, int bake_rays, probes::Distribution distribution,
                                 const RunOptions& options) {
    CheckedReceivers c;
    const int n = std::min(request.receivers, all.count()), truth_rays = request.truth_rays;
    std::vector<char> before_sky(std::size_t(n), 0);
    for (int i = 0; i < n; ++i) c.index.push_back(int((2 * std::int64_t(i) + 1) * all.count() / (2 * n)));
    c.receivers = some_of(all, c.index);
    c.rays = bake_rays;
    c.directions = probes::receiver_directions(bake_rays, distribution);
    c.radiance.resize(std::size_t(n) * std::size_t(bake_rays));
    c.truth.resize(std::size_t(n)), c.uncertainty.resize(std::size_t(n));
    std::vector<glm::vec3> of_truth;
    for (int k = 0; k < truth_rays; ++k) of_truth.push_back(direction_of_truth(k));

    parallel_bands(n, 4, options, [&](int first, int last) {
        Fetcher fetch(world, radiance);
        for (int i = first; i < last; ++i) {
            const glm::vec3 normal(c.receivers.normal[std::size_t(i)]);
            const glm::vec3 origin = glm::vec3(c.receivers.position[std::size_t(i)]) + normal * world.offset;
            const reference::Basis<float> frame = reference::basis_of<float>(normal);
            for (int k = 0; k < bake_rays; ++k)
                c.radiance[std::size_t(i) * std::size_t(bake_rays) + std::size_t(k)] =
                    float(fetch(origin, reference::to_world<float>(frame, glm::vec3(c.directions[std::size_t(k)]))));
            const double turn = 2 * host::pi * van_der_corput(std::uint64_t(i), 3);
            const float cosine = float(host::cos(turn)), sine = float(host::sin(turn));
            double half[2] = {0, 0};
            fetch.found = 0;
            for (int k = 0; k < truth_rays; ++k) {
                const glm::vec3 d = of_truth[std::size_t(k)];
                const glm::vec3 turned(cosine * d.x - sine * d.y, sine * d.x + cosine * d.y, d.z);
                half[k >= truth_rays / 2] += fetch(origin, reference::to_world<float>(frame, turned));
            }
            c.truth[std::size_t(i)] = host::pi * (half[0] + half[1]) / truth_rays;
            c.uncertainty[std::size_t(i)] = host::pi * std::fabs(half[0] - half[1]) / truth_rays;
            before_sky[std::size_t(i)] = double(truth_rays - fetch.found) > request.most_sky * truth_rays;
        }
    });
    leave_out({before_sky.begin(), before_sky.end()}, c);
    return c;
}

std::vector<std::vector<double>> irradiance_by(const LadderWorld& world, const Radiance& radiance,
                                               const probes::Receivers& receivers, const Buffer<glm::vec4>& directions,
                                               const std::vector<int>& prefixes, probes::Distribution distribution,
                                               double turn_rad, const RunOptions& options) {
    const float cosine = float(host::cos(turn_rad)), sine = float(host::sin(turn_rad));
    std::vector<std::vector<double>> irradiance(prefixes.size(), std::vector<double>(std::size_t(receivers.count()), 0));
    std::vector<Buffer<float>> factors;
    for (const int n : prefixes)
        factors.push_back(probes::ray_factors(Buffer<glm::vec4>(directions.begin(), directions.begin() + n), distribution));
    const int most = *std::max_element(prefixes.begin(), prefixes.end());
    parallel_bands(receivers.count(), 4, options, [&](int first, int last) {
        Fetcher fetch(world, radiance);
        for (int i = first; i < last; ++i) {
            const glm::vec3 normal(receivers.normal[std::size_t(i)]);
            const glm::vec3 origin = glm::vec3(receivers.position[std::size_t(i)]) + normal * world.offset;
            const reference::Basis<float> frame = reference::basis_of<float>(normal);
            for (int k = 0; k < most; ++k) {
                const glm::vec4 d = directions[std::size_t(k)];
                const glm::vec3 turned(cosine * d.x - sine * d.y, sine * d.x + cosine * d.y, d.z);
                const double radiance_k = fetch(origin, reference::to_world<float>(frame, turned));
                for (std::size_t p = 0; p < prefixes.size(); ++p)
                    if (k < prefixes[p]) irradiance[p][std::size_t(i)] += double(factors[p][std::size_t(k)]) * radiance_k;
            }
        }
    });
    return irradiance;
}

ProbeLight probe_light(const LadderWorld& world, const Radiance& radiance, const Buffer<glm::vec4>& probes,
                       const Buffer<glm::vec4>& directions, probes::Escape escape, const RunOptions& options) {
    ProbeLight light;
    light.probes = int(probes.size()), light.directions = directions;
    for (const glm::vec4& d : directions) {
        const glm::dvec3 exact(d);
        const sh::Values y = sh::basis(exact / std::sqrt(glm::dot(exact, exact)));
        light.harmonics.insert(light.harmonics.end(), y.begin(), y.end());
    }
    light.radiance.resize(probes.size() * directions.size());
    std::vector<std::uint8_t> asked(light.radiance.size()), skies;
    for (const glm::vec4& p : probes) skies.push_back(probes::is_sky(p) ? 1 : 0);
    const bool everywhere = escape != probes::Escape::nothing && escape != probes::Escape::sky;
    // Rays of a band of one probe: there may be a single one.
    constexpr int rays = 256;
    const int bands = (light.rays() + rays - 1) / rays;
    parallel_bands(light.probes * bands, 1, options, [&](int first, int last) {
        Fetcher fetch(world, radiance);
        for (int band = first; band < last; ++band) {
            const std::size_t p = std::size_t(band / bands);
            const int begin = band % bands * rays, end = std::min(begin + rays, light.rays());
            for (int k = begin; k < end; ++k) {
                const std::size_t at = p * directions.size() + std::size_t(k);
                light.radiance[at] = float(fetch(glm::vec3(probes[p]), glm::vec3(directions[std::size_t(k)])));
                asked[at] = fetch.last.front || (!fetch.last.found && (skies[p] || everywhere)) ? 1 : 0;
            }
        }
    });
    const std::vector<std::int32_t> ray_of = probes::stand_ins(directions, asked, options);
    for (std::size_t at = 0; at < ray_of.size(); ++at) light.radiance[at] = light.radiance[std::size_t(ray_of[at])];
    return light;
}

namespace {

// What rays of receivers met, and the normal on the side that they met it from.
struct MetPoint {
    glm::vec3 position, normal;
};

std::vector<MetPoint> met_points(const LadderWorld& world, const CheckedReceivers& checked, int receivers, int rays) {
    const raster::SurfaceArgs surfaces = world.args();
    RayTracer<float> tracer(*world.query);
    std::vector<MetPoint> points;
    for (int k = 0; k < std::min(receivers, checked.count()); ++k) {
        const std::size_t i = std::size_t(std::int64_t(k) * checked.count() / std::min(receivers, checked.count()));
        const glm::vec3 normal(checked.receivers.normal[i]);
        const glm::vec3 origin = glm::vec3(checked.receivers.position[i]) + normal * world.offset;
        const reference::Basis<float> frame = reference::basis_of<float>(normal);
        for (int r = 0; r < std::min(rays, checked.rays); ++r) {
            const glm::vec3 direction = reference::to_world<float>(frame, glm::vec3(checked.directions[std::size_t(r)]));
            const RayHit<float> hit = tracer.nearest(origin, direction, true);
            if (!hit.found) continue;
            const probes::Met<float> met = probes::met_by<float>(surfaces, hit, direction);
            if (met.front) points.push_back({met.point, met.normal});
        }
    }
    return points;
}

}  // namespace

std::vector<int> places_that_see_most(const LadderWorld& world, const CheckedReceivers& checked,
                                      const Buffer<glm::vec4>& places, int wanted, const RunOptions& options) {
    const std::vector<MetPoint> points = met_points(world, checked, 512, 32);
    std::vector<std::vector<std::uint8_t>> sees(places.size(), std::vector<std::uint8_t>(points.size(), 0));
    parallel_bands(int(places.size()), 1, options, [&](int first, int last) {
        RayTracer<float> tracer(*world.query);
        for (std::size_t p = std::size_t(first); p < std::size_t(last); ++p)
            for (std::size_t k = 0; k < points.size(); ++k) {
                const glm::vec3 start = points[k].position + points[k].normal * world.offset, to = glm::vec3(places[p]) - start;
                sees[p][k] = dot3(points[k].normal, to) > 0 && tracer.visible(start, to, 0, 1, true) ? 1 : 0;
            }
    });
    std::vector<int> chosen;
    std::vector<std::uint8_t> seen(points.size(), 0);
    std::vector<bool> taken(places.size(), false);
    while (int(chosen.size()) < std::min(wanted, int(places.size()))) {
        int best = -1, most = -1;
        for (std::size_t p = 0; p < places.size(); ++p) {
            if (taken[p]) continue;
            int more = 0;
            for (std::size_t k = 0; k < points.size(); ++k) more += sees[p][k] & ~seen[k] & 1;
            if (more > most) best = int(p), most = more;
        }
        chosen.push_back(best);
        taken[std::size_t(best)] = true;
        for (std::size_t k = 0; k < points.size(); ++k) seen[k] |= sees[std::size_t(best)][k];
    }
    return chosen;
}

}  // namespace plumb::cli
