#include "tools/mutants/on_device.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "core/error.h"
#include "tools/mutants/edit.h"

namespace plumb::mutants {
namespace {

// More than any panel's invocation takes; what takes more is a loop that a change made endless.
constexpr std::uint32_t most_turns = 16384;

}  // namespace

std::vector<std::uint32_t> runnable(std::span<const std::uint32_t> spirv) {
    return words_of(guarded(parse_spirv(spirv), most_turns));
}

// A dispatch, and what the twin as it is writes there.
struct OnDevice::Held {
    const StageBinding& binding;
    const Dispatch& dispatch;
    vulkan::PreparedTwin twin;
    Bundle own = {};
    double most_ambiguous = parity::JudgeOptions{}.max_ambiguous;  // share of pixels, all or those that are not 0: what the twin itself has, if more
    bool is_set = true;  // to the shaders in use
};

OnDevice::OnDevice(const vulkan::Device& device, const std::vector<Dispatch>& dispatches, const DeviceProfile& profile)
    : device_(device), dispatches_(dispatches), profile_(profile) {}
OnDevice::~OnDevice() = default;
OnDevice::OnDevice(OnDevice&&) noexcept = default;

const Dispatch& OnDevice::dispatch(std::size_t i) const { return held_[i]->dispatch; }

void OnDevice::hold(const StageBinding& binding, const Shaders& twin) {
    held_.clear();
    stage_ = binding.info.name;
    shaders_ = twin;
    for (const Dispatch& d : dispatches_) {
        if (d.data.stage != stage_) continue;
        held_.push_back(std::make_unique<Held>(
            Held{binding, d, {device_, binding, d.data, {.spirv = twin.spirv, .vertex_spirv = twin.vertex}}}));
        if (held_.size() > 1) adopt(*held_.back(), twin);
        const std::size_t i = held_.size() - 1;
        held_[i]->own = run(i);
        const parity::StageVerdict verdict = judge(i, held_[i]->own, false);
        if (verdict.count[int(parity::Verdict::wrong)] > 0) {
            std::fprintf(stderr, "left out: %s: %s\n", d.name.c_str(), verdict.reason.c_str());
            held_.pop_back();
            continue;
        }
        const auto share = [](const auto& count, std::int64_t pixels) {
            return double(count[int(parity::Verdict::ambiguous)]) / double(std::max<std::int64_t>(pixels, 1));
        };
        const double ambiguous =
            std::max(share(verdict.count, verdict.pixels), share(verdict.nonzero_count, verdict.nonzero));
        held_[i]->most_ambiguous = std::max(held_[i]->most_ambiguous, 1.1 * ambiguous);
    }
    if (held_.empty()) throw InputError(stage_ + ": no dispatch of this stage");
}

// The first dispatch compiles; those with the same depth test take its pipeline.
void OnDevice::adopt(Held& held, const Shaders& shaders) {
    if (&held != held_[0].get() && held.dispatch.data.reversed_z == held_[0]->dispatch.data.reversed_z)
        held.twin.use(held_[0]->twin);
    else
        held.twin.use(shaders.spirv, shaders.vertex);
    held.is_set = true;
}

void OnDevice::use(const Shaders& shaders) {
    shaders_ = shaders;
    for (auto& held : held_) held->is_set = false;
    adopt(*held_[0], shaders_);
}

Bundle OnDevice::run(std::size_t i) {
    if (!held_[i]->is_set) adopt(*held_[i], shaders_);
    held_[i]->twin.submit();
    return held_[i]->twin.read().outputs;
}

bool OnDevice::is_as_the_twin(std::size_t i, const Bundle& outputs) const {
    const Bundle& own = held_[i]->own;
    return std::equal(outputs.arrays.begin(), outputs.arrays.end(), own.arrays.begin(), own.arrays.end(),
                      [](const Array& a, const Array& b) {
                          return a.bytes.size() == b.bytes.size() &&
                                 std::memcmp(a.bytes.data(), b.bytes.data(), a.bytes.size()) == 0;
                      });
}

parity::StageVerdict OnDevice::judge(std::size_t i, const Bundle& outputs, bool until_wrong) const {
    std::vector<parity::Dumped> dumped;
    for (const Array& array : outputs.arrays) dumped.push_back({array.name, array});
    parity::JudgeOptions options;
    options.profile = profile_;
    options.max_ambiguous = held_[i]->most_ambiguous;
    options.run.threads = 1;
    options.until_wrong = until_wrong;
    return parity::judge(held_[i]->binding, held_[i]->dispatch.data, dumped, options);
}

void OnDevice::put_first(std::size_t i) {
    std::rotate(held_.begin(), held_.begin() + std::ptrdiff_t(i), held_.begin() + std::ptrdiff_t(i) + 1);
}

}  // namespace plumb::mutants
