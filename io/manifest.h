// Manifests: what was dumped from a GPU, pass by pass. TOML, or JSON of the same structure. See io/README.md, "Manifests".
//
//     device = "..."                    # free text, for the report
//     profile = "ideal"
//     max_ambiguous = 0.005
//     scene = "cornell.toml"            # optional: gives uniforms, patterns and geometry that are not dumped
//     [[stage]]
//     stage = "rsm.disc"
//     light = "key"                     # which of the scene's, for a stage that runs once a light; face = "px"
//     size = [1920, 1080]
//     [stage.params]                    # as `plumb stages` lists them; instead of the scene's settings
//     [stage.uniforms]                  # members of the block by name; or file = "block.bin"
//     [stage.input.position]
//     file = "position.raw"             # .exr .pfm .hdr .tif .dds .png .npy; else raw
//     vk_format = "R16G16B16A16_SFLOAT" # raw: with width, height, row_pitch (bytes), offset (bytes)
//     channels = "xyz"                  # which channels of the file are x, y, z, w: "xyz" is "rgb"; "w" is the fourth
//     encoding = "plain"                # plain | biased (2 c - 1) | octahedral | octahedral_unorm | reversed_depth | ...
//     flip_y = false
//     [stage.output.irradiance]
//     ...
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/bundle.h"
#include "core/formats.h"

namespace plumb::io {

// A dumped image or buffer, as the manifest describes it.
struct DumpSpec {
    std::filesystem::path file;     // absolute, or relative to the working directory
    std::string place;              // "manifest.toml: stage.input.position": in messages
    std::string vk_format;          // of raw files; without VK_FORMAT_
    int width = 0, height = 0;      // of raw files; else 0 or as the file must be
    std::int64_t row_pitch = 0;     // bytes; 0: rows without padding
    std::int64_t offset = 0;        // bytes before the first texel
    std::string layer;              // of an EXR with many
    std::string channels;           // "": as they lie
    std::string encoding = "plain";
    bool flip_y = false;
    std::vector<double> near_far;   // of encodings of depth
};

struct DumpedImage {
    Array array;                    // f32 [height][width][4] (or i32 [height][width][1..4] of integer formats); buffers
                                    // of .npy keep their shape
    Format stored = Format::rgba32f;  // what the values were rounded to before they were written
    unsigned channels = 15;         // bit c: component c is there
};

struct ManifestStage {
    std::string place;              // "manifest.toml: stage 3 (rsm.disc)"
    std::string stage, label, light, face;
    int width = 0, height = 0;
    std::map<std::string, std::vector<double>> uniforms;
    std::filesystem::path uniforms_file;
    std::map<std::string, std::vector<std::string>> params;  // words as in a scene file
    std::map<std::string, DumpSpec> inputs, outputs;
    DumpSpec choices;               // file empty: none
};

struct Manifest {
    std::filesystem::path file;
    std::string device, profile = "ideal";
    double max_ambiguous = 0.005;
    std::filesystem::path scene;    // empty: none
    std::vector<ManifestStage> stages;
};

// Throw InputError of one line: file, place in it, cause. Unknown keys name the nearest known one.
Manifest read_manifest(const std::filesystem::path& file);
DumpedImage read_dump(const DumpSpec& spec);

std::string manifest_text(const Manifest& manifest);  // TOML that read_manifest() reads back as it was

}  // namespace plumb::io
