#include "tools/plumb/memory_need.h"

#include <algorithm>
#include <filesystem>

#include "gi/parity/stages.h"

namespace plumb::cli {

namespace {

const StageBinding* binding_of(const std::string& stage) {
    const std::vector<StageBinding>& all = parity::bindings();
    const auto at = std::find_if(all.begin(), all.end(), [&](const StageBinding& b) { return b.info.name == stage; });
    return at == all.end() ? nullptr : &*at;
}

std::uint64_t items(glm::ivec2 size) { return std::uint64_t(std::max(size.x, 0)) * std::uint64_t(std::max(size.y, 0)); }

std::uint64_t bytes_of(const std::vector<Slot>& slots, glm::ivec2 size, int layers) {
    std::uint64_t bytes = 0;
    for (const Slot& s : slots)
        if (s.frame) bytes += 4 * std::uint64_t(s.channels) * items(size) * std::uint64_t(s.kind == SlotKind::image_array ? layers : 1);
    return bytes;
}

// Of an image each texel has four components once it is read; of a file without a size it is as large as `size`.
std::uint64_t bytes_of(const io::DumpSpec& spec, glm::ivec2 size) {
    const bool image = spec.count == 0;
    return 16 * (image ? spec.width > 0 ? items({spec.width, spec.height}) : items(size) : std::uint64_t(spec.count));
}

std::uint64_t file_bytes(const io::DumpSpec& spec) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(spec.file, error);
    return error ? 0 : bytes;
}

}  // namespace

std::uint64_t bytes_to_export(const frame::FrameGraph& graph, const std::vector<frame::PlannedStage>& stages, int lights) {
    std::uint64_t frame = 0, dispatch = 0;
    for (const frame::PlannedNode& node : graph.nodes())
        if (const StageBinding* binding = binding_of(node.plan.name)) frame += bytes_of(binding->outputs, node.size(), lights);
    for (const frame::PlannedStage& stage : stages)
        if (const StageBinding* binding = binding_of(stage.name)) {
            const glm::ivec2 size = graph.node(stage).size();
            dispatch = std::max(dispatch, bytes_of(binding->inputs, size, lights) + 2 * bytes_of(binding->outputs, size, lights));
        }
    return frame + dispatch + (frame + dispatch) / 10;
}

std::uint64_t bytes_to_validate(const io::Manifest& manifest, bool pictures) {
    std::uint64_t most = 0, kept = 0;
    for (const io::ManifestStage& stage : manifest.stages) {
        const glm::ivec2 size(stage.width, stage.height);
        std::uint64_t bytes = 0, largest_file = 0;
        for (const auto& [name, spec] : stage.inputs) {
            // Beside an input that is decoded or formed, how far a device may be from it.
            bytes += (spec.vk_format.ends_with("_SFLOAT") && spec.encoding == "plain" ? 1 : 2) * bytes_of(spec, size);
            largest_file = std::max(largest_file, file_bytes(spec));
        }
        for (const auto& [name, spec] : stage.outputs) {
            // Beside ours, how far each number was moved, and whether it was written.
            bytes += 2 * bytes_of(spec, size) + items(size), largest_file = std::max(largest_file, file_bytes(spec));
        }
        most = std::max(most, bytes + largest_file);
        kept += items(size) * (pictures ? 9 : 1);
    }
    return most + kept;
}

}  // namespace plumb::cli
