#include "tools/mutants/generic.h"

#include <algorithm>
#include <map>
#include <set>

namespace plumb::mutants {
namespace {

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
    hash ^= value + 0x9e3779b97f4a7c15ull + (hash << 6) + (hash >> 2);
    hash *= 0xff51afd7ed558ccdull;
    return hash ^ hash >> 33;
}
std::uint64_t mixed(std::uint64_t hash, const std::string& text) {
    for (const char c : text) hash = mixed(hash, std::uint64_t(std::uint8_t(c)));
    return hash;
}

// What a site changes, without its line.
std::uint64_t hash_of(const Site& site) {
    return mixed(mixed(mixed(0, site.place.file), site.place.text), std::uint64_t(site.change));
}

// Sites of one function: the text that it has in this shader, macros and all.
struct Stretch {
    std::size_t first = 0, count = 0;
    std::uint64_t hash = 0;
};
std::vector<Stretch> stretches_of(const std::vector<Site>& sites) {
    std::vector<Stretch> out;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        if (i == 0 || sites[i].place.function != sites[i - 1].place.function)
            out.push_back({i, 0, mixed(0, sites[i].place.function)});
        ++out.back().count;
        out.back().hash = mixed(out.back().hash, hash_of(sites[i]));
    }
    return out;
}

std::string without_root(const std::string& file, const std::string& source) {
    if (file.starts_with(source + "/")) return file.substr(source.size() + 1);
    return file.starts_with("./") ? file.substr(2) : file;
}

}  // namespace

std::unique_ptr<const TwinShader> read_shader(const StageBinding& binding, const std::string& file,
                                              std::span<const std::uint32_t> spirv, const std::string& source) {
    auto made = std::make_unique<TwinShader>();
    TwinShader& out = *made;
    out.binding = &binding, out.file = file, out.vertex = file.ends_with(".vert");
    out.module = parse_spirv(spirv);
    out.index = std::make_unique<SpirvIndex>(out.module);
    out.sites = find_sites(out.module, *out.index);
    for (Site& site : out.sites) site.place.file = without_root(site.place.file, source);
    return made;
}

GenericMutants share(std::vector<std::unique_ptr<const TwinShader>> shaders) {
    GenericMutants all;
    all.shaders = std::move(shaders);
    std::map<std::uint64_t, std::size_t> known;  // a function's first mutant
    for (std::size_t number = 0; number < all.shaders.size(); ++number) {
        const std::vector<Site>& sites = all.shaders[number]->sites;
        for (const Stretch& s : stretches_of(sites)) {
            const auto [at, is_new] = known.try_emplace(s.hash, all.mutants.size());
            for (std::size_t i = 0; i < s.count; ++i) {
                if (is_new) {
                    const Site& site = sites[s.first + i];
                    all.mutants.push_back({{}, mixed(mixed(mixed(s.hash, hash_of(site)), site.part), i)});
                }
                all.mutants[at->second + i].homes.push_back({number, s.first + i});
            }
        }
    }
    return all;
}

GenericMutants generic_mutants(const std::vector<const StageBinding*>& stages, const TwinCompiler& compiler,
                               const std::string& source) {
    std::vector<std::unique_ptr<const TwinShader>> shaders;
    for (const StageBinding* stage : stages) {
        std::vector<std::string> files{stage->twin};
        if (stage->raster) files = {stage->twin + ".vert", stage->twin + ".frag"};
        for (const std::string& file : files)
            shaders.push_back(read_shader(*stage, file, compiler.compile_with_lines(file), source));
    }
    return share(std::move(shaders));
}

std::vector<GenericMutant> sample(const GenericMutants& all, std::size_t n, std::uint64_t seed) {
    std::map<std::string, std::vector<std::pair<std::uint64_t, std::size_t>>> of_stage;
    for (std::size_t i = 0; i < all.mutants.size(); ++i)
        of_stage[all.stage(all.mutants[i])].push_back({mixed(mixed(0, seed), all.mutants[i].key), i});
    std::set<std::size_t> chosen;
    for (auto& [stage, list] : of_stage) {
        std::sort(list.begin(), list.end());
        for (std::size_t i = 0; i < std::min(n, list.size()); ++i) chosen.insert(list[i].second);
    }
    std::vector<GenericMutant> out;
    for (const std::size_t i : chosen) out.push_back(all.mutants[i]);
    return out;
}

}  // namespace plumb::mutants
