#include "tools/mutants/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "core/error.h"

namespace plumb::mutants {
namespace {

// More than any panel's invocation takes; what takes more is a loop that a change made endless.
constexpr std::uint32_t most_turns = 16384;

std::vector<std::uint32_t> runnable(const SpirvModule& module) { return words_of(guarded(module, most_turns)); }

bool same_bits(const Bundle& a, const Bundle& b) {
    for (std::size_t i = 0; i < a.arrays.size(); ++i)
        if (a.arrays[i].bytes.size() != b.arrays[i].bytes.size() ||
            std::memcmp(a.arrays[i].bytes.data(), b.arrays[i].bytes.data(), a.arrays[i].bytes.size()) != 0)
            return false;
    return true;
}

}  // namespace

const char* fate_name(Fate fate) {
    constexpr const char* names[] = {"found", "in_bounds", "no_effect", "same_value", "unreached"};
    return names[int(fate)];
}

// A dispatch on the device, and what the twin as it is writes there.
struct Bench::Prepared {
    const StageBinding& binding;
    const Dispatch& dispatch;
    vulkan::PreparedTwin twin;
    Bundle own;
    double most_ambiguous = parity::JudgeOptions{}.max_ambiguous;  // share of pixels: what the twin itself has, if more
};

Bench::Bench(const vulkan::Device& device, const GenericMutants& all, const std::vector<Dispatch>& dispatches,
             const DeviceProfile& profile)
    : device_(device), all_(all), dispatches_(dispatches), profile_(profile) {}
Bench::~Bench() = default;
Bench::Bench(Bench&&) noexcept = default;

std::vector<std::unique_ptr<Bench::Prepared>>& Bench::prepared(const StageBinding& binding) {
    if (stage_ == binding.info.name) return prepared_;
    prepared_.clear();
    stage_ = binding.info.name;
    const TwinShader& twin = **std::find_if(all_.shaders.begin(), all_.shaders.end(), [&](const auto& shader) {
        return shader->binding == &binding && !shader->vertex;
    });
    const std::vector<std::uint32_t> spirv = runnable(twin.module);
    for (const Dispatch& d : dispatches_) {
        if (d.data.stage != stage_) continue;
        prepared_.push_back(std::make_unique<Prepared>(Prepared{binding, d, {device_, binding, d.data, {.spirv = spirv}}, {}}));
        if (prepared_.size() > 1) use_too(*prepared_.back(), *prepared_[0], twin, spirv);
        Prepared& p = *prepared_.back();
        p.twin.submit();
        p.own = p.twin.read().outputs;
        const parity::StageVerdict verdict = judged(p, p.own);
        if (verdict.count[int(parity::Verdict::wrong)] > 0) {  // data with what is not a number
            std::fprintf(stderr, "left out: %s: %s\n", d.name.c_str(), verdict.reason.c_str());
            prepared_.pop_back();
            continue;
        }
        const double ambiguous = double(verdict.count[int(parity::Verdict::ambiguous)]);
        p.most_ambiguous = std::max(p.most_ambiguous, 1.1 * ambiguous / double(std::max<std::int64_t>(verdict.pixels, 1)));
    }
    if (prepared_.empty()) throw InputError(stage_ + ": no dispatch of this stage");
    for (const auto& shader : all_.shaders)
        if (shader->binding == &binding && shader->vertex) check_twin(*shader);
    return prepared_;
}

void Bench::use(Prepared& p, const TwinShader& shader, std::span<const std::uint32_t> spirv) {
    if (!shader.vertex) return p.twin.use(spirv);
    p.twin.use(vulkan::find_twin(shader.binding->twin + ".frag").spirv, spirv);
}

// One pipeline serves all dispatches with the same depth test.
void Bench::use_too(Prepared& p, const Prepared& first, const TwinShader& shader, std::span<const std::uint32_t> spirv) {
    if (p.dispatch.data.reversed_z == first.dispatch.data.reversed_z)
        p.twin.use(first.twin);
    else
        use(p, shader, spirv);
}

parity::StageVerdict Bench::judged(const Prepared& p, const Bundle& outputs) const {
    std::vector<parity::Dumped> dumped;
    for (const Array& array : outputs.arrays) dumped.push_back({array.name, array});
    parity::JudgeOptions options;
    options.profile = profile_;
    options.max_ambiguous = p.most_ambiguous;
    options.run.threads = 1;
    options.until_wrong = true;
    return parity::judge(p.binding, p.dispatch.data, dumped, options);
}

Fate Bench::run(const TwinShader& shader, const Site& site) {
    std::vector<std::unique_ptr<Prepared>>& all = prepared(*shader.binding);
    const std::vector<std::uint32_t> spirv = runnable(changed(shader.module, *shader.index, site));
    use(*all[0], shader, spirv);
    bool differs = false;
    for (std::size_t i = 0; i < all.size(); ++i) {
        Prepared& p = *all[i];
        if (i > 0) use_too(p, *all[0], shader, spirv);
        p.twin.submit();
        const Bundle outputs = p.twin.read().outputs;
        if (same_bits(outputs, p.own)) continue;
        differs = true;
        if (judged(p, outputs).passed) continue;
        // The one that finds most stands first: most mutants take one run.
        std::rotate(all.begin(), all.begin() + std::ptrdiff_t(i), all.begin() + std::ptrdiff_t(i) + 1);
        return Fate::found;
    }
    return differs ? Fate::in_bounds : Fate::no_effect;
}

bool Bench::changes_output(const TwinShader& shader, const SpirvModule& module) {
    std::vector<std::unique_ptr<Prepared>>& all = prepared(*shader.binding);
    const std::vector<std::uint32_t> spirv = runnable(module);
    use(*all[0], shader, spirv);
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (i > 0) use_too(*all[i], *all[0], shader, spirv);
        all[i]->twin.submit();
        if (!same_bits(all[i]->twin.read().outputs, all[i]->own)) return true;
    }
    return false;
}

Fate Bench::why(const TwinShader& shader, const Site& site) {
    if (!changes_output(shader, marked(shader.module, *shader.index, site, Mark::reached))) return Fate::unreached;
    const bool differs = changes_output(shader, marked(shader.module, *shader.index, site, Mark::differed));
    return differs ? Fate::no_effect : Fate::same_value;
}

Fate Bench::operator()(const GenericMutant& mutant) {
    Fate least = Fate::unreached;
    for (const GenericMutant::Home& home : mutant.homes) {
        const TwinShader& shader = *all_.shaders[home.shader];
        Fate fate = run(shader, shader.sites[home.site]);
        if (fate == Fate::no_effect) fate = why(shader, shader.sites[home.site]);
        least = std::min(least, fate);
        if (least == Fate::found) break;
    }
    return least;
}

void Bench::check_twin(const TwinShader& shader) {
    std::vector<std::unique_ptr<Prepared>>& all = prepared_;
    const std::vector<std::uint32_t> spirv = runnable(shader.module);
    use(*all[0], shader, spirv);
    for (std::size_t i = 0; i < all.size(); ++i) {
        Prepared& p = *all[i];
        if (i > 0) use_too(p, *all[0], shader, spirv);
        p.twin.submit();
        const Bundle outputs = p.twin.read().outputs;
        if (!same_bits(outputs, p.own))
            throw InputError(fmt::format("{}: {}: with guarded loops and reads it writes other bits", shader.file, p.dispatch.name));
    }
}

}  // namespace plumb::mutants
