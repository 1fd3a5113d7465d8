#include "tools/plumb/stage_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "core/inexact_inputs.h"
#include "core/nearest_known.h"
#include "gi/frame/frame_graph.h"
#include "gi/parity/stages.h"
#include "io/file.h"
#include "io/scene_file.h"
#include "raster/light_view.h"
#include "tools/plumb/case_pattern.h"
#include "tools/plumb/case_sampling.h"
#include "tools/plumb/case_uniforms.h"
#include "tools/plumb/coverage.h"
#include "tools/plumb/input_forms.h"
#include "tools/plumb/output_forms.h"
#include "tools/plumb/slot_array.h"
#include "tools/shared/options.h"

namespace plumb::cli {

namespace {

std::string slot_place(const io::ManifestStage& stage, const std::string& kind, const std::string& name) {
    return fmt::format("{}: {}.{}", stage.place, kind, name);
}

std::string joined(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

std::vector<std::string> slot_names(const std::vector<Slot>& slots) {
    std::vector<std::string> names;
    for (const Slot& slot : slots) names.push_back(slot.name);
    return names;
}

const Slot* find_slot(const std::vector<Slot>& slots, const std::string& name) {
    const auto at = std::find_if(slots.begin(), slots.end(), [&](const Slot& s) { return s.name == name; });
    return at == slots.end() ? nullptr : &*at;
}

// ---- Parameters ---------------------------------------------------------------------------------------------------

FieldValue field_value(const std::vector<std::string>& words) {
    if (words.size() == 1) return parse_value(words[0]);
    return parse_value(fmt::format("[{}]", joined(words)));
}

// The table of settings that holds a parameter of the stage: the one that says the same of it.
std::string table_of(frame::Settings& settings, const StageBinding& binding, const std::string& key, const std::string& place) {
    for (const ParamInfo& param : binding.info.params)
        for (const std::string& table : frame::method_tables())
            for (const ParamInfo& other : describe(frame::table_fields(settings, table, place)))
                if (param.name == key && other.name == key && other.meaning == param.meaning) return table;
    return "";
}

void set_params(frame::Settings& settings, const io::ManifestStage& stage, const StageBinding& binding) {
    std::vector<std::string> known;
    for (const ParamInfo& param : binding.info.params) known.push_back(param.name);
    for (const auto& [key, words] : stage.params) {
        if (binding.raster && key == "reversed_z") continue;
        const std::string place = stage.place + ": params";
        const std::string table = table_of(settings, binding, key, place);
        if (std::find(known.begin(), known.end(), key) == known.end() || table.empty()) {
            if (known.empty()) throw InputError(fmt::format("{}: {}: the stage has no parameters", place, key));
            throw InputError(fmt::format("{}: unknown parameter \"{}\"{}", place, key, nearest_known(key, known, "\"\"")));
        }
        std::vector<Field> fields = frame::table_fields(settings, table, place);
        set_field(find_field(fields, key, place), field_value(words), place);
    }
}

bool reversed_z(const io::ManifestStage& stage, bool otherwise) {
    const auto given = stage.params.find("reversed_z");
    if (given == stage.params.end()) return otherwise;
    const FieldValue value = field_value(given->second);
    if (const bool* reversed = std::get_if<bool>(&value)) return *reversed;
    throw InputError(stage.place + ": params: reversed_z: expected true or false");
}

// ---- Inputs -------------------------------------------------------------------------------------------------------

int light_index(const Scene& scene, const std::string& name, const std::string& place) {
    std::vector<std::string> names;
    for (const Light& light : scene.lights) names.push_back(light.name);
    const auto at = std::find(names.begin(), names.end(), name);
    if (at != names.end()) return int(at - names.begin());
    if (names.empty()) throw InputError(fmt::format("{}: \"{}\": the scene has no light", place, name));
    throw InputError(fmt::format("{}: unknown light \"{}\"{}", place, name, nearest_known(name, names, "\"\"")));
}

// "visibility.2", or "visibility.key" of a scene's light: one layer of an array of images; else -1.
int layer_of(const std::string& name, const Slot& slot, const Scene* scene, const std::string& place) {
    if (slot.kind != SlotKind::image_array || !name.starts_with(slot.name + ".")) return -1;
    const std::string layer = name.substr(slot.name.size() + 1);
    if (!layer.empty() && layer.size() < 6 && layer.find_first_not_of("0123456789") == std::string::npos)
        return std::stoi(layer);
    return scene ? light_index(*scene, layer, place) : -1;
}

// Layers that were dumped one by one, below each other.
void add_layer(StageData& data, const Slot& slot, int layer, Array image, const std::string& place) {
    const std::size_t bytes = image.bytes.size();
    if (layer > 1024) throw InputError(fmt::format("{}: expected a layer below 1024", place));
    if (!find(data.inputs, slot.name)) add(data.inputs, slot.name, slot.dtype, {0, data.size.y, data.size.x});
    Array& array = *std::find_if(data.inputs.arrays.begin(), data.inputs.arrays.end(),
                                 [&](const Array& a) { return a.name == slot.name; });
    array.shape[0] = std::max<std::int64_t>(array.shape[0], layer + 1);
    array.bytes.resize(std::size_t(array.shape[0]) * bytes);
    std::copy(image.bytes.begin(), image.bytes.end(), array.bytes.begin() + std::ptrdiff_t(bytes * std::size_t(layer)));
}

// What one of the manifest's inputs brings: the array that the stage reads, and how far a device's own may be from it.
struct ReadInput {
    Array array, moved;
};
ReadInput read_input(const io::DumpSpec& spec, const Slot& slot, const Precision& precision, const std::string& place,
                     StageCase& out) {
    io::DumpedImage dump = io::read_dump(spec);
    Array moved = form_input(spec, slot, precision, out.covered, place, dump, out.notes);
    const unsigned channels = dump.channels;
    ReadInput read{input_array(slot, std::move(dump), out.data.size, place, out.notes), std::move(moved)};
    if (read.moved.bytes.empty() || read.moved.shape == read.array.shape) return read;
    // Of fewer components than a texel of the dump has.
    const std::string name = read.moved.name;
    std::vector<std::string> said;
    io::DumpedImage of_slot;
    of_slot.array = std::move(read.moved);
    of_slot.channels = channels;
    read.moved = input_array(slot, std::move(of_slot), out.data.size, place, said);
    read.moved.name = name;
    return read;
}

void set_inputs(const io::ManifestStage& stage, const StageBinding& binding, const Scene* scene,
                const Precision& precision, StageCase& out) {
    const bool takes_pattern = pattern_slot(binding);
    StageData& data = out.data;
    std::map<std::string, int> layers;
    for (const auto& [name, spec] : stage.inputs) {
        const std::string place = slot_place(stage, "input", name);
        if (takes_pattern && name == "pattern") continue;
        const Slot* slot = find_slot(binding.inputs, name);
        int layer = -1;
        for (const Slot& s : binding.inputs) {
            if (slot || (layer = layer_of(name, s, scene, place)) < 0) continue;
            slot = &s;
        }
        if (!slot) {
            std::vector<std::string> known = slot_names(binding.inputs);
            if (takes_pattern) known.push_back("pattern");
            throw InputError(fmt::format("{}: unknown input{}", place, nearest_known(name, known, "\"\"")));
        }
        ReadInput read = read_input(spec, *slot, precision, place, out);
        if (layer >= 0)
            add_layer(data, *slot, layer, std::move(read.array), place);
        else
            replace(data.inputs, std::move(read.array));
        if (!read.moved.bytes.empty()) replace(data.inputs, std::move(read.moved));
        if (layer >= 0) ++layers[slot->name];
    }
    for (const auto& [name, count] : layers)
        if (count != at(data.inputs, name).shape[0])
            throw InputError(fmt::format("{}: input.{}: {} of {} layers were dumped", stage.place, name, count,
                                         at(data.inputs, name).shape[0]));
    if (const auto pattern = stage.inputs.find("pattern"); takes_pattern && pattern != stage.inputs.end())
        set_pattern(binding, pattern->second, slot_place(stage, "input", "pattern"), data);

    std::vector<std::string> missing;
    for (const Slot& slot : binding.inputs) {
        if (find(data.inputs, slot.name)) continue;
        if (slot.optional)
            out.notes.push_back(slot.name + ": was not dumped; it is 0 everywhere");
        else
            missing.push_back("input." + slot.name);
    }
    if (missing.empty()) return;
    const bool buffers = std::any_of(binding.inputs.begin(), binding.inputs.end(), [&](const Slot& s) {
        return !s.optional && s.kind == SlotKind::buffer && !find(data.inputs, s.name);
    });
    throw InputError(fmt::format("{}: missing: {}{}", stage.place, joined(missing),
                                 buffers ? "; dump them, or name a scene, which gives buffers" : "; dump them"));
}

// The size of what was dumped at the outputs' size, where the manifest does not say it.
glm::ivec2 size_of(const io::ManifestStage& stage, const StageBinding& binding) {
    if (stage.width > 0 && stage.height > 0) return {stage.width, stage.height};
    for (const auto* specs : {&stage.outputs, &stage.inputs})
        for (const auto& [name, spec] : *specs) {
            const bool output = specs == &stage.outputs;
            const Slot* slot = find_slot(output ? binding.outputs : binding.inputs, name);
            if (!slot || (!output && !slot->frame)) continue;
            if (slot->kind == SlotKind::buffer || slot->kind == SlotKind::image_array) continue;
            if (slot->kind == SlotKind::storage_buffer && spec.count) return {spec.count, 1};
            const std::string place = slot_place(stage, output ? "output" : "input", name);
            return image_size(io::read_dump(spec).array, place);
        }
    throw InputError(stage.place + ": expected size = [width, height], or an output");
}

// A list as one of items, in the order of the domain.
void fit_list(const Slot& slot, io::DumpedImage& dump, glm::ivec2 size, const std::string& place) {
    const std::int64_t items = std::int64_t(size.x) * size.y, found = std::int64_t(dump.array.bytes.size() / 4 / std::size_t(slot.channels));
    if (found != items)
        throw InputError(fmt::format("{}: {} elements of {}: expected {}", place, found, slot.channels, items));
    for (Array* array : {&dump.array, &dump.rounding})
        if (!array->bytes.empty()) array->shape = {size.y, size.x, slot.channels};
}

void read_outputs(const io::ManifestStage& stage, const StageBinding& binding, StageCase& out) {
    if (stage.outputs.empty()) throw InputError(stage.place + ": has no output: expected what the device wrote");
    for (const auto& [name, spec] : stage.outputs) {
        const std::string place = slot_place(stage, "output", name);
        const Slot* slot = find_slot(binding.outputs, name);
        if (!slot)
            throw InputError(fmt::format("{}: unknown output{}", place, nearest_known(name, slot_names(binding.outputs), "\"\"")));
        if (slot->kind == SlotKind::depth && spec.near_far.size() > 0)
            throw InputError(fmt::format("{}: encoding = \"{}\" gives linear depth: expected the depth buffer as it is, "
                                         "plain, and reversed_z = true in [stage.params] where 1 is near", place,
                                         spec.encoding));
        const bool list = slot->kind == SlotKind::storage_buffer;
        if (!list && spec.count) throw InputError(place + ": count: the output is an image; expected width and height");
        io::DumpedImage dump = io::read_dump(spec);
        if (list) fit_list(*slot, dump, out.data.size, place);
        fit_output(*slot, dump, out.data.size, place);
        parity::Dumped dumped{name, std::move(dump.array), dump.stored, dump.channels & ((1u << slot->channels) - 1)};
        if (dumped.channels == 0) throw InputError(place + ": none of the output's channels was dumped");
        dumped.unwritten = std::move(dump.unwritten);
        if (!dump.absent.empty()) dumped.absent = io::shown(spec.file.string()) + " " + dump.absent;
        dumped.rounding = std::move(dump.rounding), dumped.lowest = dump.lowest, dumped.highest = dump.highest;
        out.dumped.push_back(std::move(dumped));
    }
}

// Of what was dumped: the verdict calls what follows from NaN wrong, and this is why.
void note_not_finite(const io::ManifestStage& stage, StageCase& out) {
    for (const Array& array : out.data.inputs.arrays) {
        const bool dumped = std::any_of(stage.inputs.begin(), stage.inputs.end(), [&](const auto& input) {
            return input.first == array.name || input.first.starts_with(array.name + ".");
        });
        if (array.dtype != DType::f32 || !dumped || array.name.ends_with(moved_name(""))) continue;
        const float* values = floats(out.data, array.name);
        const auto count = std::count_if(values, values + array.bytes.size() / sizeof(float),
                                         [](float v) { return !std::isfinite(v); });
        if (count > 0)
            out.notes.push_back(fmt::format("input {}: {} value{} not finite", array.name, count,
                                            count == 1 ? " is" : "s are"));
    }
}

// [height][width][n] of int32: what the device chose where an invocation had a choice.
void read_choices(const io::ManifestStage& stage, StageCase& out) {
    if (stage.choices.file.empty()) return;
    const std::string place = stage.place + ": choices";
    const Array array = io::read_dump(stage.choices).array;
    if (image_size(array, place) != out.data.size) throw InputError(place + ": expected the size of the outputs");
    for (double v : numbers(array, place)) {
        if (!(v == std::floor(v) && v >= -0x1p31 && v < 0x1p31))
            throw InputError(fmt::format("{}: holds {}: expected whole numbers of 32 bits", place, v));
        out.choices.push_back(std::int32_t(v));
    }
    out.choices_a_pixel = array.shape.size() == 3 ? int(array.shape[2]) : 1;
}

}  // namespace

std::vector<StageData> dispatches(const Scene& scene, const frame::Settings& settings, const frame::Plan& plan,
                                  const frame::Frame& frame, const frame::PlannedStage& stage) {
    frame::Plan one = plan;
    one.stages = {stage};
    return parity::frame_data(scene, settings, one, frame);
}

std::string face_of(const StageData& data) {
    for (const char* face : raster::face_names)
        if (data.id.ends_with(std::string(".") + face)) return face;
    return "";
}

CaseReader::CaseReader(const io::Manifest& manifest, const DeviceProfile& profile) : profile_(profile) {
    if (!manifest.scene.empty()) scene_ = io::load_scene(manifest.scene.string(), frame::method_tables());
}

namespace {

// Makes the stage's outputs as large as the manifest says: the light's maps, the frame, or one of which they are a half. The
// scene's own frame comes first: of half the size there are two along each axis, and a pixel's ray is another in each.
void set_size(Scene& scene, const frame::Settings& settings, const io::ManifestStage& stage, int light) {
    const glm::ivec2 size(stage.width, stage.height);
    auto fits = [&](bool whole) {
        const frame::FrameGraph graph(scene, settings, Geometry{});
        return std::any_of(graph.nodes().begin(), graph.nodes().end(), [&](const frame::PlannedNode& node) {
            return node.plan.name == stage.stage && (light < 0 || node.plan.light == light) && node.size().y == size.y &&
                   (!whole || node.size().x == size.x);
        });
    };
    if (parity::find_binding(stage.stage, stage.place).domain == "texel") {
        if (light >= 0) scene.lights[std::size_t(light)].rsm_size = size.x;
        return;
    }
    if (fits(true)) return;
    scene.frame_size = size;
    if (!fits(false)) scene.frame_size = 2 * size;
}

}  // namespace

// Uniforms, patterns and geometry; images have to be dumped.
StageData CaseReader::data_of_scene(const io::ManifestStage& stage, const StageBinding& binding) const {
    Scene scene = *scene_;
    const int light = stage.light.empty() ? -1 : light_index(scene, stage.light, stage.place);
    // Of a dispatch the manifest tells the size: gathers read what they are given.
    frame::Settings settings = frame::settings_of(scene);
    settings.indirect.resolution = filter::Resolution::full, settings.indirect.blur = filter::Blur::none;
    settings = frame::settings_running(settings, stage.stage, stage.form);
    settings.pruning = false;
    if (stage.width > 0 && stage.height > 0) set_size(scene, settings, stage, light);
    set_params(settings, stage, binding);

    // Of a stage that runs more than once, or once a light, and once a face, the manifest says which.
    const frame::Plan plan = frame::plan(scene, settings);
    std::vector<StageData> found;
    std::vector<std::string> ids;
    for (const frame::PlannedStage& planned : plan.stages) {
        if (planned.name != stage.stage || (light >= 0 && planned.light != light)) continue;
        if (!stage.form.empty() && !frame::has_form(planned, stage.form)) continue;
        for (StageData& data : dispatches(scene, settings, plan, {}, planned)) {
            if (!stage.face.empty() && face_of(data) != stage.face) continue;
            ids.push_back(data.label);
            found.push_back(std::move(data));
        }
    }
    if (found.empty())
        throw InputError(fmt::format("{}: the scene runs no {}{}{}{}", stage.place, stage.stage,
                                     stage.form.empty() ? "" : " of form " + stage.form,
                                     stage.light.empty() ? "" : " of the light " + stage.light,
                                     stage.face.empty() ? "" : ", face " + stage.face));
    if (found.size() > 1)
        throw InputError(fmt::format("{}: the scene runs it {} times: expected form, light, or face of a point light: {}",
                                     stage.place, found.size(), joined(ids)));
    StageData data = std::move(found[0]);
    std::erase_if(data.inputs.arrays, [&](const Array& array) {
        const Slot* slot = find_slot(binding.inputs, array.name);
        return !slot || slot->kind != SlotKind::buffer;
    });
    return data;
}

StageCase CaseReader::read(const io::ManifestStage& stage) const {
    StageCase out;
    out.binding = &parity::find_binding(stage.stage, stage.place);
    if (scene_) {
        const StageBinding& binding = *out.binding;
        out.data = data_of_scene(stage, binding);
    } else {
        const StageBinding& binding = *out.binding;
        // What is no parameter, or has no such value, is named first.
        frame::Settings settings;
        settings = frame::settings_running(settings, stage.stage);
        set_params(settings, stage, binding);
        for (const auto& [key, words] : stage.params)
            if (!binding.raster || key != "reversed_z")
                throw InputError(fmt::format("{}: params: {}: there is no scene whose settings it could replace",
                                             stage.place, key));
        out.data.stage = stage.stage;
        out.data.label = stage.stage + (stage.light.empty() ? "" : " (" + stage.light + ")");
        out.data.id = stage.stage + (stage.light.empty() ? "" : "." + file_name(stage.light));
        if (!stage.face.empty()) out.data.id += "." + file_name(stage.face);
        out.data.size = size_of(stage, binding);
    }
    out.data.reversed_z = reversed_z(stage, out.data.reversed_z);
    if (!stage.label.empty()) out.data.label = stage.label;
    // An export's label names the light, too.
    if (!scene_ && !stage.light.empty() && stage.label.empty())
        out.notes.push_back("light: there is no scene, so that \"" + stage.light + "\" is no more than a name");

    out.binding = &sampled_binding(stage, *out.binding, profile_, out.data);
    const StageBinding& binding = *out.binding;
    const bool whole = !out.data.uniforms.empty() || !stage.uniforms_file.empty();
    const bool pattern = pattern_slot(binding) && stage.inputs.count("pattern") > 0;
    set_uniforms(stage, binding, out.data);
    out.covered = read_coverage(stage, binding, out.data.size);
    set_inputs(stage, binding, scene_ ? &*scene_ : nullptr, profile_.precision, out);
    complete_uniforms(stage, binding, whole, pattern, out.data, out.notes);
    read_outputs(stage, binding, out);
    out.binding = &formed_binding(stage, binding, profile_.precision, out.data);
    apply_coverage(stage, out);
    note_not_finite(stage, out);
    read_choices(stage, out);
    return out;
}

}  // namespace plumb::cli
