#include "tools/mutants/bench.h"

#include <algorithm>

#include "core/error.h"

namespace plumb::mutants {

const char* fate_name(Fate fate) {
    constexpr const char* names[] = {"found", "in_bounds", "no_effect", "same_value", "unreached"};
    return names[int(fate)];
}

void Bench::hold(const StageBinding& binding) {
    if (panels_.stage() == binding.info.name) return;
    for (const auto& shader : all_.shaders)
        if (shader->binding == &binding && !shader->vertex) fragment_ = runnable(words_of(shader->module));
    panels_.hold(binding, {fragment_, {}});
    for (const auto& shader : all_.shaders)
        if (shader->binding == &binding && shader->vertex && changes_output(*shader, shader->module))
            throw InputError(shader->file + ": with guarded loops and reads it writes other bits");
}

void Bench::use(const TwinShader& shader, const SpirvModule& module) {
    const std::vector<std::uint32_t> spirv = runnable(words_of(module));
    panels_.use(shader.vertex ? Shaders{fragment_, spirv} : Shaders{spirv, {}});
}

Fate Bench::run(const TwinShader& shader, const Site& site) {
    use(shader, changed(shader.module, *shader.index, site));
    bool differs = false;
    for (std::size_t i = 0; i < panels_.size(); ++i) {
        const Bundle outputs = panels_.run(i);
        if (panels_.is_as_the_twin(i, outputs)) continue;
        differs = true;
        if (panels_.judge(i, outputs, true).passed) continue;
        panels_.put_first(i);  // most mutants take one run where the dispatch that finds most stands first
        return Fate::found;
    }
    return differs ? Fate::in_bounds : Fate::no_effect;
}

bool Bench::changes_output(const TwinShader& shader, const SpirvModule& module) {
    use(shader, module);
    for (std::size_t i = 0; i < panels_.size(); ++i)
        if (!panels_.is_as_the_twin(i, panels_.run(i))) return true;
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
        hold(*shader.binding);
        Fate fate = run(shader, shader.sites[home.site]);
        if (fate == Fate::no_effect) fate = why(shader, shader.sites[home.site]);
        least = std::min(least, fate);
        if (least == Fate::found) break;
    }
    return least;
}

}  // namespace plumb::mutants
