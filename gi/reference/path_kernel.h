// Path tracing with next-event estimation and multiple importance sampling (Kajiya 1986; Veach 1997): one lane follows
// one path at a time, and begins the next where that one ends, so that no lane waits for another.
//
//     L(x, w_o) = M/pi + integral f(w_i, w_o) L(w_i) cos(theta) dw_i                            the rendering equation
//
// Light that comes from emitting triangles and the environment is found in two ways: by choosing a point on a light,
// and by following the path until it meets one. Each is weighted by p^2 / (p^2 + q^2), p its own density and q that of
// the other (the power heuristic, Veach (9.13)). Lamps are points: only the first way finds them.
#pragma once

#include "gi/reference/bsdf_kernel.h"
#include "gi/reference/microfacet_kernel.h"
#include "gi/reference/mirror_kernel.h"
#include "gi/reference/sampler_kernel.h"
#include "gi/trace_rays.h"

namespace plumb::reference {

// A pinhole: the ray through the window position (x, y) goes along corner + x across + y down.
struct CameraArgs {
    float eye[3], corner[3], across[3], down[3];
};

struct PathArgs {
    raster::SurfaceArgs surfaces;
    LightArgs lights;
    MirrorArgs mirrors;
    EnvironmentArgs environment;
    const float* reflection;     // [material][8]: specular, exponent; mirror, padding
    std::int32_t glossy;         // 1: some material has a specular or a mirror part
    MicrofacetArgs microfacets;
    std::int32_t faceted;        // 1: some material has microfacets
    std::int32_t emitters;       // 1: some triangle emits
    CameraArgs camera;
    const float* position;       // [height][width] rgba32f: points instead of a camera's pixels; null: a camera
    const float* normal;
    std::int32_t mirrored;       // the points are seen from camera.eye; 1: perfect mirrors; 2: white lobes of the exponent
                                 // normal.w, which lamps do not light; 0: they are white and diffuse, and lit
    float extent;                // m: largest |coordinate| of the scene, for the points, whose triangles are not known
    std::int32_t width, first_row;
    std::int32_t round, samples; // samples of this round
    std::uint32_t seed;
    std::int32_t first_bounce, last_bounce;  // reflections before the light reaches the first surface
    std::int32_t last_depth;     // surfaces after which no path can find anything that counts
    std::int32_t openness;       // 1: ambient occlusion
    float inverse_roulette;      // 1 / PathParams::roulette
    float ao_distance;           // m
    std::int32_t jitter;         // 1: camera rays start anywhere in their pixel
    float* sum;                  // [height][width] rgba32f, out: sum over the samples of this round
    double* exact_sum;           // [height][width][3], out: the same, of a number that keeps a double (core/followed.h)
};

// Where a path is: at a surface.
template <class F>
struct PathVertex {
    vec3<F> x;          // m
    vec3<F> n;          // unit, shading
    vec3<F> face;       // unit, geometric; both on the side that the path comes from
    F offset;           // m, off the surface
    vec3<F> emission;   // radiance, W/(m2 sr)
    Bsdf<F> bsdf;
    Facets<F> facets;   // where they are present, in place of it
};

// Survival of Russian roulette is at most 1 - 2^-20, so that no path lasts for ever. A path that carries rho of what it did
// at each surface is then weighted by (rho / (1 - 2^-20))^k after k of them, and its variance is finite while rho is below
// 1 - 2^-21: README.md, "How paths end".
inline constexpr float largest_survival = 1.0f - 0x1p-20f;

// One sample's path on its way, and the pixel's sum.
template <class F>
struct PathState {
    index_t<F> pixel, sample;
    index_t<F> depth;     // surfaces so far
    Sampler<F> sampler;
    vec3<F> origin, direction;
    vec3<F> throughput;
    F pdf;                // of the direction, 1/sr; 0: only this way finds what lies there
    vec3<F> radiance;     // that it found so far
    vec3<F> found_carry;  // what rounding took from it
    vec3<F> sum, carry;   // over the samples of the pixel, and what rounding took from it
};

template <class F>
PLUMB_INLINE F power_heuristic(F p, F q) {
    const F ratio = q / max(p, F(1e-37f));
    return F(1.0f) / (F(1.0f) + ratio * ratio);
}

template <class F>
PLUMB_INLINE mask_t<F> counted(const PathArgs& in, index_t<F> bounces) {
    using I = index_t<F>;
    return (bounces >= I(in.first_bounce)) & (bounces <= I(in.last_bounce));
}

template <class F>
PLUMB_INLINE vec3<F> where(const mask_t<F>& m, const vec3<F>& v) {
    return select3<F>(m, v, vec3<F>{F(0.0f), F(0.0f), F(0.0f)});
}

// Dimensions of the sampler: a pair for the place in the pixel, then three a surface.
enum Dimension : int { dimension_pixel = 0, dimension_light = 1, dimension_direction = 2, dimension_choice = 3 };
inline constexpr int dimensions_a_vertex = 3;
// Pairs of the images are far from all of a path's others.
inline constexpr int dimension_image = 1 << 28, dimension_images = dimension_image + (1 << 27);

// A sample's first ray; of a given point, the point stands for it, and the ray is not traced.
template <class F>
PLUMB_INLINE void start_sample(const PathArgs& in, const mask_t<F>& starting, PathState<F>& s) {
    using I = index_t<F>;
    using N = number<F>;
    // Rows are counted from the band's first: a float divides so small a number exactly enough.
    const F along = N::from_index(s.pixel - I(in.first_row * in.width)) + F(0.5f);
    const I row = N::truncate_to_index(along / F(float(in.width)));
    const I py = row + I(in.first_row), px = s.pixel - py * I(in.width);
    const Sampler<F> sampler = Sampler<F>::start(px, py, I(in.round), I(std::int32_t(in.seed)), s.sample);
    s.sampler.key = {select(starting, sampler.key.x, s.sampler.key.x), select(starting, sampler.key.y, s.sampler.key.y),
                     select(starting, sampler.key.z, s.sampler.key.z)};
    s.sampler.index_digits = select(starting, sampler.index_digits, s.sampler.index_digits);
    s.depth = select(starting, I(0), s.depth);
    s.throughput = select3<F>(starting, vec3<F>{F(1.0f), F(1.0f), F(1.0f)}, s.throughput);
    s.pdf = select(starting, F(0.0f), s.pdf);
    if (in.position) return;

    vec2<F> place{F(0.5f), F(0.5f)};
    if (in.jitter) place = sampler.pair(I(dimension_pixel));
    const F x = N::from_index(px) + place.x, y = N::from_index(py) + place.y;
    const CameraArgs& c = in.camera;
    const vec3<F> d{F(c.corner[0]) + (F(c.across[0]) * x + F(c.down[0]) * y),
                    F(c.corner[1]) + (F(c.across[1]) * x + F(c.down[1]) * y),
                    F(c.corner[2]) + (F(c.across[2]) * x + F(c.down[2]) * y)};
    s.origin = select3<F>(starting, vec3<F>{F(c.eye[0]), F(c.eye[1]), F(c.eye[2])}, s.origin);
    s.direction = select3<F>(starting, normalize3<F>(d), s.direction);
}

// The microfacets of the surface that a ray met.
template <class F>
PLUMB_INLINE Facets<F> facets_met(const PathArgs& in, const RayHit<F>& hit, const vec3<F>& base, const vec3<F>& n,
                                  const vec3<F>& direction) {
    using N = number<F>;
    using I = index_t<F>;
    const vec4<F> m = N::fetch4(in.microfacets.materials, N::fetch(in.surfaces.material, hit.triangle));
    F metalness = m.x, roughness = m.y;
    const I texture = N::truncate_to_index(m.z);
    if (any(texture > I(0))) {
        const raster::Corners<F> c = raster::fetch_corners<F>(in.surfaces, hit.triangle);
        const vec2<F> uv = raster::interpolate_uv<F>({c.a.p.w, c.a.n.w}, {c.b.p.w, c.b.n.w}, {c.c.p.w, c.c.n.w},
                                                     hit.barycentrics);
        NoTap quiet;
        const vec3<F> texel = raster::sample<F>(in.surfaces.textures, texture, uv, F(0.0f), true, quiet);
        roughness = roughness * texel.y, metalness = metalness * texel.z;
    }
    const vec3<F> w_o{-direction.x, -direction.y, -direction.z};
    return facets_of<F>(in.microfacets, m.w > F(0.0f), base, metalness, roughness, n, w_o);
}

// The surface that a ray met.
template <class F, bool faceted>
PLUMB_INLINE PathVertex<F> vertex_of(const PathArgs& in, const RayHit<F>& hit, const vec3<F>& direction) {
    using N = number<F>;
    using I = index_t<F>;
    NoTap quiet;
    const vec4<F> viewer{-direction.x, -direction.y, -direction.z, F(0.0f)};
    const raster::Surface<F> s = raster::surface<F>(in.surfaces, hit.triangle, hit.barycentrics, viewer, quiet);
    PathVertex<F> v;
    v.x = s.position;
    v.n = s.normal;
    const F scale = -raster::side_of(dot3(s.face, direction)) / max(sqrt(dot3(s.face, s.face)), F(1e-30f));
    v.face = s.face * scale;
    v.offset = ray_offset(s.extent);
    v.emission = s.emission * F(float(1 / 3.14159265358979323846));
    v.bsdf.diffuse = s.albedo;
    if (in.glossy) {
        const I row = N::fetch(in.surfaces.material, hit.triangle) * I(2);
        const vec4<F> specular = N::fetch4(in.reflection, row), mirror = N::fetch4(in.reflection, row + I(1));
        v.bsdf.specular = xyz<F>(specular), v.bsdf.exponent = specular.w, v.bsdf.mirror = xyz<F>(mirror);
    }
    if constexpr (faceted) v.facets = facets_met<F>(in, hit, s.albedo, v.n, direction);
    return v;
}

// A given point: white, so that what leaves it is its irradiance over pi, and seen from above; or a perfect mirror or a
// lobe, seen by the eye.
template <class F, bool faceted>
PLUMB_INLINE void take_given_points(const PathArgs& in, const mask_t<F>& first, PathState<F>& s,
                                    PathVertex<F>& v) {
    using N = number<F>;
    const F one(1.0f), zero(0.0f);
    const vec3<F> black{zero, zero, zero};
    // Lanes that have no pixel left read another's.
    const index_t<F> pixel = select(first, s.pixel, index_t<F>(in.first_row * in.width));
    const vec4<F> normal = N::fetch4(in.normal, pixel);
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel)), n = xyz<F>(normal);
    v.x = select3<F>(first, x, v.x);
    v.n = select3<F>(first, n, v.n);
    v.face = select3<F>(first, n, v.face);
    vec3<F> seen_along{-n.x, -n.y, -n.z};
    if (in.mirrored) {
        const float* eye = in.camera.eye;
        seen_along = normalize3<F>(vec3<F>{x.x - F(eye[0]), x.y - F(eye[1]), x.z - F(eye[2])});
    }
    s.direction = select3<F>(first, seen_along, s.direction);
    v.offset = select(first, ray_offset(F(in.extent)), v.offset);
    v.emission = select3<F>(first, black, v.emission);
    const vec3<F> white{one, one, one};
    v.bsdf.diffuse = select3<F>(first, in.mirrored ? black : white, v.bsdf.diffuse);
    v.bsdf.specular = select3<F>(first, in.mirrored == 2 ? white : black, v.bsdf.specular);
    if (in.mirrored == 2) v.bsdf.exponent = select(first, normal.w, v.bsdf.exponent);
    v.bsdf.mirror = select3<F>(first, in.mirrored == 1 ? white : black, v.bsdf.mirror);
    if constexpr (faceted) v.facets.present = v.facets.present & !first;
}

// What a ray that the surface before sent out finds to shine: the surface that it met, or the environment.
template <class F>
PLUMB_INLINE vec3<F> light_met(const PathArgs& in, const PathState<F>& s, const RayHit<F>& hit, const PathVertex<F>& v,
                               const mask_t<F>& traced) {
    using N = number<F>;
    using I = index_t<F>;
    const F zero(0.0f), one(1.0f);
    vec3<F> radiance{zero, zero, zero};
    F other(0.0f);  // density of choosing that very point as a point on a light
    if (in.emitters) {
        radiance = where<F>(hit.found, v.emission);
        const F cosine = abs(dot3(v.face, s.direction));
        other = N::fetch(in.lights.triangle_pdf, hit.triangle) * (hit.t * hit.t) / max(cosine, F(1e-20f));
    }
    const mask_t<F> escaped = traced & !hit.found;
    if (in.environment.width > 0 && any(escaped)) {
        radiance = select3<F>(escaped, environment_radiance<F>(in.environment, s.direction), radiance);
        const F pdf = environment_pdf<F>(in.environment, s.direction) * F(in.lights.environment_probability);
        other = select(escaped, pdf, other);
    }
    const F weight = select(s.pdf > zero, power_heuristic(s.pdf, other), one);
    // Light at the end of the path after `depth` surfaces was reflected depth - 1 times before the first of them; seen
    // directly, it counts as `direct`.
    const mask_t<F> shown = traced & counted<F>(in, max(s.depth - I(1), I(0)));
    return where<F>(shown, raster::times3<F>(s.throughput, radiance * weight));
}

// What the surface makes of light from w_i.
template <class F, bool faceted>
PLUMB_INLINE Scattering<F> scatter_at(const PathArgs& in, const PathVertex<F>& v, const vec3<F>& w_o, const vec3<F>& w_i) {
    Scattering<F> out = in.glossy ? scatter<F>(v.bsdf, v.n, w_o, w_i)
                                  : Scattering<F>{evaluate_diffuse<F>(v.bsdf.diffuse, v.n, w_i), pdf_diffuse<F>(v.n, w_i)};
    if constexpr (faceted) {
        if (any(v.facets.present)) {
            const Scattering<F> of = scatter_facets<F>(in.microfacets, v.facets, w_i);
            out = {select3<F>(v.facets.present, of.value, out.value), select(v.facets.present, of.pdf, out.pdf)};
        }
    }
    return out;
}

// And where it sends a path.
template <class F, bool faceted>
PLUMB_INLINE BsdfSample<F> sample_at(const PathArgs& in, const PathVertex<F>& v, const vec3<F>& w_o, const vec2<F>& u, F u_lobe) {
    BsdfSample<F> out = in.glossy ? sample<F>(v.bsdf, v.n, w_o, u_lobe, u.x, u.y)
                                  : sample_diffuse<F>(v.bsdf.diffuse, v.n, u.x, u.y);
    if constexpr (faceted) {
        if (any(v.facets.present)) {
            const BsdfSample<F> of = sample_facets<F>(in.microfacets, v.facets, u_lobe, u.x, u.y);
            const mask_t<F>& m = v.facets.present;
            out = {select3<F>(m, of.direction, out.direction), select3<F>(m, of.weight, out.weight),
                   select(m, of.pdf, out.pdf), mask_t<F>(out.mirror & !m)};
        }
    }
    return out;
}

// Light from a point on one of the lights.
template <class F, bool faceted>
PLUMB_INLINE vec3<F> light_chosen(const PathArgs& in, const PathState<F>& s, const PathVertex<F>& v, const vec2<F>& u,
                                  F fresh, const mask_t<F>& at_surface, RayTracer<F>& tracer) {
    const F zero(0.0f), one(1.0f);
    const ChosenLight<F> chosen = choose_light<F>(in.lights, u.x, fresh);
    const LightSample<F> light = sample_light<F>(in.lights, in.surfaces, in.environment, chosen, u.y, v.x);
    const vec3<F> w_o{-s.direction.x, -s.direction.y, -s.direction.z};
    const Scattering<F> out = scatter_at<F, faceted>(in, v, w_o, light.direction);
    const F weight = select(light.pdf > zero, power_heuristic(light.pdf, out.pdf), one);
    const vec3<F> radiance = raster::times3<F>(raster::times3<F>(s.throughput, out.value), light.radiance * weight);
    const mask_t<F> asks = at_surface & (dot3(v.face, light.direction) > zero) &
                           !((radiance.x == zero) & (radiance.y == zero) & (radiance.z == zero));
    if (!any(asks)) return {zero, zero, zero};
    const vec3<F> origin = v.x + v.face * v.offset;
    const vec3<F> towards = select3<F>(light.infinite, light.direction, raster::minus3(light.target, origin));
    const F t_far = select(light.infinite, F(__builtin_inff()), one);
    return where<F>(tracer.visible(origin, towards, zero, t_far, asks), radiance);
}

// Light from the image of one of the lamps in one of the flat mirrors, or in several one after another.
template <class F, bool faceted>
PLUMB_INLINE vec3<F> image_chosen(const PathArgs& in, const PathState<F>& s, const PathVertex<F>& v, index_t<F> dimension,
                                  const mask_t<F>& at_surface, RayTracer<F>& tracer) {
    using N = number<F>;
    using I = index_t<F>;
    const F zero(0.0f), one(1.0f), endless(__builtin_inff());
    const LampImage<F> image = choose_image<F>(in.lights, in.mirrors, s.sampler.random(dimension + I(dimension_image)),
                                               s.sampler.random(dimension + I(dimension_images)));
    // Towards x all segments are one, as long as they are together.
    const vec3<F> seen = image.point[longest_of(in.mirrors)];
    const vec3<F> d = select3<F>(image.infinite, vec3<F>{-seen.x, -seen.y, -seen.z}, raster::minus3(seen, v.x));
    const F d2 = dot3(d, d);
    const vec3<F> direction = d * (one / sqrt(max(d2, F(1e-37f))));
    const vec3<F> w_o{-s.direction.x, -s.direction.y, -s.direction.z};
    vec3<F> carried = raster::times3<F>(s.throughput, scatter_at<F, faceted>(in, v, w_o, direction).value) * image.weight;
    mask_t<F> asks = at_surface & counted<F>(in, s.depth + image.length) & (dot3(v.face, direction) > zero) &
                     (raster::largest3(carried) > zero);

    vec3<F> origin = v.x + v.face * v.offset;
    for (int j = longest_of(in.mirrors) - 1; j >= 0; --j) {
        const mask_t<F> traced = asks & (image.length > I(j));
        if (!any(traced)) continue;
        const vec3<F> to = image.point[j + 1];
        const vec3<F> way = select3<F>(image.infinite, vec3<F>{-to.x, -to.y, -to.z}, raster::minus3(to, origin));
        const RayHit<F> hit = tracer.nearest(origin, way, traced);
        const mask_t<F> on_plane = hit.found & (N::fetch(in.mirrors.plane, hit.triangle) == image.plane[j]);
        // A mirror beyond the image would hide the lamp that is behind it: a ray less.
        const mask_t<F> before = hit.t < select(image.infinite, endless, one);
        const PathVertex<F> mirror = vertex_of<F, false>(in, hit, way);
        carried = select3<F>(traced, raster::times3<F>(carried, mirror.bsdf.mirror), carried);
        origin = select3<F>(traced, vec3<F>(mirror.x + mirror.face * mirror.offset), origin);
        asks = asks & ((on_plane & before) | !traced);
    }
    if (!any(asks)) return {zero, zero, zero};

    const vec3<F> lamp = image.point[0];
    const vec3<F> way = select3<F>(image.infinite, vec3<F>{-lamp.x, -lamp.y, -lamp.z}, raster::minus3(lamp, origin));
    const vec3<F> from = way * (one / sqrt(max(dot3(way, way), F(1e-37f))));
    const Record<F> row = N::fetch_record(in.lights.rows, image.lamp);
    const F falloff = lamp_falloff<F>(in.lights, row, image.lamp, from, d2, one / max(d2, F(1e-37f)));
    const vec3<F> radiance = raster::times3<F>(carried, xyz<F>(row.c) * select(image.infinite, one, falloff));
    return where<F>(tracer.visible(origin, way, zero, select(image.infinite, endless, one), asks), radiance);
}

// 1 where a cosine-weighted direction is open, 0 where something is near.
template <class F>
PLUMB_INLINE F openness(const PathArgs& in, const PathVertex<F>& v, const vec2<F>& u, const mask_t<F>& at_surface,
                        RayTracer<F>& tracer) {
    const vec3<F> d = to_world<F>(basis_of<F>(v.n), cosine_hemisphere<F>(u.x, u.y));
    const mask_t<F> asks = at_surface & (dot3(v.face, d) > F(0.0f));
    const mask_t<F> open = tracer.visible(vec3<F>(v.x + v.face * v.offset), d, F(0.0f), F(in.ao_distance), asks);
    return select(open, F(1.0f), F(0.0f));
}

// Sends the path on from its surface. Returns where it goes on: it ends where nothing that it finds could count, and by
// Russian roulette where it carries little; what survives stands for what did not.
template <class F, bool faceted>
PLUMB_INLINE mask_t<F> scatter_path(const PathArgs& in, const PathVertex<F>& v, const vec2<F>& u, const vec3<F>& choice,
                                    PathState<F>& s) {
    using I = index_t<F>;
    const F zero(0.0f), one(1.0f);
    const vec3<F> w_o{-s.direction.x, -s.direction.y, -s.direction.z};
    const BsdfSample<F> next = sample_at<F, faceted>(in, v, w_o, u, choice.y);
    s.throughput = raster::times3<F>(s.throughput, next.weight);
    s.pdf = select(next.mirror, zero, next.pdf);
    s.origin = v.x + v.face * v.offset;
    s.direction = next.direction;
    s.depth = s.depth + I(1);

    const F brightest = raster::largest3(s.throughput);
    const F survival = select(s.depth > I(2), min(brightest * F(in.inverse_roulette), F(largest_survival)), one);
    s.throughput = s.throughput * (one / max(survival, F(1e-37f)));
    return (dot3(v.face, s.direction) > zero) & (brightest > zero) & (s.depth <= I(in.last_depth)) &
           (choice.z < survival);
}

// Sums with compensation (Kahan 1965): where almost all light is reflected a path has a million terms, all alike, and a
// round may have as many samples.
template <class F>
PLUMB_INLINE void add_compensated(const vec3<F>& value, vec3<F>& sum, vec3<F>& carry) {
    const vec3<F> term = value - carry, next = sum + term;
    carry = (next - sum) - term;
    sum = next;
}

// The next sample of the pixel where paths end; the lane's next pixel where its samples do. Pixels of a lane are as far
// apart as there are lanes, so that the lanes of a packet stay side by side.
template <class F>
PLUMB_INLINE mask_t<F> next_sample(const PathArgs& in, const mask_t<F>& ended, std::int32_t last_pixel,
                                   PathState<F>& s) {
    using N = number<F>;
    using I = index_t<F>;
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    vec3<F> sum = s.sum, carry = s.carry;
    add_compensated<F>(s.radiance, sum, carry);
    s.sum = select3<F>(ended, sum, s.sum);
    s.carry = select3<F>(ended, carry, s.carry);
    s.radiance = select3<F>(ended, zero, s.radiance);
    s.found_carry = select3<F>(ended, zero, s.found_carry);
    s.sample = s.sample + select(ended, I(1), I(0));
    const mask_t<F> finished = ended & (s.sample >= I(in.samples));
    if (any(finished)) {
        N::store4(in.sum, s.pixel, vec4<F>(s.sum, F(0.0f)), finished);
        if constexpr (requires { s.sum.x.exact; })
            for (int c = 0; finished && c < 3; ++c) in.exact_sum[3 * std::ptrdiff_t(s.pixel) + c] = s.sum[c].exact;
        s.sum = select3<F>(finished, zero, s.sum);
        s.carry = select3<F>(finished, zero, s.carry);
        s.sample = select(finished, I(0), s.sample);
        s.pixel = s.pixel + select(finished, I(N::width), I(0));
    }
    const mask_t<F> active = s.pixel < I(last_pixel);
    start_sample<F>(in, ended & active, s);
    return active;
}

// All samples of this round for the rows [in.first_row, last_row). Returns the number of rays. Scenes without microfacets
// have a kernel that knows none.
template <class F, bool faceted = false>
PLUMB_INLINE std::uint64_t trace_paths(const PathArgs& in, const RayQuery& query, std::int32_t last_row) {
    const std::int32_t first = in.first_row * in.width, last = last_row * in.width;
    using N = number<F>;
    using I = index_t<F>;
    const F zero(0.0f), one(1.0f);
    RayTracer<F> tracer(query);
    PathState<F> s{};
    s.pixel = N::iota(first);
    s.origin = s.direction = {zero, zero, one};
    mask_t<F> active = s.pixel < I(last);
    start_sample<F>(in, active, s);
    while (any(active)) {
        // Follows the ray to the next surface. A given point is its own first surface.
        const mask_t<F> given = in.position ? mask_t<F>(active & (s.depth == I(0))) : mask_t<F>(active & !active);
        const mask_t<F> traced = active & !given;
        const RayHit<F> hit = tracer.nearest(s.origin, s.direction, traced);
        PathVertex<F> v = vertex_of<F, faceted>(in, hit, s.direction);
        mask_t<F> at_surface = hit.found;
        if (in.position) {
            take_given_points<F, faceted>(in, given, s, v);
            at_surface = at_surface | (given & !(dot3(v.n, v.n) == zero));
        }

        // Numbers for this surface.
        const I dimension = s.depth * I(dimensions_a_vertex);
        const vec3<F> choice = s.sampler.random(dimension + I(dimension_choice));
        const vec2<F> u_light = s.sampler.pair(dimension + I(dimension_light));
        const vec2<F> u_direction = s.sampler.pair(dimension + I(dimension_direction));

        // Gathers light, or openness, and goes on.
        mask_t<F> goes_on = at_surface & !at_surface;
        if (in.openness) {
            const F open = openness<F>(in, v, u_direction, at_surface, tracer);
            const F seen = select(traced & !hit.found, one, open);  // open where no surface is
            s.radiance = vec3<F>{seen, seen, seen};
        } else {
            vec3<F> found = light_met<F>(in, s, hit, v, traced);
            const mask_t<F> lit = in.mirrored == 2 ? mask_t<F>(at_surface & !given) : at_surface;
            const mask_t<F> asks = lit & counted<F>(in, s.depth);
            if (in.lights.count > 0 && any(asks))
                found = found + light_chosen<F, faceted>(in, s, v, u_light, choice.x, asks, tracer);
            if (in.mirrors.count > 0 && any(lit))
                found = found + image_chosen<F, faceted>(in, s, v, dimension, lit, tracer);
            // Once a surface, whether the lane asked or its neighbour: to add 0 is to add what was carried.
            add_compensated<F>(found, s.radiance, s.found_carry);
            goes_on = at_surface & scatter_path<F, faceted>(in, v, u_direction, choice, s);
            // Only this way finds what the ray of a given lobe meets.
            if (in.mirrored == 2) s.pdf = select(given, zero, s.pdf);
        }

        // Adds 0; but what is not finite of a point or a throughput, and would end the path unseen, stays in the
        // picture.
        s.radiance = s.radiance + where<F>(at_surface, (v.x + v.n + s.throughput) * zero);
        active = next_sample<F>(in, active & !goes_on, last, s);
    }
    return tracer.traced();
}

}  // namespace plumb::reference
