// Mutants: twins with one edit, by which the judge is judged. Wrong ones must be found, legal ones must not.
//
//     [[mutant]]
//     name = "direct.cosine_of_the_wrong_side"
//     stage = "direct"
//     kind = "wrong"                  # wrong | legal | scale: {s} in `replace` is 1 + e for the smallest e that is found
//     file = "gi/direct/direct.comp"  # or a file that it includes; from the project's root
//     find = "max(0.0, n.x"           # exactly once in the file; all = true: at least once, and everywhere
//     replace = "abs(n.x"
//
// `replace` may call what prelude.glsl offers: half precision, fused and truncated arithmetic.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/binding.h"

namespace plumb::mutants {

enum class Kind : int { wrong, legal, scale };
inline constexpr int kinds = 3;
const char* kind_name(Kind kind);

struct Mutant {
    std::string name, stage, file, find, replace;
    Kind kind = Kind::wrong;
    bool all = false;
    std::string place;  // "direct.toml: line 12"
};

// All lists of a folder, *.toml in the order of their names. Throws InputError for what is no such list, for two mutants
// of one name, and for a file that is not there.
std::vector<Mutant> read_mutants(const std::filesystem::path& folder);

// Compiles twins, as they are and mutated, in a directory of its own, which goes with it. Threads may share one.
class TwinCompiler {
  public:
    TwinCompiler(std::string glslang, std::filesystem::path source);
    ~TwinCompiler();
    TwinCompiler(const TwinCompiler&) = delete;
    TwinCompiler& operator=(const TwinCompiler&) = delete;

    // The stage's twin (of raster stages the fragment stage). Throws InputError for an edit that does not apply, and with
    // the compiler's words where it does not compile. `scale` stands for {s}.
    std::vector<std::uint32_t> compile(const StageBinding& binding) const;
    std::vector<std::uint32_t> compile(const StageBinding& binding, const Mutant& mutant, double scale = 1) const;

    // Any shader by its path from the project's root, with this text in place of its own. `name` is what errors call it.
    std::vector<std::uint32_t> compile_text(const std::string& file, const std::string& text, const std::string& name) const;

    // Any twin as it is, by its path from the project's root, with its text and lines (-g).
    std::vector<std::uint32_t> compile_with_lines(const std::string& file) const;

  private:
    std::vector<std::uint32_t> compile_file(const std::filesystem::path& overlay, const std::filesystem::path& file,
                                            const std::string& name, const std::string& more = "") const;
    std::filesystem::path new_overlay() const;

    std::string glslang_;
    std::filesystem::path source_, directory_;
    mutable std::atomic<int> overlays_ = 0;
};

// `text` with the edit. Throws InputError where `find` does not stand as often as it must.
std::string edited(const Mutant& mutant, const std::string& text, double scale);

}  // namespace plumb::mutants
