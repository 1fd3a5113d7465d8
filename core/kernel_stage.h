// A stage made of its kernel, its description and its twin's layout: KernelStage<Kernel> is what every compute stage is
// bound as. Only a folder's stages.cpp includes it, a line a stage; and raster/bindings.cpp, whose passes draw, and have a
// NamedStage.
//
//     template <>
//     const StageBinding& plumb::stage<isr::Bounce>() { return made<isr::Bounce, twins::gi_isr_bounce_comp>(); }
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "core/binding.h"
#include "core/bounded.h"
#include "core/bounded_packet.h"
#include "core/error.h"
#include "core/fp_environment.h"
#include "core/inexact_inputs.h"
#include "core/kernel_rows.h"
#include "core/outcomes.h"
#include "core/packet_outcomes.h"
#include "core/parallel.h"
#include "core/stage_description.h"
#include "core/twin_layout.h"

namespace plumb {

// A description without its View: the names, and what they mean.
struct NamedSlot {
    std::string name, unit = {}, meaning = {};
    std::uint32_t fixed = 0;
    int channels = 4;  // of a sampled image
    bool frame = true;
    glm::vec4 unwritten{0};
    bool optional = false;
    std::string instead = {};
};
struct NamedStage {
    std::string name, source, domain;
    std::vector<NamedSlot> inputs, outputs;  // of a raster stage the depth buffer, too: "depth", the last output
    std::vector<ParamInfo> params = {};
    std::vector<std::pair<std::string, std::uint32_t>> fixed_uniforms = {};
    Budget budget = {};
    Cost cost = {};
};

// The slots and members of a stage, from what it says and what its twin says. Throws std::logic_error where they
// differ: an input that the twin does not bind, a binding that no input stands for.
StageBinding binding_of(const NamedStage& stage, const TwinLayout& twin);

template <class View>
StageBinding binding_of(const StageDescription<View>& d, const TwinLayout& twin) {
    NamedStage s{d.name, d.source, d.domain, {}, {}, d.params, d.fixed_uniforms, d.budget, d.cost};
    for (const Reads<View>& r : d.inputs)
        s.inputs.push_back({.name = r.name, .unit = r.unit, .meaning = r.meaning, .fixed = r.fixed,
                            .channels = r.channels, .frame = !r.size && !r.read, .optional = r.optional,
                            .instead = r.instead});
    for (const Writes<View>& w : d.outputs)
        s.outputs.push_back({.name = w.name, .unit = w.unit, .meaning = w.meaning, .fixed = w.fixed,
                             .unwritten = w.unwritten});
    return binding_of(s, twin);
}

// Throws InputError for a member of the block that is out of range, for an image of another size than `size` (as `why`
// says), or a buffer of fewer elements than `count`.
void check_uniforms(const StageBinding& binding, const StageData& data, const std::vector<Within>& ranges);
void check_size(const StageData& data, const std::string& input, glm::ivec2 size, const std::string& why);
void check_count(const StageData& data, const Slot& slot, std::size_t count, const std::string& why);

// Whether the data holds something of that name and type. Throws InputError for what is there but has fewer than `count`
// numbers.
bool is_lent(const StageData& data, const std::string& name, DType dtype);
void check_lent(const StageData& data, const std::string& name, std::size_t count, const std::string& why);

// All components of a value, in order.
template <class F, class Each>
void each_component(const F& value, Each each) {
    each(value);
}
template <class F, class Each>
void each_component(const vec4<F>& v, Each each) {
    each(v.x), each(v.y), each(v.z), each(v.w);
}
template <class Value, class Each>
    requires requires(const Value& v) { v.components([](const auto&) {}); }
void each_component(const Value& v, Each each) {
    v.components(each);
}

// Whether Kernel::item() is written for lanes that go different ways. Of a stage whose loop over packets is its own it may
// be for one lane alone; its stages.cpp says so.
template <class Kernel>
inline constexpr bool by_packets = true;

template <class Kernel>
class KernelStage final : public BoundStage, public PacketOutcomes {
    using View = typename Kernel::View;

  public:
    KernelStage(const StageBinding& binding, const StageDescription<View>& description, const StageData& data)
        : binding_(binding), description_(description), data_(data) {
        check_slots(binding, data);
        check_uniforms(binding, data, description.uniforms);
        view_.u = uniforms_of<decltype(view_.u)>(data);
        if constexpr (requires { frame_of<Kernel>(view_).width, frame_of<Kernel>(view_).height; }) {
            // Whatever the block says, the kernel walks the outputs.
            auto& frame = frame_of<Kernel>(view_);
            frame.width = data.size.x, frame.height = data.size.y;
        }
        if (description.refuses)
            if (const std::string cause = description.refuses(view_, data.size); !cause.empty())
                throw InputError(data.label + ": " + cause);
        for (std::size_t i = 0; i < description.inputs.size(); ++i) bind(description.inputs[i], binding.inputs[i]);
        for (const Lends<View>& lent : description.lends)
            if (is_lent(data, lent.name, lent.dtype)) bind(lent);
        const View read = view_;
        if (description.prepare) description.prepare(view_, own_);
        bind_inexact(read);
    }

    void run(const RunOptions& options, const DeviceProfile&, Bundle& outputs) const override {
        if (!fits(outputs)) outputs = make_outputs(binding_, data_);
        View view = view_;
        for (std::size_t i = 0; i < outputs.arrays.size(); ++i)
            description_.outputs[i].at.set(view, outputs.arrays[i].bytes.data());
        const Buffer<float> shared = make_shared_rows(view, options);
        const int band = std::min(band_of(), data_.size.y);
        ScratchPool scratch(floats_of(view, band));
        dispatch(options.isa, [&](auto isa) {
            parallel_bands(data_.size.y, band, options, [&](int first, int last) {
                Buffer<float> own = scratch.take();
                Rows<Kernel, isa()>::run(view, first, last, data_.tiles, own.data());
                scratch.give(std::move(own));
            });
        });
    }

    bool writes(glm::ivec2 pixel) const override {
        if constexpr (masked) return Kernel::template writes<float>(view_, pixel.x, pixel.y);
        return true;
    }

    void outcomes(glm::ivec2 pixel, const DeviceProfile& profile, std::span<const float>,
                  std::span<const std::int32_t> choices, std::vector<Outcome>& out) const override {
        const PrecisionScope precision(profile.precision);
        const InexactScope inexact(inexact_);
        enumerate(pixel, choices, out);
    }

    void outcomes(std::span<const glm::ivec2> pixels, const DeviceProfile& profile, Isa isa,
                  std::vector<Outcome>* out) const override {
        const PrecisionScope precision(profile.precision);
        const InexactScope inexact(inexact_);
        const std::uint32_t left = packet(pixels, isa, out);
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            if (left >> i & 1)
                enumerate(pixels[i], {}, out[i]);
            else
                add_unwritten(pixels[i], out[i]);
        }
    }

    void follow(glm::ivec2 pixel, DecisionTape& tape, std::vector<Followed>& out) const override {
        FpEnvironment environment;
        const FollowScope scope(tape);
        out.clear();
        append<Followed>(pixel, out);
        drop_integers(out);
    }

    void in_double(glm::ivec2 pixel, std::vector<double>& out) const override { append<double>(pixel, out); }

    std::vector<TapValue> explain(glm::ivec2 pixel, const DeviceProfile&) const override {
        FpEnvironment environment;
        Recorder recorder;
        Kernel::template item<float>(view_, pixel.x, pixel.y, recorder);
        return recorder.values;
    }

  private:
    static constexpr bool masked = requires(const View& v) { Kernel::template writes<float>(v, 0, 0); };

    // Memory that bands take and give back, so that a thread touches its own again.
    class ScratchPool {
      public:
        explicit ScratchPool(std::size_t floats) : floats_(floats) {}
        Buffer<float> take() {
            const std::lock_guard lock(mutex_);
            if (free_.empty()) return Buffer<float>(floats_);
            Buffer<float> one = std::move(free_.back());
            free_.pop_back();
            return one;
        }
        void give(Buffer<float> one) {
            const std::lock_guard lock(mutex_);
            free_.push_back(std::move(one));
        }

      private:
        std::size_t floats_;
        std::mutex mutex_;
        std::vector<Buffer<float>> free_;
    };

    // What the bands share; the view is shown where it is.
    static Buffer<float> make_shared_rows(View& view, const RunOptions& options) {
        Buffer<float> shared;
        if constexpr (requires { Kernel::shared_floats(view); }) {
            shared = Buffer<float>(Kernel::shared_floats(view));
            view.shared = shared.data();
            if (!shared.empty())
                dispatch(options.isa, [&](auto isa) {
                    parallel_bands(Kernel::shared_rows(view), 16, options, [&](int first, int last) {
                        SharedRows<Kernel, isa()>::run(view, first, last, shared.data());
                    });
                });
        }
        return shared;
    }

    static int band_of() {
        if constexpr (requires { Kernel::band; }) return Kernel::band;
        return 16;
    }
    static std::size_t floats_of(const View& view, int rows) {
        if constexpr (requires { Kernel::scratch(view, rows); }) return Kernel::scratch(view, rows);
        return 0;
    }

    void bind(const Reads<View>& input, const Slot& slot) {
        if (!find(data_.inputs, slot.name)) return check_missing(slot);
        if (slot.kind == SlotKind::buffer || slot.kind == SlotKind::image_array) {
            if (input.count) check_count(data_, slot, input.count(view_), input.why);
        } else if (input.read && !input.read(view_)) {
            // A texel of nothing will do; what is bound may also be whole.
            if (at(data_.inputs, slot.name).shape != Shape{1, 1, slot.channels} && input.size)
                check_size(data_, slot.name, input.size(view_), input.why);
        } else if (!slot.frame) {
            check_size(data_, slot.name, input.size ? input.size(view_) : data_.size, input.why);
        }
        input.at.set(view_, at(data_.inputs, slot.name).bytes.data());
    }

    // check_slots() found it optional, or what stands in its place: that has to be of a type that the kernel reads.
    void check_missing(const Slot& slot) const {
        if (slot.optional) return;
        for (const Lends<View>& lent : description_.lends)
            if (lent.name == slot.instead && is_lent(data_, lent.name, lent.dtype)) return;
        throw InputError(fmt::format("{}: input \"{}\" is missing", data_.label, slot.name));
    }

    void bind(const Lends<View>& lent) {
        check_lent(data_, lent.name, lent.count(view_), lent.why);
        lent.at.set(view_, at(data_.inputs, lent.name).bytes.data());
    }

    // What a device makes before it reads it: in the inputs, and in the copies of them that prepare() makes of `read`.
    void bind_inexact(View read) {
        for (std::size_t i = 0; i < binding_.inputs.size(); ++i) {
            const Slot& slot = binding_.inputs[i];
            const Array *input = find(data_.inputs, slot.name), *moved = find(data_.inputs, moved_name(slot.name));
            if (input && moved) bind_inexact(*input, *moved, description_.inputs[i], read);
        }
        if (inexact_.empty() || own_.empty()) return;
        // Of what is exact no number moves.
        std::size_t most = 0;
        for (const Array& array : data_.inputs.arrays) most = std::max(most, array.bytes.size() / sizeof(float));
        const Buffer<float> nothing(most);
        for (std::size_t i = 0; i < binding_.inputs.size(); ++i) {
            const Array* input = find(data_.inputs, binding_.inputs[i].name);
            if (input && input->dtype == DType::f32 && !find(data_.inputs, moved_name(input->name)))
                description_.inputs[i].at.set(read, nothing.data());
        }
        description_.prepare(read, own_moved_);
        inexact_.push_back({own_.data(), own_moved_.data(), std::ptrdiff_t(own_.size())});
    }
    void bind_inexact(const Array& input, const Array& moved, const Reads<View>& slot, View& read) {
        if (input.dtype != DType::f32 || moved.dtype != DType::f32 || moved.shape != input.shape)
            throw std::logic_error(moved.name + ": expected numbers of the input's shape");
        inexact_.push_back({reinterpret_cast<const float*>(input.bytes.data()),
                            reinterpret_cast<const float*>(moved.bytes.data()),
                            std::ptrdiff_t(input.bytes.size() / sizeof(float))});
        slot.at.set(read, moved.bytes.data());
    }

    bool fits(const Bundle& outputs) const {
        if (outputs.arrays.size() != binding_.outputs.size()) return false;
        for (std::size_t i = 0; i < outputs.arrays.size(); ++i) {
            const Array& array = outputs.arrays[i];
            const Slot& slot = binding_.outputs[i];
            const bool list = slot.kind == SlotKind::storage_buffer;
            Shape shape = list ? Shape{std::int64_t(data_.size.x) * data_.size.y} : Shape{data_.size.y, data_.size.x};
            if (list || slot.channels > 1) shape.push_back(slot.channels);
            if (array.name != slot.name || array.dtype != slot.dtype || array.shape != shape) return false;
        }
        return true;
    }

    template <class F>
    void append(glm::ivec2 pixel, std::vector<F>& values) const {
        NoTap tap;
        each_component(Kernel::template item<F>(view_, pixel.x, pixel.y, tap),
                       [&](const auto& component) { values.push_back(F(component)); });
    }

    // Of all components of all outputs, those of outputs that hold floats.
    template <class F>
    void drop_integers(std::vector<F>& values) const {
        std::size_t kept = 0, at = 0;
        for (const Slot& slot : binding_.outputs)
            for (int c = 0; c < slot.channels; ++c, ++at)
                if (slot.dtype == DType::f32) values[kept++] = values[at];
        values.resize(kept);
    }

    void enumerate(glm::ivec2 pixel, std::span<const std::int32_t> choices, std::vector<Outcome>& out) const {
        auto one = [&](std::vector<Bounded>& values) { append<Bounded>(pixel, values); };
        enumerate_outcomes(one, most_outcomes, out, choices);
        add_unwritten(pixel, out);
    }

    // The one outcome of each pixel; of those that it returns, a bit each, it says nothing.
    std::uint32_t packet(std::span<const glm::ivec2> pixels, Isa isa, std::vector<Outcome>* out) const {
        if constexpr (by_packets<Kernel>) {
            const PacketScope scope(isa);
            PacketIndex x, y;
            for (std::size_t i = 0; i < most; ++i) {
                const glm::ivec2 pixel = pixels[std::min(i, pixels.size() - 1)];
                x.v[i] = pixel.x, y.v[i] = pixel.y;
            }
            for (std::size_t i = 0; i < pixels.size(); ++i) out[i].assign(1, Outcome{});
            NoTap tap;
            each_component(Kernel::template item<BoundedPacket>(view_, x, y, tap), [&](const auto& component) {
                const BoundedPacket values(component);
                for (std::size_t i = 0; i < pixels.size(); ++i) {
                    const Bounded one = BoundedPacket::lane(*values, int(i));
                    out[i][0].values.push_back({one.shadow, one.bound});
                }
            });
            return scope.left();
        } else {
            return PacketData::all;
        }
    }

    // What a device left there that does not write the pixel could be anything.
    void add_unwritten(glm::ivec2 pixel, std::vector<Outcome>& out) const {
        if constexpr (masked)
            if (!surely_writes(pixel))
                out.push_back({std::vector<BoundedValue>(out.at(0).values.size(), {0, __builtin_inf()}), true});
    }

    // Of an item that is written: whether every device writes it.
    bool surely_writes(glm::ivec2 pixel) const {
        Decisions decisions;
        decisions.widen = true;
        const DecisionScope scope(decisions);
        if constexpr (masked) (void)Kernel::template writes<Bounded>(view_, pixel.x, pixel.y);
        return !decisions.ambiguous;
    }

    const StageBinding& binding_;
    const StageDescription<View>& description_;
    const StageData& data_;
    Buffer<float> own_, own_moved_;
    std::vector<InexactRange> inexact_;
    View view_{};
};

template <class Kernel>
const StageDescription<typename Kernel::View>& description_of() {
    static const StageDescription<typename Kernel::View> description = describe(Kernel{});
    return description;
}

// Binds Kernel where the data lends what it reads.
template <class Kernel>
bool bind_lent(const StageBinding& binding, const StageData& data, std::unique_ptr<BoundStage>& bound) {
    const auto& description = description_of<Kernel>();
    for (const auto& lent : description.lends)
        if (!is_lent(data, lent.name, lent.dtype)) return false;
    bound = std::make_unique<KernelStage<Kernel>>(binding, description, data);
    return true;
}

// The one binding of a stage. Twin: the struct of its generated header. ForLent: the kernel for other storage, each bound
// where all that it lends is lent.
template <class Kernel, class Twin, class... ForLent>
const StageBinding& made() {
    static_assert(Twin::template fits<decltype(Kernel::View::u)>());
    static const StageBinding binding = [] {
        StageBinding b = binding_of(description_of<Kernel>(), Twin::layout);
        b.bind = [](const StageData& data) -> std::unique_ptr<BoundStage> {
            const StageBinding& self = made<Kernel, Twin, ForLent...>();
            std::unique_ptr<BoundStage> bound;
            if ((bind_lent<ForLent>(self, data, bound) || ...)) return bound;
            return std::make_unique<KernelStage<Kernel>>(self, description_of<Kernel>(), data);
        };
        return b;
    }();
    return binding;
}

}  // namespace plumb
