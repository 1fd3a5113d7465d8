#include "tools/plumb/validate_refill.h"

#include <fmt/format.h>

#include "core/error.h"
#include "io/file.h"
#include "io/filling.h"
#include "io/manifest.h"
#include "tools/plumb/cli.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

namespace {

struct Refill {
    std::string file;
    std::uint32_t word;
    std::size_t bytes;
};

// As large as the export made it: a word a component. Of a format of one's own that may be too much, and is written over
// all the same.
Refill refill_of(const io::ManifestStage& stage, const std::string& name, const io::DumpSpec& spec) {
    std::error_code error;
    const auto expected = std::filesystem::file_size(spec.expected, error);
    if (spec.expected.empty() || error)
        throw InputError(fmt::format("{}: output.{}: expected = {}: cannot be read; it says how large the output is",
                                     stage.place, name, io::shown(spec.expected.string())));
    return {spec.file.string(), *spec.filling, std::size_t(expected)};
}

}  // namespace

int refill(const std::string& path, bool json) {
    const io::Manifest manifest = io::read_manifest(path);
    std::vector<Refill> all;
    for (const io::ManifestStage& stage : manifest.stages)
        for (const auto& [name, spec] : stage.outputs)
            if (spec.filling) all.push_back(refill_of(stage, name, spec));
    if (all.empty())
        throw InputError(io::shown(path), "", "--refill: no output has a filling, as those of `plumb export` have");

    std::vector<std::string> files;
    for (const Refill& one : all) {
        const std::vector<unsigned char> bytes = io::filled_bytes(one.word, one.bytes);
        io::write_file(one.file, {{reinterpret_cast<const char*>(bytes.data()), bytes.size()}});
        files.push_back(one.file);
    }
    if (json)
        std::fputs(json_text({{"manifest", path}, {"refilled", files}}).c_str(), stdout);
    else
        fmt::print("filled {} output{} anew: what the next run does not write will be told\n", files.size(),
                   files.size() == 1 ? "" : "s");
    return success;
}

}  // namespace plumb::cli
