// A BoundStage made of a raster pass: what gbuffer and rsm share once their kernel is named.
//
// Pass is a small struct made from StageData and the scene that it draws. It offers
//
//     static constexpr int components                              of its targets of floats, which come first
//     std::vector<double> indices(std::int32_t triangle) const     of its targets of indices, which follow
//     void target(Bundle& outputs)                                 where resolve() writes
//     void resolve<isa>(const TilePixels& seen) const              the kernel over a tile, in packets
//     std::array<F, components> pixel<F>(glm::ivec2 pixel, std::int32_t triangle, vec2<F> l, Tap& tap) const
//
// The depth buffer is the last output.
#pragma once

#include <array>

#include "core/bounded.h"
#include "core/fp_environment.h"
#include "core/parallel.h"
#include "raster/bound_scene.h"
#include "raster/device_raster.h"
#include "raster/visibility_reference.h"
#include "raster/visible_tiles.h"

namespace plumb::raster {

template <class Pass>
class BoundPass final : public BoundStage {
  public:
    BoundPass(const StageBinding& binding, const StageData& data)
        : binding_(binding), data_(data), scene_(bound_scene(data)), pass_(data, scene_) {}

    void run(const RunOptions& options, const DeviceProfile& profile, Bundle& outputs) const override {
        outputs = make_outputs(binding_, data_);
        Pass pass = pass_;
        pass.target(outputs);
        Image1 depth;
        if (profile.interpolation == Interpolation::ideal) {
            dispatch(options.isa, [&](auto isa) {
                draw_visible_tiles(scene_.geometry, &scene_.surfaces, scene_.clip_positions, data_.reversed_z,
                                   data_.size, options, depth, nullptr,
                                   [&](const TilePixels& seen) { pass.template resolve<isa()>(seen); });
            });
        } else {
            VisibilityBuffer seen = device_visibility(profile, options);
            resolve_rows(pass, seen, options);
            depth = std::move(seen.depth);
        }
        std::memcpy(outputs.arrays.back().bytes.data(), depth.data(), depth.size() * sizeof(float));
    }

    void outcomes(glm::ivec2 pixel, const DeviceProfile&, std::span<const float>, std::span<const std::int32_t>,
                  std::vector<Outcome>& out) const override {
        out.clear();
        const VisibilityBuffer seen = row_of(pixel.y);
        const std::int32_t triangle = seen.triangle(pixel.x, pixel.y);
        const glm::vec2 l = seen.barycentrics(pixel.x, pixel.y);
        Outcome ours;
        if (triangle >= 0) {
            NoTap tap;
            for (const Bounded& v :
                 pass_.template pixel<Bounded>(pixel, triangle, {Bounded(l.x), Bounded(l.y)}, tap))
                ours.values.push_back({v.shadow, v.bound});
        } else {
            ours.values.resize(Pass::components);
        }
        for (double index : pass_.indices(triangle)) ours.values.push_back({index, 0});
        ours.values.push_back({seen.depth(pixel.x, pixel.y), 0});
        out.push_back(ours);
    }

    std::vector<TapValue> explain(glm::ivec2 pixel) const override {
        const VisibilityBuffer seen = row_of(pixel.y);
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
    VisibilityBuffer row_of(int y) const {
        RunOptions one;
        one.threads = 1;
        return reference_visibility(scene_.geometry, &scene_.surfaces, scene_.clip_positions, data_.reversed_z,
                                    data_.size, y, y + 1, one);
    }

    VisibilityBuffer device_visibility(const DeviceProfile& profile, const RunOptions& options) const {
        VisibilityBuffer seen;
        draw_device_visibility(scene_.geometry, &scene_.surfaces, scene_.clip_positions, data_.reversed_z, data_.size,
                               profile, options, seen);
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

    const StageBinding& binding_;
    const StageData& data_;
    const BoundScene scene_;
    const Pass pass_;
};

}  // namespace plumb::raster
