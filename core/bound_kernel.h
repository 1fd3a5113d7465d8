// A BoundStage made of a kernel that computes one pixel: what every compute stage is.
//
// Kernel is a small struct made from StageData that offers
//
//     static constexpr int components                                   of its one output
//     std::array<F, components> pixel<F>(int x, int y, Tap& tap) const  F: float, Bounded, Followed
//     void rows<isa>(float* out, int first, int last) const             the same for rows, in packets
//     bool writes(glm::ivec2 pixel) const
//     bool surely_writes(glm::ivec2 pixel) const                        optional: no legal device leaves the pixel
#pragma once

#include <array>
#include <vector>

#include "core/binding.h"
#include "core/bounded.h"
#include "core/fp_environment.h"
#include "core/outcomes.h"
#include "core/parallel.h"

namespace plumb {

template <class Kernel>
class BoundKernel final : public BoundStage {
    static constexpr int components = Kernel::components;

  public:
    BoundKernel(const StageBinding& binding, const StageData& data) : binding_(binding), data_(data), kernel_(data) {}

    void run(const RunOptions& options, const DeviceProfile&, Bundle& outputs) const override {
        if (!fits(outputs)) outputs = make_outputs(binding_, data_);
        float* out = reinterpret_cast<float*>(outputs.arrays[0].bytes.data());
        dispatch(options.isa, [&](auto isa) {
            parallel_bands(data_.size.y, 4, options,
                           [&](int first, int last) { kernel_.template rows<isa()>(out, first, last); });
        });
    }

    bool writes(glm::ivec2 pixel) const override { return kernel_.writes(pixel); }

    void outcomes(glm::ivec2 pixel, const DeviceProfile& profile, std::span<const float>,
                  std::span<const std::int32_t> choices, std::vector<Outcome>& out) const override {
        const PrecisionScope precision(profile.precision);
        auto one = [&](std::vector<Bounded>& values) {
            NoTap tap;
            const std::array<Bounded, components> v = kernel_.template pixel<Bounded>(pixel.x, pixel.y, tap);
            values.insert(values.end(), v.begin(), v.end());
        };
        enumerate_outcomes(one, most_outcomes, out, choices);
        // What a device left there that does not write the pixel could be anything.
        if constexpr (requires { kernel_.surely_writes(pixel); }) {
            if (kernel_.surely_writes(pixel)) return;
            out.push_back({std::vector<BoundedValue>(components, {0, __builtin_inf()}), true});
        }
    }

    void follow(glm::ivec2 pixel, DecisionTape& tape, std::vector<Followed>& out) const override {
        FpEnvironment environment;
        const FollowScope scope(tape);
        NoTap tap;
        const std::array<Followed, components> v = kernel_.template pixel<Followed>(pixel.x, pixel.y, tap);
        out.assign(v.begin(), v.end());
    }

    std::vector<TapValue> explain(glm::ivec2 pixel, const DeviceProfile&) const override {
        FpEnvironment environment;
        Recorder recorder;
        kernel_.template pixel<float>(pixel.x, pixel.y, recorder);
        return recorder.values;
    }

  private:
    bool fits(const Bundle& outputs) const {
        const Shape& s = outputs.arrays.empty() ? Shape{} : outputs.arrays[0].shape;
        return outputs.arrays.size() == 1 && outputs.arrays[0].name == binding_.outputs[0].name &&
               outputs.arrays[0].dtype == DType::f32 && s.size() == (components == 1 ? 2u : 3u) &&
               s[0] == data_.size.y && s[1] == data_.size.x && (components == 1 || s[2] == components);
    }

    const StageBinding& binding_;
    const StageData& data_;
    Kernel kernel_;
};

}  // namespace plumb
