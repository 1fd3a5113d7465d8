// Generic mutants: every site of every stage's twins, each made once, whatever the stage is.
//
// A function that several twins include is one function: its mutants run with each of these twins until one finds them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/binding.h"
#include "tools/mutants/edit.h"
#include "tools/mutants/mutant.h"

namespace plumb::mutants {

// A twin's shader, with its lines.
struct TwinShader {
    const StageBinding* binding = nullptr;
    std::string file;
    bool vertex = false;  // of a raster stage: else the fragment stage
    SpirvModule module;
    std::unique_ptr<const SpirvIndex> index;
    std::vector<Site> sites;
};

struct GenericMutant {
    struct Home {
        std::size_t shader = 0, site = 0;
    };
    std::vector<Home> homes;
    std::uint64_t key = 0;  // of what it changes, by function and text: the same wherever the line stands
};

struct GenericMutants {
    std::vector<std::unique_ptr<const TwinShader>> shaders;
    std::vector<GenericMutant> mutants;  // in the order of the stages, then of the instructions

    const TwinShader& shader(const GenericMutant& m) const { return *shaders[m.homes[0].shader]; }
    const Site& site(const GenericMutant& m) const { return shader(m).sites[m.homes[0].site]; }
    const std::string& stage(const GenericMutant& m) const { return shader(m).binding->info.name; }
};

// `source`: the project's root, which names of files leave out.
std::unique_ptr<const TwinShader> read_shader(const StageBinding& binding, const std::string& file,
                                              std::span<const std::uint32_t> spirv, const std::string& source);
// Their mutants: one a function, however many of them include it.
GenericMutants share(std::vector<std::unique_ptr<const TwinShader>> shaders);
GenericMutants generic_mutants(const std::vector<const StageBinding*>& stages, const TwinCompiler& compiler,
                               const std::string& source);

// `n` mutants of each stage, by their keys and the seed; in their order.
std::vector<GenericMutant> sample(const GenericMutants& all, std::size_t n, std::uint64_t seed);

}  // namespace plumb::mutants
