// Every stage's inputs and outputs as files: pictures as EXR with the components of the render target, buffers as .npy.
#include <algorithm>
#include <list>
#include <map>
#include <nlohmann/json.hpp>

#include "gi/frame/frame_graph.h"
#include "gi/parity/stages.h"
#include "io/file.h"
#include "io/npy.h"
#include "tools/plumb/pictures.h"
#include "tools/shared/options.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

namespace {

// Files by what lies in them: what one stage writes and another reads is one file.
class Files {
  public:
    explicit Files(Outputs& outputs) : outputs_(outputs) {}

    // The file of an array; null of an empty picture. The array must stay where it is until all is written.
    Json file(const std::string& name, const Array& array, bool is_picture) {
        if (array.bytes.empty()) return is_picture ? Json(nullptr) : Json(buffer(name, array));
        const auto [at, is_new] = names_.try_emplace({array.bytes.data(), array.bytes.size()});
        if (is_new) at->second = is_picture ? picture(name, array) : buffer(name, array);
        return at->second;
    }

  private:
    std::string buffer(const std::string& name, const Array& array) {
        outputs_.write("dump/" + name + ".npy", [&](const std::string& path) {
            io::write_npy(path, array.dtype, array.shape, array.bytes.data());
        });
        return name + ".npy";
    }

    std::string picture(const std::string& name, const Array& array) {
        static const char* const components[] = {"R", "G", "B", "A"};
        const int stride = array.shape.size() == 3 ? int(array.shape[2]) : 1;
        const auto* values = reinterpret_cast<const float*>(array.bytes.data());
        Buffer<float> copy;
        if (array.dtype == DType::i32) {  // exact up to 2^24
            const auto* from = reinterpret_cast<const std::int32_t*>(array.bytes.data());
            copy.assign(from, from + array.bytes.size() / sizeof(std::int32_t));
            values = copy.data();
        }
        outputs_.write("dump/" + name + ".exr", [&](const std::string& path) {
            io::write_exr(path, int(array.shape[1]), int(array.shape[0]),
                          {{"color", {components, components + stride}, values, stride}});
        });
        return name + ".exr";
    }

    Outputs& outputs_;
    std::map<std::pair<const unsigned char*, std::size_t>, std::string> names_;
};

// A port of a point light is a list of six files, null where a face sees nothing.
class Ports {
  public:
    explicit Ports(const std::vector<Port>& ports) {
        for (const Port& port : ports) json_[port.name] = nullptr;
    }
    // Of an array's name, which stands behind its face's where there are several.
    bool has(const std::string& name) const { return json_.contains(port_of(name)); }
    void add(const std::string& name, const Json& file) {
        if (port_of(name) == name) return void(json_[name] = file);
        const auto* const face =
            std::find(std::begin(raster::face_names), std::end(raster::face_names), name.substr(0, name.find('.')));
        Json& of_faces = json_[port_of(name)];
        if (!of_faces.is_array()) of_faces = Json::array({nullptr, nullptr, nullptr, nullptr, nullptr, nullptr});
        of_faces[std::size_t(face - std::begin(raster::face_names))] = file;
    }
    const Json& json() const { return json_; }

  private:
    static std::string port_of(const std::string& name) {
        for (const char* face : raster::face_names)
            if (name.starts_with(std::string(face) + ".")) return name.substr(name.find('.') + 1);
        return name;
    }

    Json json_ = Json::object();
};

class Dump {
  public:
    Dump(const Scene& scene, const frame::Settings& settings, const frame::Frame& frame, const RunOptions& options,
         Outputs& outputs)
        : scene_(scene), options_(options), graph_(scene, settings, frame), files_(outputs) {
        for (const StageInfo& info : frame::all_stages()) infos_[info.name] = info;
    }

    // What nodes without a row of their own made: the sum of gathers, the truth's picture.
    void add_sums() {
        for (const frame::PlannedNode& node : graph_.nodes()) {
            if (node.listed) continue;
            const Bundle outputs = node.outputs();
            for (const Array& array : outputs.arrays) files_.file(graph_.file_name(node) + "." + array.name, array, true);
        }
    }

    Json stage(const frame::PlannedStage& s) {
        const frame::PlannedNode& node = graph_.node(s);
        // The frame keeps the sum over the lights; each light's share is gathered again.
        graph::NodeRun run;
        if (node.adds) node.run(options_, run);
        const StageInfo& info = infos_.at(s.name);
        Ports outputs(info.outputs), inputs(info.inputs);
        for (const Array& array : kept_.emplace_back(node.outputs()).arrays)
            if (!array.bytes.empty()) add(node, array, !is_records(array), outputs);
        if (node.inputs)
            for (const Array& array : kept_.emplace_back(node.inputs()).arrays) add(node, array, is_image(array), inputs);
        else if (node.dispatches)
            add_inputs(node, kept_data_.emplace_back(node.dispatches()), inputs);

        Json json = {{"stage", s.name}};
        if (s.light >= 0) json["light"] = scene_.lights[std::size_t(s.light)].name;
        if (!s.form.empty()) json["form"] = s.form;
        if (s.view > 0) json["view"] = node.view_name;
        if (!s.layer.empty()) json["layer"] = s.layer;
        json["inputs"] = inputs.json();
        json["outputs"] = outputs.json();
        return json;
    }

  private:
    void add(const frame::PlannedNode& node, const Array& array, bool is_picture, Ports& ports, const std::string& face = "") {
        const std::string name = face + array.name;
        if (ports.has(name)) ports.add(name, files_.file(graph_.file_name(node) + "." + name, array, is_picture));
    }
    static bool is_records(const Array& array) { return array.shape.size() == 3 && array.shape[2] > 4; }
    static bool is_image(const Array& array) {
        return array.shape.size() == 3 && !is_records(array) && array.dtype == DType::f32;
    }

    // What the dispatches bind: what all of them do once, other arrays under their faces' names.
    void add_inputs(const frame::PlannedNode& node, const std::vector<StageData>& all, Ports& ports) {
        for (const StageData& data : all)
            for (const Slot& slot : parity::find_binding(data.stage, data.label).inputs) {
                const Array* array = find(data.inputs, slot.name);
                if (!array) continue;
                const bool shared = std::all_of(all.begin(), all.end(), [&](const StageData& other) {
                    const Array* own = find(other.inputs, slot.name);
                    return own && own->bytes == array->bytes;
                });
                if (shared && &data != &all.front()) continue;
                add(node, *array, slot.kind == SlotKind::image, ports, shared || data.id.empty() ? "" : data.id + ".");
            }
    }

    const Scene& scene_;
    const RunOptions& options_;
    frame::FrameGraph graph_;
    Files files_;
    std::map<std::string, StageInfo> infos_;
    // Until all is written: files are told apart by where their content lies.
    std::list<Bundle> kept_;
    std::list<std::vector<StageData>> kept_data_;
};

}  // namespace

void write_dump(const Scene& scene, const frame::Settings& settings, const frame::Plan& plan, const frame::Frame& frame,
                const RunOptions& options, Outputs& outputs) {
    Dump dump(scene, settings, frame, options, outputs);
    dump.add_sums();
    Json stages = Json::array();
    for (const frame::PlannedStage& s : frame::plan_after_run(plan, frame).stages)
        if (s.needed) stages.push_back(dump.stage(s));
    const Json json = {{"settings", settings_json(settings)}, {"stages", stages}};
    outputs.write("dump/dump.json", [&](const std::string& path) { io::write_text(path, json_text(json)); });
}

}  // namespace plumb::cli
