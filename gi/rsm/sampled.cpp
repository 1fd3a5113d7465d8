#include "gi/rsm/sampled.h"

#include "core/kernel_stage.h"
#include "gi/rsm/descriptions.h"
#include "gi/rsm/sampled_kernel.h"

namespace plumb {

using namespace rsm;

template <bool continuous>
inline constexpr bool by_packets<SampledDisc<continuous>> = false;

// A pixel at a time, whatever the instruction set: nobody waits for it in a frame.
template <bool continuous, Isa isa>
struct Rows<SampledDisc<continuous>, isa> {
    static void run(const SampledView& in, int first, int last, const Tiles& tiles, float*) {
        NoTap tap;
        for (int y = first; y < last; ++y)
            for (int x = 0; x < in.u.width; ++x) {
                const std::uint8_t* row = tiles.row(y);
                if (row && !row[x >> 4]) continue;
                const vec4<float> e = SampledDisc<continuous>::template item<float>(in, x, y, tap);
                number<float>::store4(in.irradiance, y * in.u.width + x, e, true);
            }
    }
};

namespace rsm {

namespace {

// Before it is bound: what the numbers of a Sampling may be.
void check_sampling(const StageData& data) {
    const Array* array = find(data.inputs, "sampling");
    if (!array || array->dtype != DType::f32 || array->bytes.size() != sizeof(Sampling))
        throw InputError(fmt::format("{}: input \"sampling\": expected {} numbers", data.label, sampling_floats));
    Sampling s;
    std::memcpy(&s, array->bytes.data(), sizeof s);
    for (const MapSampler* one : {&s.position, &s.normal, &s.flux})
        if (!(one->linear == 0 || one->linear == 1) || !(one->address == 0 || one->address == 1 || one->address == 2))
            throw InputError(data.label + ": input \"sampling\": expected filters of 0 or 1 and addresses of 0 to 2");
    for (const float flag : {s.unit_normal, s.skips_beyond})
        if (!(flag == 0 || flag == 1)) throw InputError(data.label + ": input \"sampling\": expected flags of 0 or 1");
    if (data.uniforms.size() < sizeof(GatherUniforms)) return;  // the stage says so itself
    const auto u = uniforms_of<GatherUniforms>(data);
    const auto whole = [](float v) { return v >= 1 && v <= 256 && v == float(int(v)); };
    const bool tiled = whole(s.tile_width) && whole(s.tile_height) && s.tile_width * s.tile_height == float(u.rotations);
    const bool hashed = s.tile_width == 0 && s.tile_height == 0 && is_power_of_two(u.rotations);
    if (u.samples < 0 || !(tiled || hashed))
        throw InputError(fmt::format("{}: samples = {}, rotations = {}: expected 0 or more, and as many as a tile of {} x {} "
                                     "has pixels", data.label, u.samples, u.rotations, s.tile_width, s.tile_height));
}

template <bool continuous>
StageDescription<SampledView> describe(SampledDisc<continuous>) {
    const auto entries = [](const SampledView& v) { return std::size_t(v.u.samples) * std::size_t(v.u.rotations); };
    const StageInfo& disc = stage<DiscKernel<continuous>>().info;
    auto d = describe_pattern<continuous, SampledView>(disc.name.c_str(), disc.source.c_str(), Gather::disc, entries,
                                                       "[samples][rotations]");
    d.lends.clear(), d.prepare = nullptr;
    for (Reads<SampledView>& input : d.inputs) input.instead.clear();
    d.inputs.push_back({.name = "weights", .at = &SampledView::weights, .unit = "texels",
                        .meaning = "[samples], or of a tile [samples][rotations]: texels that a sample stands for",
                        .count = [](const SampledView& v) {
                            return std::size_t(v.u.samples) * std::size_t(sampling_of(v).tile_width > 0 ? v.u.rotations : 1);
                        },
                        .why = "one for each sample"});
    // Before all others, which ask it how many there are.
    d.inputs.insert(d.inputs.begin(), {.name = "sampling", .at = &SampledView::sampling,
                                       .meaning = "samplers of the map's images, and the tile of pixels that repeats",
                                       .count = [](const SampledView&) { return sampling_floats; }, .why = "a Sampling"});
    return d;
}

template <bool continuous>
const StageBinding& bound_sampled() {
    static const StageDescription<SampledView> description = describe(SampledDisc<continuous>{});
    static const StageBinding binding = [] {
        StageBinding b = stage<DiscKernel<continuous>>();
        for (Slot& slot : b.inputs) slot.instead.clear();
        b.inputs.insert(b.inputs.begin(), Slot{.name = "sampling", .kind = SlotKind::buffer, .channels = 1, .frame = false, .fixed = 1});
        b.bind = [](const StageData& data) -> std::unique_ptr<BoundStage> {
            check_sampling(data);
            return std::make_unique<KernelStage<SampledDisc<continuous>>>(bound_sampled<continuous>(), description, data);
        };
        return b;
    }();
    return binding;
}

}  // namespace

const StageBinding* sampled_stage(const std::string& name) {
    for (const auto bound : {bound_sampled<false>, bound_sampled<true>})
        if (bound().info.name == name) return &bound();
    return nullptr;
}

std::vector<SamplingGuess> sampling_guesses() {
    std::vector<SamplingGuess> all;
    const auto add = [&](const std::string& text, std::function<void(Sampling&)> change) {
        all.push_back({text, [change](StageData& data) {
                           for (Array& array : data.inputs.arrays) {
                               if (array.name != "sampling" || array.bytes.size() != sizeof(Sampling)) continue;
                               Sampling s;
                               std::memcpy(&s, array.bytes.data(), sizeof s);
                               change(s);
                               if (std::memcmp(&s, array.bytes.data(), sizeof s) == 0) return false;
                               std::memcpy(array.bytes.data(), &s, sizeof s);
                               return true;
                           }
                           return false;
                       }});
    };
    const auto of_all = [](Sampling& s, auto change) { change(s.position), change(s.normal), change(s.flux); };
    add("rsm_position not moved along its normal", [](Sampling& s) { s.along_normal = 0; });
    add("rsm_position moved along its normal the other way", [](Sampling& s) { s.along_normal = -s.along_normal; });
    add("rsm_normal not made unit once it is filtered", [](Sampling& s) { s.unit_normal = 0; });
    add("rsm_normal made unit once it is filtered", [](Sampling& s) { s.unit_normal = 1; });
    add("samples beyond the map not skipped", [](Sampling& s) { s.skips_beyond = 0; });
    add("samples beyond the map skipped", [](Sampling& s) { s.skips_beyond = 1; });
    add("the map read at the nearest texel", [=](Sampling& s) { of_all(s, [](MapSampler& m) { m.linear = 0; }); });
    add("rsm_position read at the nearest texel", [](Sampling& s) { s.position.linear = 0; });
    add("rsm_normal read at the nearest texel", [](Sampling& s) { s.normal.linear = 0; });
    add("rsm_flux read at the nearest texel", [](Sampling& s) { s.flux.linear = 0; });
    constexpr const char* beyond[] = {"beyond the map its border's colour", "beyond the map its edge", "beyond the map the map again"};
    for (int address = 0; address < 3; ++address)
        add(beyond[address], [=](Sampling& s) { of_all(s, [=](MapSampler& m) { m.address = float(address); }); });
    return all;
}

bool is_sampled(const StageBinding& binding) { return !binding.inputs.empty() && binding.inputs.front().name == "sampling"; }

std::vector<std::string> sampled_stages() { return {bound_sampled<false>().info.name, bound_sampled<true>().info.name}; }

}  // namespace rsm
}  // namespace plumb
