#include "tools/plumb/diagnosis_dumps.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/error.h"
#include "io/file.h"
#include "tools/plumb/slot_array.h"

namespace plumb::cli {

namespace {

// Puts the dump in the input's place, if it fits.
bool read_instead(const Slot& slot, const io::DumpSpec& spec, StageData& data) {
    try {
        std::vector<std::string> notes;
        Array array = input_array(slot, io::read_dump(spec), data.size, spec.place, notes);
        for (Array& a : data.inputs.arrays) {
            if (a.name != slot.name || a.dtype != array.dtype || a.shape != array.shape || a.bytes == array.bytes)
                continue;
            a.bytes = std::move(array.bytes);
            return true;
        }
    } catch (const InputError&) {
    }
    return false;
}

}  // namespace

std::vector<parity::Hypothesis> other_dumps(const io::Manifest& manifest, const io::ManifestStage& stage,
                                            const StageBinding& binding) {
    std::vector<parity::Hypothesis> all;
    for (const Slot& slot : binding.inputs) {
        const auto own = stage.inputs.find(slot.name);
        if (own == stage.inputs.end() || slot.kind != SlotKind::image || slot.dtype != DType::f32) continue;
        std::set<std::string> known{own->second.file.string()};
        for (const io::ManifestStage& other : manifest.stages)
            for (const auto* dumps : {&other.inputs, &other.outputs}) {
                const auto at = dumps->find(slot.name);
                if (at == dumps->end() || !known.insert(at->second.file.string()).second) continue;
                parity::Hypothesis h{fmt::format("{} of {}: {}", slot.name,
                                                 other.label.empty() ? other.stage : other.label,
                                                 io::shown(at->second.file.string()))};
                h.change = [&slot, &spec = at->second](StageData& data) { return read_instead(slot, spec, data); };
                all.push_back(std::move(h));
            }
    }
    return all;
}

}  // namespace plumb::cli
