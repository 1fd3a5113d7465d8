// The defaults that `plumb experiment defaults` holds against their alternatives.
#include <fmt/format.h>

#include "tools/experiments/defaults.h"

namespace plumb::cli {

namespace {

// Values of one parameter.
DefaultChoice values(const std::string& key, const std::vector<std::string>& list) {
    DefaultChoice choice{key, {}};
    const std::string last = key.substr(key.find('.') + 1);
    for (const std::string& value : list) choice.others.push_back({last + " = " + value, {key + "=" + value}});
    return choice;
}

DefaultChoice gathers() {
    DefaultChoice choice{"rsm.gather", {}};
    for (const char* samples : {"150", "400"})
        choice.others.push_back({fmt::format("disc, {} samples", samples), {"rsm.gather=disc", fmt::format("rsm.samples={}", samples)}});
    choice.others.push_back({"paths", {"rsm.gather=paths"}});
    return choice;
}

// Rotations by a hash, or over tiles.
DefaultChoice turns() {
    DefaultChoice choice{"rsm.turn", {}};
    for (const char* turn : {"hash", "tile"})
        for (const char* rotations : {"16", "64", "256"})
            choice.others.push_back({fmt::format("{} by {}", rotations, turn), {fmt::format("rsm.turn={}", turn), fmt::format("rsm.rotations={}", rotations)}});
    return choice;
}

// More paths or more steps, of about as many samples.
DefaultChoice path_shapes() {
    DefaultChoice choice{"rsm.directions", {}};
    for (const auto& [paths, steps] : {std::pair(30, 5), std::pair(20, 8), std::pair(15, 10), std::pair(10, 15), std::pair(8, 20)})
        choice.others.push_back({fmt::format("{} paths of {}", paths, steps),
                                 {fmt::format("rsm.directions={}", paths), fmt::format("rsm.steps={}", steps)}});
    return choice;
}

// How much is sampled: how often, as people read it, and the settings.
using Amounts = std::vector<Alternative>;

Amounts disc_amounts() {
    Amounts all;
    for (const int n : {100, 400, 1600}) all.push_back({fmt::format("{} samples", n), {fmt::format("rsm.samples={}", n)}});
    return all;
}

Amounts paths_amounts() {
    Amounts all;
    for (const auto& [paths, steps] : {std::pair(8, 5), std::pair(15, 10), std::pair(30, 20)})
        all.push_back({fmt::format("{} x {}", paths, steps), {fmt::format("rsm.directions={}", paths), fmt::format("rsm.steps={}", steps)}});
    return all;
}

// Resolution, blur and samples together: fewer pixels pay for more samples, and a blur for fewer.
DefaultChoice filters(const Amounts& amounts) {
    DefaultChoice choice{"indirect", {}};
    for (const char* resolution : {"full", "half"})
        for (const char* blur : {"none", "full", "separable"})
            for (const auto& amount : amounts) {
                choice.others.push_back({fmt::format("{}, blur {}, {}", resolution, blur, amount.name), amount.sets});
                auto& sets = choice.others.back().sets;
                sets.push_back(fmt::format("indirect.resolution={}", resolution)), sets.push_back(fmt::format("indirect.blur={}", blur));
            }
    return choice;
}

DefaultChoice shadow_modes() {
    DefaultChoice choice{"shadow.mode", {{"esm", {"shadow.mode=esm"}}}};
    for (const char* test : {"depth", "planes"}) {
        const auto add = [&](const std::string& name, std::vector<std::string> sets) {
            sets.push_back(fmt::format("shadow.test={}", test));
            choice.others.push_back({fmt::format("{}, by {}", name, test), sets});
        };
        add("hard", {"shadow.mode=hard"}), add("density", {"shadow.mode=density"});
        for (const char* kernel : {"1", "2", "3"})
            add(fmt::format("pcf of {}", kernel), {"shadow.mode=pcf", fmt::format("shadow.pcf_kernel={}", kernel)});
    }
    return choice;
}

DefaultChoice isr_blurs() {
    DefaultChoice choice{"isr.blur", {{"none", {"isr.blur=none"}}}};
    for (const char* blur : {"gaussian", "edge_aware"})
        for (const int radius : {4, 6, 8, 12})
            choice.others.push_back({fmt::format("{}, radius = {}", blur, radius),
                                     {fmt::format("isr.blur={}", blur), fmt::format("isr.blur_radius={}", radius)}});
    return choice;
}

DefaultChoice isr_rotations() {
    DefaultChoice choice{"isr.rotations", {}};
    for (const char* turn : {"hash", "tile"})
        for (const int rotations : {16, 64, 256})
            choice.others.push_back({fmt::format("{} by {}", rotations, turn),
                                     {fmt::format("isr.turn={}", turn), fmt::format("isr.rotations={}", rotations)}});
    return choice;
}

}  // namespace

const std::vector<ChoiceGroup>& default_choices() {
    static const std::vector<ChoiceGroup> all = {
        {"shadow", "direct", "direct", {},
         {shadow_modes(), values("shadow.bias", {"0.0001", "0.001", "0.01"}), values("shadow.slope_bias", {"0.71", "1", "2"}),
          values("shadow.max_slope", {"4", "16", "64", "256"}), values("shadow.test", {"depth", "plane", "planes"})}},
        {"rsm", "rsm", "indirect", {},
         {gathers(), filters(paths_amounts()), path_shapes(),
          values("rsm.visibility", {"none", "algorithm_2", "algorithm_3", "algorithm_6"}),
          values("rsm.spacing", {"uniform", "quadratic", "geometric"}), values("rsm.slots", {"3", "5", "9"}),
          values("rsm.slot_edges", {"angle", "solid_angle"}), turns(), values("rsm.jitter", {"0", "0.5", "1"}),
          values("rsm.thickness", {"0", "0.02", "0.05", "0.1", "0.3", "1", "1e9"}),
          values("rsm.texels", {"whole", "continuous"}), values("rsm.sample_area", {"none", "texels"})}},
        {"rsm.disc", "rsm", "indirect", {"rsm.gather=disc"},
         {filters(disc_amounts()), values("rsm.samples", {"100", "200", "400", "800"}), turns(),
          values("rsm.sequence", {"hammersley", "r2", "random"}), values("rsm.texels", {"whole", "continuous"}),
          values("rsm.sample_area", {"none", "texels"})}},
        {"isr", "isr", "indirect", {},
         {values("isr.rings", {"2", "3", "4", "6"}), values("isr.reach", {"0.5", "0.75", "1", "1.25", "1.5"}),
          values("isr.growth", {"2", "3", "4"}), isr_rotations(), isr_blurs(), values("isr.upsample", {"bilateral", "bilinear"}),
          values("isr.pattern", {"rings", "grid"})}},
        {"ao", "direct", "ao", {"ao.method=ssao", "ao.ambient=1,1,1"},
         {values("ao.blur", {"none", "box", "edge_aware"}), values("ao.samples", {"16", "32", "64", "128"}),
          values("ao.bias", {"0.001", "0.01", "0.05"})}},
        {"ao.horizon", "direct", "ao", {"ao.method=horizon", "ao.ambient=1,1,1"},
         {values("ao.blur", {"none", "box", "edge_aware"}), values("ao.slices", {"2", "4", "8"}), values("ao.steps", {"4", "8", "16"})}},
        {"probes", "probes", "color", {}, {values("probes.gather", {"interpolated", "fitted"})}},
        {"radiosity", "radiosity", "color", {}, {values("radiosity.refine", {"1", "2", "3"})}},
    };
    return all;
}

}  // namespace plumb::cli
