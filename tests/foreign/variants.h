// Shaders of this folder with edits: bugs, and other ways to write the same.
//
//     [[bug]]                          # or [[formulation]]
//     name = "A: no 1/pi"
//     renderer = "A"
//     file = "gather_view.comp"        # of this folder; none where the program's own side has the bug
//     find = "total * INV_PI"          # once in the file; all = true: everywhere
//     replace = "total"
//     [[bug.edit]]                     # or several
//     find = ..., replace = ...
//     host = "last frame"              # what the program does otherwise: renderers.h
//     cause = "1/pi"                   # in words: bugs alone
//     wrong = "A: bounce"              # the stages that have it, by their labels; the others are right
//     named = "times pi"               # stands in one of the first three causes that the judge names; none: in none
#pragma once

#include <string>
#include <vector>

namespace plumb::foreign {

struct Edit {
    std::string find, replace;
    bool all = false;
};

struct Variant {
    std::string name, renderer, file, host, cause, wrong, named, place;
    std::vector<Edit> edits;
};

std::vector<Variant> read_variants(const std::string& file, const std::string& kind);

// The text of a file of this folder, with the edits where they are of that file. Throws InputError for one that does
// not apply.
std::string shader_text(const std::string& file, const Variant& variant);
std::vector<unsigned> compile(const std::string& file, const Variant& variant);  // to SPIR-V

}  // namespace plumb::foreign
