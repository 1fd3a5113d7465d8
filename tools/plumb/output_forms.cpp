#include "tools/plumb/output_forms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "core/bounded.h"
#include "core/error.h"
#include "core/inexact_inputs.h"
#include "core/packet_outcomes.h"
#include "gi/parity/stages.h"
#include "gi/rsm/sampled.h"
#include "io/file.h"
#include "tools/plumb/input_forms.h"
#include "tools/plumb/slot_array.h"

namespace plumb::cli {

namespace {

// What is done with one output.
struct OutputForm {
    const Slot* slot = nullptr;
    int first = 0;  // of its channels among all components of all outputs
    std::array<float, 3> scale = {1, 1, 1};
    const float* factor = nullptr;  // [height][width][4], or none
    const float* moved = nullptr;   // how far a device's own may be from it, or exact
    std::optional<std::array<float, 2>> clamp;

    int colours() const { return std::min(slot->channels, 3); }
    Bounded written(Bounded v, std::size_t pixel, int c) const {
        if (scale[std::size_t(c)] != 1.0f) v = v * Bounded(scale[std::size_t(c)]);
        if (factor) {
            const std::size_t at = 4 * pixel + std::size_t(c);
            v = v * (moved ? Bounded::within(factor[at], factor[at], moved[at]) : Bounded(factor[at]));
        }
        return clamp ? min(max(v, Bounded((*clamp)[0])), Bounded((*clamp)[1])) : v;
    }
    float written(float v, std::size_t pixel, int c) const {
        v *= scale[std::size_t(c)];
        if (factor) v *= factor[4 * pixel + std::size_t(c)];
        return clamp ? std::min(std::max(v, (*clamp)[0]), (*clamp)[1]) : v;
    }
};

const float* numbers_of(const StageData& data, const std::string& name, std::size_t count) {
    const Array* array = find(data.inputs, name);
    if (!array) return nullptr;
    if (array->dtype != DType::f32 || array->bytes.size() != count * sizeof(float))
        throw InputError(fmt::format("{}: input \"{}\": expected {} numbers", data.label, name, count));
    return reinterpret_cast<const float*>(array->bytes.data());
}

// The stage that is bound within.
const StageBinding& within(const StageData& data) {
    const StageBinding* sampled = find(data.inputs, "sampling") ? rsm::sampled_stage(data.stage) : nullptr;
    return sampled ? *sampled : parity::find_binding(data.stage, data.label);
}

// A stage whose shader goes on with its result.
class FormedStage final : public BoundStage, public PacketOutcomes {
  public:
    explicit FormedStage(const StageData& data)
        : data_(data), binding_(within(data)), stage_(binding_.bind(data)), packets_(dynamic_cast<const PacketOutcomes*>(stage_.get())) {
        const std::size_t texels = 4 * std::size_t(data.size.x) * std::size_t(data.size.y);
        int first = 0;
        for (const Slot& slot : binding_.outputs) {
            OutputForm form{&slot, first};
            first += slot.channels;
            if (const float* scale = numbers_of(data, slot.name + ".scale", 3)) std::copy_n(scale, 3, form.scale.begin());
            form.factor = numbers_of(data, slot.name + ".factor", texels);
            form.moved = numbers_of(data, moved_name(slot.name + ".factor"), texels);
            if (const float* clamp = numbers_of(data, slot.name + ".clamp", 2)) form.clamp = {clamp[0], clamp[1]};
            forms_.push_back(form);
        }
    }

    // What is not computed stays as it is.
    void run(const RunOptions& options, const DeviceProfile& profile, Bundle& outputs) const override {
        Bundle made = make_outputs(binding_, data_);
        stage_->run(options, profile, made);
        const bool kept = outputs.arrays.size() == made.arrays.size() &&
                          std::equal(made.arrays.begin(), made.arrays.end(), outputs.arrays.begin(), [](const Array& a, const Array& b) {
                              return a.name == b.name && a.dtype == b.dtype && a.shape == b.shape;
                          });
        if (!kept) outputs = make_outputs(binding_, data_);
        for (std::size_t i = 0; i < forms_.size(); ++i) write(forms_[i], made.arrays[i], outputs.arrays[i]);
    }

    bool writes(glm::ivec2 pixel) const override { return stage_->writes(pixel); }

    void outcomes(glm::ivec2 pixel, const DeviceProfile& profile, std::span<const float> got,
                  std::span<const std::int32_t> choices, std::vector<Outcome>& out) const override {
        stage_->outcomes(pixel, profile, got, choices, out);
        form(pixel, profile, out);
    }

    void outcomes(std::span<const glm::ivec2> pixels, const DeviceProfile& profile, Isa isa,
                  std::vector<Outcome>* out) const override {
        if (packets_) packets_->outcomes(pixels, profile, isa, out);
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            if (!packets_) stage_->outcomes(pixels[i], profile, {}, {}, out[i]);
            form(pixels[i], profile, out[i]);
        }
    }

    void follow(glm::ivec2, DecisionTape&, std::vector<Followed>&) const override {
        throw std::logic_error("a stage whose output is formed has no double");
    }

    std::vector<TapValue> explain(glm::ivec2 pixel, const DeviceProfile& profile) const override {
        std::vector<TapValue> values = stage_->explain(pixel, profile);
        std::vector<Outcome> out;
        outcomes(pixel, profile, {}, {}, out);
        for (const OutputForm& form : forms_) {
            if (out.empty() || !is_any(form)) continue;
            TapValue written{"written", -1, {}, form.slot->name + " with the manifest's scale, factor and clamp"};
            for (int c = 0; c < form.colours(); ++c) written.value.push_back(out[0].values[std::size_t(form.first + c)].shadow);
            values.push_back(std::move(written));
        }
        return values;
    }

  private:
    static bool is_any(const OutputForm& form) { return form.factor || form.clamp || form.scale != std::array<float, 3>{1, 1, 1}; }

    void write(const OutputForm& form, const Array& from, Array& to) const {
        const std::size_t channels = std::size_t(form.slot->channels), texel = channels * sizeof(float);
        for (int y = 0; y < data_.size.y; ++y) {
            const std::uint8_t* wanted = data_.tiles.row(y);
            for (int x = 0; x < data_.size.x; ++x) {
                if (wanted && !wanted[x >> 4]) continue;
                const std::size_t pixel = std::size_t(y) * std::size_t(data_.size.x) + std::size_t(x);
                std::memcpy(to.bytes.data() + pixel * texel, from.bytes.data() + pixel * texel, texel);
                if (!is_any(form) || !stage_->writes({x, y})) continue;
                auto* v = reinterpret_cast<float*>(to.bytes.data()) + pixel * channels;
                for (int c = 0; c < form.colours(); ++c) v[c] = form.written(v[c], pixel, c);
            }
        }
    }

    void form(glm::ivec2 at, const DeviceProfile& profile, std::vector<Outcome>& out) const {
        const PrecisionScope scope(profile.precision);
        const std::size_t pixel = std::size_t(at.y) * std::size_t(data_.size.x) + std::size_t(at.x);
        for (Outcome& outcome : out)
            for (const OutputForm& form : forms_)
                for (int c = 0; c < form.colours() && is_any(form); ++c) {
                    BoundedValue& v = outcome.values[std::size_t(form.first + c)];
                    const Bounded written = form.written(Bounded::within(float(v.shadow), v.shadow, v.bound), pixel, c);
                    v = {written.shadow, written.bound};
                }
    }

    const StageData& data_;
    const StageBinding& binding_;
    std::unique_ptr<BoundStage> stage_;
    const PacketOutcomes* packets_;
    std::vector<OutputForm> forms_;
};

// Factors of one output, multiplied: the product's own rounding is in what it may be off.
void add_factors(const Slot& output, const io::DumpSpec& spec, const Precision& precision, const std::string& place, StageData& data) {
    const Slot slot{.name = output.name + ".factor"};
    Bundle made;
    Array& factor = add(made, slot.name, DType::f32, {data.size.y, data.size.x, 4});
    auto* to = reinterpret_cast<float*>(factor.bytes.data());
    const std::size_t texels = factor.bytes.size() / sizeof(float);
    std::vector<Bounded> product(texels, Bounded(1.0f));
    const PrecisionScope scope(precision);
    for (const io::DumpSpec& one : spec.factors) {
        io::DumpedImage image = io::read_dump(one);
        if (image.array.dtype != DType::f32 || image.array.shape != factor.shape)
            throw InputError(fmt::format("{}: factor: {} is {}: expected an image of {} x {} floats", place, io::shown(one.file.string()),
                                         shape_text(image.array.shape), data.size.x, data.size.y));
        std::vector<std::string> notes;
        const Array moved = form_input(one, slot, precision, {}, place, image, notes);
        const auto* from = reinterpret_cast<const float*>(image.array.bytes.data());
        const auto* off = moved.bytes.empty() ? nullptr : reinterpret_cast<const float*>(moved.bytes.data());
        const bool alone = (image.channels & 7u) == 1;  // one channel multiplies all three
        for (std::size_t i = 0; i < texels; ++i) {
            const std::size_t at = alone && i % 4 < 3 ? i / 4 * 4 : i;
            product[i] = product[i] * Bounded::within(from[at], from[at], off ? off[at] : 0);
        }
    }
    Array& moved = add(made, moved_name(slot.name), DType::f32, {data.size.y, data.size.x, 4});
    to = reinterpret_cast<float*>(made.arrays[0].bytes.data());
    auto* bounds = reinterpret_cast<float*>(moved.bytes.data());
    for (std::size_t i = 0; i < texels; ++i) {
        to[i] = float(product[i].shadow);
        bounds[i] = float((product[i].bound + std::fabs(double(to[i]) - product[i].shadow)) * (1 + 0x1p-20));
    }
    for (Array& array : made.arrays) replace(data.inputs, std::move(array));
}

// The same binding with the inputs that its outputs ask for.
const StageBinding& formed(const StageBinding& binding, const std::vector<std::string>& factors) {
    static std::mutex mutex;
    static std::map<std::string, std::unique_ptr<StageBinding>> all;
    const std::string key = fmt::format("{}/{}/{}", binding.info.name, rsm::is_sampled(binding), fmt::join(factors, ","));
    const std::scoped_lock lock(mutex);
    std::unique_ptr<StageBinding>& made = all[key];
    if (made) return *made;
    made = std::make_unique<StageBinding>(binding);
    for (const std::string& name : factors)
        made->inputs.push_back({.name = name, .meaning = "by which the shader multiplies its result before it writes it"});
    made->bind = [](const StageData& data) -> std::unique_ptr<BoundStage> { return std::make_unique<FormedStage>(data); };
    return *made;
}

}  // namespace

const StageBinding& formed_binding(const io::ManifestStage& stage, const StageBinding& binding, const Precision& precision,
                                   StageData& data) {
    std::vector<std::string> factors;
    bool any = false;
    for (const auto& [name, spec] : stage.outputs) {
        if (spec.scale.empty() && spec.factors.empty() && spec.clamp.empty()) continue;
        const std::string place = fmt::format("{}: output.{}", stage.place, name);
        const auto slot = std::find_if(binding.outputs.begin(), binding.outputs.end(), [&, &named = name](const Slot& s) { return s.name == named; });
        if (slot == binding.outputs.end()) continue;  // it is said where outputs are read
        if (binding.raster || slot->dtype != DType::f32 || slot->kind != SlotKind::storage_image)
            throw InputError(place + ": scale, factor and clamp are of images of floats that a stage computes");
        any = true;
        Bundle made;
        if (!spec.scale.empty()) {
            std::array<float, 3> scale;
            for (std::size_t c = 0; c < 3; ++c) scale[c] = float(spec.scale[spec.scale.size() == 1 ? 0 : c]);
            add(made, name + ".scale", {3}, scale.data());
        }
        if (!spec.clamp.empty()) {
            const std::array<float, 2> clamp = {float(spec.clamp[0]), float(spec.clamp[1])};
            add(made, name + ".clamp", {2}, clamp.data());
        }
        for (Array& array : made.arrays) replace(data.inputs, std::move(array));
        if (spec.factors.empty()) continue;
        add_factors(*slot, spec, precision, place, data);
        factors.push_back(name + ".factor");
    }
    return any ? formed(binding, factors) : binding;
}

bool is_formed(const StageBinding& binding) {
    const StageBinding& plain = parity::find_binding(binding.info.name, binding.info.name);
    return binding.bind != plain.bind && !rsm::is_sampled(binding);
}

}  // namespace plumb::cli
