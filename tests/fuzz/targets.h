// What the fuzzers run: a file in memory through the readers that the program has. See tests/fuzz/README.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace plumb::fuzz {

// Reads a file of its format and returns the bytes that an honest reader needs at once for it: the file, and what comes
// of it. A file that is refused needs what may be known before that. InputError is the only exception that counts as
// refused; any other passes.
using Target = std::size_t (*)(const std::uint8_t* data, std::size_t size);

std::size_t fuzz_obj(const std::uint8_t* data, std::size_t size);   // an OBJ whose library is a fixed one
std::size_t fuzz_mtl(const std::uint8_t* data, std::size_t size);   // the library of a fixed OBJ
std::size_t fuzz_gltf(const std::uint8_t* data, std::size_t size);  // JSON
std::size_t fuzz_glb(const std::uint8_t* data, std::size_t size);
std::size_t fuzz_png(const std::uint8_t* data, std::size_t size);   // as a texture
std::size_t fuzz_exr(const std::uint8_t* data, std::size_t size);   // all layers
std::size_t fuzz_picture(const std::uint8_t* data, std::size_t size);   // of another format, which the first byte chooses
std::size_t fuzz_toml(const std::uint8_t* data, std::size_t size);      // a scene, a list of cameras, a manifest
std::size_t fuzz_array(const std::uint8_t* data, std::size_t size);     // .npy, bundles

struct Format {
    const char* name;
    Target run;
    std::size_t slack;  // bytes beside what a file needs: tables of libraries, stacks of parsers
};
std::span<const Format> formats();

// A folder in memory where that is possible, with a picture "a.png"; one a process, removed at its end.
const std::string& scratch_folder();

}  // namespace plumb::fuzz
