// A BoundStage made of a raster pass: what gbuffer and rsm share once their kernel is named.
//
// Pass is a small struct made from StageData and the scene that it draws. It offers
//
//     Uniforms, Twin                                               its block; its twin's generated header
//     static NamedStage describe()                                 what it binds: core/kernel_stage.h
//     static std::string refuses(const StageData&)                 optional: says what it cannot draw, or nothing
//     static void set_kept(std::vector<Port>& outputs)             optional: a frame keeps others than the twin writes
//     args                                                         the kernel's
//     static constexpr int components                              of its targets of floats, which come first
//     std::vector<double> indices(std::int32_t triangle) const     of its targets of indices, which follow
//     void target(Bundle& outputs)                                 where resolve() writes
//     void resolve<isa>(const TilePixels& seen) const              the kernel over a tile, in packets
//     std::array<F, components> pixel<F>(glm::ivec2 pixel, std::int32_t triangle, vec2<F> l, Tap& tap) const
//
// The depth buffer is the last output. A pass with an input named "behind" draws what lies behind it (visibility.h).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>

#include "core/fp_environment.h"
#include "core/outcomes.h"
#include "core/parallel.h"
#include "raster/bound_scene.h"
#include "raster/device_raster.h"
#include "raster/legal_pixels.h"
#include "raster/texture_bounded.h"
#include "raster/visibility_reference.h"
#include "raster/visible_tiles.h"

namespace plumb::raster {

template <class Pass>
class BoundPass final : public BoundStage {
  public:
    BoundPass(const StageBinding& binding, const StageData& data)
        : binding_(binding), data_(data), scene_(bound_scene(data)), peeled_(peeled_of(binding, data)),
          pass_(data, scene_) {}

    void run(const RunOptions& options, const DeviceProfile& profile, Bundle& outputs) const override {
        outputs = make_outputs(binding_, data_);
        Pass pass = pass_;
        pass.target(outputs);
        Image1 depth;
        if (profile.interpolation == Interpolation::ideal) {
            dispatch(options.isa, [&](auto isa) {
                draw_visible_tiles(scene_.geometry, &scene_.surfaces, scene_.clip_positions, data_.reversed_z,
                                   data_.size, options, depth, nullptr,
                                   [&](const TilePixels& seen) { pass.template resolve<isa()>(seen); }, behind());
            });
        } else {
            VisibilityBuffer seen = device_visibility(profile, options);
            resolve_rows(pass, seen, options);
            depth = std::move(seen.depth);
        }
        std::memcpy(outputs.arrays.back().bytes.data(), depth.data(), depth.size() * sizeof(float));
    }

    // A device that interpolates by planes is expected to draw our bits: only its arithmetic may differ. Of any other
    // it is only known how far it may place a vertex.
    void outcomes(glm::ivec2 pixel, const DeviceProfile& profile, std::span<const float> got,
                  std::span<const std::int32_t> choices, std::vector<Outcome>& out) const override {
        FpEnvironment environment;
        const Drawn& drawn = drawn_by(profile);
        const PrecisionScope precision(profile.precision);
        LegalTriangle ours = own(drawn.seen, pixel);
        out.clear();
        if (!drawn.legal) return append(pixel, ours, false, choices, out);
        std::vector<LegalTriangle> legal;
        bool nothing;
        drawn.legal->at(pixel, legal, nothing);
        for (LegalTriangle& t : legal)
            if (t.triangle == ours.triangle) t.l = ours.l, ours = t;
        append(pixel, ours, false, choices, out);

        // Where the device says which triangle it is, no other has to be looked at.
        const std::size_t last = Pass::components + pass_.indices(-1).size();
        const float triangle_seen = last > Pass::components && last < got.size() ? got[last - 1] : std::nanf("");
        auto may_be = [&](std::int32_t triangle) { return triangle_seen != triangle_seen || triangle_seen == float(triangle); };
        for (const LegalTriangle& t : legal)
            if (t.triangle != ours.triangle && may_be(t.triangle)) append(pixel, t, true, choices, out);
        if (nothing && ours.triangle >= 0 && may_be(-1)) append(pixel, empty_pixel(), true, choices, out);
    }

    // The triangle and the barycentrics that the rasteriser hands over are inputs of the kernel. The depth buffer is
    // the rasteriser's own: exact numbers, rounded once.
    void follow(glm::ivec2 pixel, DecisionTape& tape, std::vector<Followed>& out) const override {
        FpEnvironment environment;
        if (tape.recording()) {
            const VisibilityBuffer& seen = ideal_visibility();
            const glm::vec2& l = seen.barycentrics(pixel.x, pixel.y);
            tape.given = {l.x, l.y}, tape.given_index = {seen.triangle(pixel.x, pixel.y)};
        }
        const std::int32_t triangle = tape.given_index.at(0);
        out.assign(Pass::components, Followed());
        if (triangle < 0) return;
        const FollowScope scope(tape);
        NoTap tap;
        const vec2<Followed> l{Followed(tape.given[0]), Followed(tape.given[1])};
        const auto components = pass_.template pixel<Followed>(pixel, triangle, l, tap);
        out.assign(components.begin(), components.end());
    }

    std::vector<TapValue> explain(glm::ivec2 pixel, const DeviceProfile& profile) const override {
        const bool ideal = profile.interpolation == Interpolation::ideal;
        const VisibilityBuffer row = ideal ? row_of(pixel.y) : VisibilityBuffer();
        const VisibilityBuffer& seen = ideal ? row : drawn_by(profile).seen;
        const std::int32_t triangle = seen.triangle(pixel.x, pixel.y);
        FpEnvironment environment;
        Recorder recorder;
        if (triangle < 0) {
            recorder("triangle", triangle, "nothing is seen");
            return recorder.values;
        }
        recorder("object", scene_.geometry.object[std::size_t(triangle)], "index, of the triangle");
        recorder("z", seen.depth(pixel.x, pixel.y), "of the depth buffer, 0 to 1; not the linear depth");
        pass_.template pixel<float>(pixel, triangle, vec2<float>(seen.barycentrics(pixel.x, pixel.y)), recorder);
        return recorder.values;
    }

  private:
    // The depth buffer of the layer before, of a pass that has one.
    static Image1 peeled_of(const StageBinding& binding, const StageData& data) {
        Image1 peeled;
        for (const Slot& slot : binding.inputs) {
            if (slot.name != "behind") continue;
            peeled = Image1(data.size.x, data.size.y);
            std::memcpy(peeled.data(), floats(data, slot.name), peeled.size() * sizeof(float));
        }
        return peeled;
    }
    const Image1* behind() const { return peeled_.empty() ? nullptr : &peeled_; }

    const VisibilityBuffer& ideal_visibility() const {
        std::call_once(ideal_drawn_, [&] {
            RunOptions one;
            one.threads = 1;
            ideal_ = reference_visibility(scene_.geometry, &scene_.surfaces, scene_.clip_positions, data_.reversed_z,
                                          data_.size, 0, data_.size.y, one, behind());
        });
        return ideal_;
    }
    VisibilityBuffer row_of(int y) const {
        RunOptions one;
        one.threads = 1;
        return reference_visibility(scene_.geometry, &scene_.surfaces, scene_.clip_positions, data_.reversed_z,
                                    data_.size, y, y + 1, one, behind());
    }

    VisibilityBuffer device_visibility(const DeviceProfile& profile, const RunOptions& options) const {
        VisibilityBuffer seen;
        draw_device_visibility(scene_.geometry, &scene_.surfaces, scene_.clip_positions, data_.reversed_z, data_.size,
                               profile, options, seen, behind());
        return seen;
    }

    // A row of pixels is a tile to the scalar kernels, whose blocks are single pixels.
    void resolve_rows(const Pass& pass, VisibilityBuffer& seen, const RunOptions& options) const {
        const auto width = std::size_t(data_.size.x);
        parallel_bands(data_.size.y, 8, options, [&](int first, int last) {
            std::vector<float> l1(width), l2(width);
            for (int y = first; y < last; ++y) {
                for (int x = 0; x < data_.size.x; ++x) {
                    const glm::vec2 l = seen.barycentrics(x, y);
                    l1[std::size_t(x)] = l.x, l2[std::size_t(x)] = l.y;
                }
                pass.template resolve<Isa::scalar>({{0, y}, {data_.size.x, y + 1}, data_.size.x,
                                                    &seen.triangle(0, y), l1.data(), l2.data()});
            }
        });
    }

    // What a profile's rasteriser shows, and, where that is uncertain, what else it may show.
    struct Drawn {
        DeviceProfile profile;
        VisibilityBuffer seen;
        std::unique_ptr<LegalPixels> legal;
    };
    const Drawn& drawn_by(const DeviceProfile& profile) const {
        const std::lock_guard lock(mutex_);
        for (const std::unique_ptr<Drawn>& d : drawn_)
            if (same_rasteriser(d->profile, profile)) return *d;
        auto d = std::make_unique<Drawn>();
        d->profile = profile;
        d->seen = device_visibility(profile, {});
        if (profile.interpolation == Interpolation::ideal)
            d->legal = std::make_unique<LegalPixels>(scene_, data_.reversed_z, data_.size, profile, behind());
        drawn_.push_back(std::move(d));
        return *drawn_.back();
    }
    static bool same_rasteriser(const DeviceProfile& a, const DeviceProfile& b) {
        return a.interpolation == b.interpolation && a.subpixel_bits == b.subpixel_bits &&
               a.fused_raster == b.fused_raster && a.snap_uncertainty == b.snap_uncertainty;
    }

    static LegalTriangle exact(std::int32_t triangle, const glm::vec2& l, double z) {
        LegalTriangle t{};
        t.triangle = triangle, t.bounded = true;
        t.l1 = {l.x, l.x}, t.l2 = {l.y, l.y}, t.z = {z, z}, t.l = l;
        return t;
    }
    LegalTriangle empty_pixel() const {
        const double clear = data_.reversed_z ? 0 : 1;
        return exact(-1, {0, 0}, clear);
    }
    LegalTriangle own(const VisibilityBuffer& seen, glm::ivec2 pixel) const {
        return exact(seen.triangle(pixel.x, pixel.y), seen.barycentrics(pixel.x, pixel.y),
                     seen.depth(pixel.x, pixel.y));
    }

    // Appends what the kernel makes of a triangle at the pixel.
    void append(glm::ivec2 pixel, const LegalTriangle& t, bool ambiguous, std::span<const std::int32_t> choices,
                std::vector<Outcome>& out) const {
        std::vector<Outcome> ways;
        if (t.triangle < 0)
            ways.push_back({std::vector<BoundedValue>(Pass::components, {0, 0}), false});
        else if (!t.bounded)
            ways.push_back({std::vector<BoundedValue>(Pass::components, {0, infinity}), true});
        else
            enumerate_outcomes(
                [&](std::vector<Bounded>& values) {
                    NoTap tap;
                    const vec2<Bounded> l{t.l1.bounded(t.l.x), t.l2.bounded(t.l.y)};
                    const auto components = pass_.template pixel<Bounded>(pixel, t.triangle, l, tap);
                    values.assign(components.begin(), components.end());
                },
                most_outcomes, ways, choices);
        if (t.triangle >= 0 && t.bounded && t.rounding.x > 0) tighten(t, ways);
        for (Outcome& way : ways) {
            // An undecided index is one of a texture's levels: it leaves position and depth alone.
            if (way.ambiguous)
                for (int c = 4; c < Pass::components; ++c) way.values[std::size_t(c)].bound = infinity;
            way.ambiguous = way.ambiguous || ambiguous;
            for (double index : pass_.indices(t.triangle)) way.values.push_back({index, 0});
            way.values.push_back({t.z.middle(), t.bounded ? t.z.high - t.z.middle() : infinity});
            out.push_back(std::move(way));
        }
    }

    // Two barycentrics that go together say more than two intervals. Position and depth are projective maps of the
    // window: their extremes over the box lie at its corners. So do a normal's, but for the second order of its
    // division by its length, where vertices have one and no map bends it.
    void tighten(const LegalTriangle& t, std::vector<Outcome>& ways) const {
        auto about = [](const Interval& i, double bound) {
            return Bounded::within(float(i.middle()), i.middle(), bound);
        };
        const auto middle = smooth_values<Bounded>(t.triangle, {about(t.l1, t.rounding.x), about(t.l2, t.rounding.y)});
        double reach[smooth] = {};
        for (const glm::dvec2& corner : t.corner) {
            const auto at = smooth_values<double>(t.triangle, vec2<double>(corner));
            for (std::size_t c = 0; c < smooth; ++c) reach[c] = std::max(reach[c], std::abs(at[c] - middle[c].shadow));
        }
        const double turn = std::max({reach[4], reach[5], reach[6]});
        const auto material = std::size_t(scene_.geometry.material[std::size_t(t.triangle)]);
        const bool bent = scene_.surfaces.materials[material * record_stride + 10] > 0;
        const bool given = middle[4].shadow != 0 || middle[5].shadow != 0 || middle[6].shadow != 0;
        for (Outcome& way : ways)
            for (std::size_t c = 0; c < (given && !bent ? smooth : 4); ++c)
                way.values[c].bound = std::min(way.values[c].bound,
                                               reach[c] + middle[c].bound + (c < 4 ? 0 : 4 * turn * turn));
    }

    // Position, linear depth, and the interpolated normal, unit, of either side: as surface() has them.
    static constexpr std::size_t smooth = 7;
    template <class F>
    std::array<F, smooth> smooth_values(std::int32_t triangle, const vec2<F>& l) const {
        const Corners<F> k = fetch_corners<F>(pass_.args.surfaces, triangle);
        auto at = [&](const vec4<F>& a, const vec4<F>& b, const vec4<F>& c) {
            return interpolate3(xyz<F>(a), minus3(xyz<F>(b), xyz<F>(a)), minus3(xyz<F>(c), xyz<F>(a)), l);
        };
        const vec3<F> x = at(k.a.p, k.b.p, k.c.p), n = normalised(at(k.a.n, k.b.n, k.c.n));
        return {x.x, x.y, x.z, linear_depth(pass_.args.eye, pass_.args.forward, x), n.x, n.y, n.z};
    }

    static constexpr double infinity = std::numeric_limits<double>::infinity();
    const StageBinding& binding_;
    const StageData& data_;
    const BoundScene scene_;
    const Image1 peeled_;
    const Pass pass_;
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<Drawn>> drawn_;
    mutable std::once_flag ideal_drawn_;
    mutable VisibilityBuffer ideal_;
};

}  // namespace plumb::raster
