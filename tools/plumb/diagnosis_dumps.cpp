#include "tools/plumb/diagnosis_dumps.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/error.h"
#include "gi/rsm/sampled.h"
#include "io/dump_encoding.h"
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

// What the manifest says is done with a dump before it is an input; "" for nothing.
std::string forms_of(const io::DumpSpec& spec) {
    std::string text;
    auto add = [&](bool there, const std::string& word) { text += there ? (text.empty() ? "" : ", ") + word : ""; };
    add(spec.encoding != "plain", spec.encoding);
    add(spec.from_depth.has_value(), "from depth");
    add(spec.matrix.has_value(), "its matrix");
    add(!spec.scale.empty() || !spec.factors.empty(), "its factors");
    add(spec.normalized, "normalized");
    return text;
}

// As it lies in its file: a shader that decodes nothing.
void add_undecoded(const Slot& slot, const io::DumpSpec& spec, std::vector<parity::Hypothesis>& all) {
    const std::string forms = forms_of(spec);
    if (forms.empty()) return;
    parity::Hypothesis h{fmt::format("{} as it is stored, without: {}", slot.name, forms)};
    h.change = [&slot, plain = spec](StageData& data) mutable {
        // Of a texture of two components the third is 0 and the fourth 1.
        if (io::encoded_components(io::parse_encoding(plain.encoding)) == 2)
            plain.channels = (plain.channels.empty() ? "xy" : plain.channels.substr(0, 2)) + "01";
        plain.encoding = "plain", plain.near_far.clear();
        return read_instead(slot, plain, data);
    };
    h.slack = parity::computed_slack;
    all.push_back(std::move(h));
}

}  // namespace

std::vector<parity::Hypothesis> other_dumps(const io::Manifest& manifest, const io::ManifestStage& stage,
                                            const StageBinding& binding) {
    std::vector<parity::Hypothesis> all;
    for (const Slot& slot : binding.inputs) {
        const auto own = stage.inputs.find(slot.name);
        if (own == stage.inputs.end() || slot.kind != SlotKind::image || slot.dtype != DType::f32) continue;
        add_undecoded(slot, own->second, all);
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
    if (rsm::is_sampled(binding))
        for (rsm::SamplingGuess& guess : rsm::sampling_guesses()) {
            parity::Hypothesis h{std::move(guess.text)};
            h.change = std::move(guess.change);
            all.push_back(std::move(h));
        }
    return all;
}

}  // namespace plumb::cli
