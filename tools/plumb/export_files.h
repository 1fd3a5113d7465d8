// The files of one export, with what its manifest says about them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/binding.h"
#include "io/manifest.h"
#include "tools/shared/outputs.h"

namespace plumb::cli {

// What a stage wrote; and its discrete choices, [height][width][n], where a twin told them.
struct MadeOutputs {
    Bundle outputs;
    std::vector<std::int32_t> choices = {};
    int choices_a_pixel = 0;
};

// Writes inputs, blocks, answers and fillings, and remembers the hash of each. Inputs of equal bytes are one file: most
// stages read the same G-buffer.
class ExportFiles {
  public:
    ExportFiles(Outputs& outputs, const std::string& folder, std::uint32_t filling)
        : outputs_(outputs), folder_(folder), filling_(filling) {}

    // The file of an array that a GPU binds as it is, with what a manifest says about it.
    io::DumpSpec input(const std::string& id, const Slot& slot, const Array& array);
    // expected/ holds the answer; out/ a filling that is nowhere in it, or what a device wrote, where there is one.
    io::DumpSpec output(const std::string& id, const Slot& slot, const Array& expected, const Array* device);
    // As many channels as a pixel has choices. Every stage that projects to a map makes two; the others none.
    io::DumpSpec choices(const std::string& id, const MadeOutputs& made, glm::ivec2 size);
    std::string write(const std::string& name, const void* data, std::size_t bytes);

    const std::map<std::string, std::string>& hashes() const { return hashes_; }  // by name in the folder
    std::size_t bytes() const { return bytes_; }

  private:
    io::DumpSpec spec(const std::string& name, const Slot& slot, const Array& array) const;

    Outputs& outputs_;
    std::string folder_;
    std::uint32_t filling_;
    std::map<std::pair<std::uint64_t, std::size_t>, std::string> inputs_;
    std::map<std::string, std::string> hashes_;
    std::size_t bytes_ = 0;
};

// Writes one dispatch: its block, inputs, answers and fillings. Returns what a manifest says of it. light: its name, or empty.
io::ManifestStage export_stage(const StageBinding& binding, const StageData& data, const std::string& light,
                               const Bundle& expected, const MadeOutputs& made, ExportFiles& files);

}  // namespace plumb::cli
