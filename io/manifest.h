// Manifests: what was dumped from a GPU, pass by pass. TOML, or JSON of the same structure. See io/README.md,
// "Manifests".
//
//     device = "..."                    # free text, for the report
//     profile = "ideal"
//     subpixel_bits = 4                 # optional, of "ideal": what VkPhysicalDeviceLimits says of the device
//     max_ambiguous = 0.005
//     scene = "cornell.toml"            # optional: gives uniforms, patterns and geometry that are not dumped
//     [[stage]]
//     stage = "..."                     # as `plumb stages` lists it
//     light = "key"                     # which of the scene's, for a stage that runs once a light; face = "px"
//     size = [1920, 1080]
//     [stage.params]                    # as `plumb stages` lists them; instead of the scene's settings
//     [stage.uniforms]                  # members of the block by name; or file = "block.bin"
//     [stage.light_view_proj]           # instead of those that follow from it: rows = [...] or columns = [...]
//     [stage.input.position]
//     file = "position.raw"             # .exr .pfm .hdr .tif .dds .png .npy; or raw, of the format
//     vk_format = "R16G16B16A16_SFLOAT" # with width, height, row_pitch (bytes), offset (bytes)
//     channels = "xyz"                  # which channels of the file are x, y, z, w: "xyz" is "rgb"; "w" is the fourth
//     encoding = "plain"                # plain, biased (2 c - 1), octahedral, octahedral_unorm, reversed_depth, ...
//     flip_y = false
//     normalized = true                 # of an input: to unit length, as a shader that renormalises does
//     matrix = { rows = [...] }         # of an input: 16 numbers that bring it to world space; or columns
//     [stage.output.irradiance]
//     ...
//     expected = "expected/irradiance.bin"  # of an export: what it should hold; filling = "ffe1a2b3": what it held
//     [stage.coverage]                  # optional: where its first component is not above 0 there is nothing
//     file = "stencil.raw"
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/bundle.h"
#include "core/formats.h"

namespace plumb::io {

// A 4x4 matrix that takes columns (x, y, z, w): 16 numbers, row by row.
using MatrixRows = std::array<double, 16>;

// What an input goes through once it is decoded: world = matrix (x, y, z, 1).
struct InputMatrix {
    MatrixRows rows{};
    std::string of;  // "points", "normals" or "directions"; "": as the input's name says
};

// A position out of a depth buffer: world = inverse_view_proj (x, y, z, 1) in clip space, divided by its w. Where
// view_proj is given it has an inverse.
struct FromDepth {
    MatrixRows matrix{};
    bool forward = false;     // the matrix is view_proj; else inverse_view_proj
    bool below_zero = false;  // clip space reaches from z = -1 to 1, which is 2 depth - 1; else from 0 to 1
    bool reversed_z = false;  // cleared to 0; else to 1: there nothing is
    bool y_up = false;        // clip space has its y upwards
};

// A view that gives what a block holds of it: clip = view_proj (x, y, z, 1), world.
struct ViewSpec {
    std::string place;
    MatrixRows view_proj{};
    bool below_zero = false, reversed_z = false, y_up = false;  // as of FromDepth
};

// How a shader's sampler reads an image of the light's map.
struct SamplerSpec {
    bool linear = false;             // between texels; else the nearest one
    enum Address { border, edge, wrap } address = border;  // what is read beyond the image
    std::array<double, 4> colour{};  // of the border
};

// A dumped image or buffer, as the manifest describes it.
struct DumpSpec {
    std::filesystem::path file;  // absolute, or relative to the working directory
    std::string place;           // "manifest.toml: stage.input.position": in messages
    std::string vk_format;       // of raw files, whatever they are named
    int width = 0, height = 0;   // of raw files; else 0 or as the file must be
    int count = 0;               // of raw buffers: elements; instead of width and height
    std::int64_t row_pitch = 0;  // bytes; 0: rows without padding
    std::int64_t offset = 0;     // bytes before the first texel
    bool trailing = false;       // a raw file may go on after the last row
    std::string layer;           // of an EXR with many
    std::string channels;        // of "xyzw", "rgba", "0", "1" and "_" (not there); "": as they lie
    std::string encoding = "plain";
    bool flip_y = false;           // the file's first row is the lowest
    std::vector<double> near_far;  // of encodings of depth, m; far may be infinite
    // Of an input, once it is decoded, in this order.
    std::optional<FromDepth> from_depth;
    std::optional<InputMatrix> matrix;
    // These two of an output, too: what the shader multiplies by before it writes.
    std::vector<double> scale;      // a factor, or one for each of x, y, z; empty: 1
    std::vector<DumpSpec> factors;  // images of the same size by which x, y and z are multiplied
    std::vector<double> clamp;      // of an output: lowest and highest, to which x, y and z are held then; empty: none
    bool normalized = false;        // then to unit length
    std::vector<DumpSpec> w;        // an image of the same size, whose one channel is the fourth component; or empty
    std::optional<SamplerSpec> sampler;
    double along_normal = 0;  // of the map's position: m by which a shader moves it along the map's normal, as read
    // Of a pattern of samples: dx and dy are multiplied by `radius`, and by the map's side where they are shares of it; the
    // weights by `weight_scale`.
    double radius = 1, weight_scale = 1;
    bool of_map = false, y_up = false;
    bool skips_beyond = false;  // a sample beyond the map adds nothing, whatever a sampler reads there
    std::array<int, 2> tile{};  // pixels that repeat, each with a pattern of its own; 0: one for all
    // Of an exported output: the file that holds what should be written, and the word that stood in it until something
    // was (io/filling.h). A raw file with a filling may be missing or end early.
    std::filesystem::path expected;
    std::optional<std::uint32_t> filling;
};

struct DumpedImage {
    // Images: f32 [height][width][4], or i32 [height][width][1..4] of integer formats. Raw buffers: [count][1..4].
    // Buffers of .npy keep their shape. Components that are not there are 0, 0, 0, 1.
    Array array;
    Format stored = Format::rgba32f;  // what the values were rounded to before they were written, or a coarser one
    unsigned channels = 15;           // bit c: component c is there
    // Where no format says how the values were rounded (16-bit unorm, packed depth, ...): what the device wrote was
    // clamped to [lowest, highest] and moved by at most this, f32 of the array's shape. Empty elsewhere: `stored` says
    // it.
    Array rounding;
    double lowest = -std::numeric_limits<double>::infinity(), highest = std::numeric_limits<double>::infinity();
    // Of a raw file with a filling, [height][width]: 1 where a texel still holds it, 2 where the file has ended. Empty:
    // all was written.
    std::vector<std::uint8_t> unwritten;
    std::string absent;  // why nothing at all was written: "is missing", ...; else ""
};

// Where a surface is seen: above < first component < below. Packed normals cannot say it.
struct CoverageSpec {
    DumpSpec dump;  // file empty: none
    double above = 0, below = std::numeric_limits<double>::infinity();
};

struct ManifestStage {
    std::string place;  // "manifest.toml: stage 3 (rsm.disc)"
    std::string stage, label, form, light, face;
    int width = 0, height = 0;
    std::map<std::string, std::vector<double>> uniforms;
    std::map<std::string, ViewSpec> views;     // by the struct in the block that they fill: "map" of a light's
    std::filesystem::path uniforms_file;
    std::filesystem::path block;  // of an export: the block as a file, beside the values
    std::map<std::string, std::vector<std::string>> params;  // words as in a scene file
    std::map<std::string, DumpSpec> inputs, outputs;
    DumpSpec choices;  // file empty: none
    CoverageSpec coverage;
};

// What `plumb export` wrote beside the manifest.
struct ExportRecord {
    std::string id;                            // 16 hexadecimal digits, the same for the same scene and settings; "": none
    std::map<std::string, std::string> files;  // hashes (core/content_hash.h) by names relative to the manifest
};

struct Manifest {
    std::filesystem::path file;
    std::string device, profile = "ideal";
    int subpixel_bits = 0;  // of the profile "ideal", 1 to 16; 0: the profile's
    double max_ambiguous = 0.005;
    std::filesystem::path scene;  // empty: none
    ExportRecord exported;
    std::vector<ManifestStage> stages;
};

// Of a matrix that has no inverse numbers that are not finite.
MatrixRows inverse_of(const MatrixRows& rows);

// Throw InputError of one line: file, place in it, cause. Unknown keys name the nearest known one. Where sizes are left
// out, raw images and outputs get their stage's, and the stage its first output's.
Manifest read_manifest(const std::filesystem::path& file);
DumpedImage read_dump(const DumpSpec& spec);

// The name of a file relative to the folder of manifest.file, as ExportRecord::files has it; "" where it lies elsewhere.
std::string name_in(const Manifest& manifest, const std::filesystem::path& file);

// TOML that read_manifest() reads back as it was; files are named relative to the folder of manifest.file.
std::string manifest_text(const Manifest& manifest);

}  // namespace plumb::io
