// Every stage's inputs and outputs as files: pictures as EXR with the four components of the render target, buffers as
// .npy.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "gi/direct/log_blur.h"
#include "gi/frame/filters.h"
#include "gi/frame/isr.h"
#include "gi/parity/stages.h"
#include "gi/frame/frame.h"
#include "gi/reference/ray_query.h"
#include "gi/reference/lights.h"
#include "io/file.h"
#include "io/npy.h"
#include "raster/light_view.h"
#include "raster/surfaces.h"
#include "tools/plumb/pictures.h"
#include "tools/shared/options.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

namespace {

struct Dumper {
    Outputs& outputs;
    std::vector<std::string> written;

    // Each writes a file unless it is there already, and returns its name.
    std::string once(const std::string& file, const std::function<void(const std::string& path)>& write) {
        if (std::find(written.begin(), written.end(), file) == written.end()) {
            written.push_back(file);
            outputs.write("dump/" + file, write);
        }
        return file;
    }
    std::string picture(const std::string& name, int width, int height, std::vector<std::string> components,
                        const float* data) {
        return once(name + ".exr", [&](const std::string& path) {
            const int stride = int(components.size());
            io::write_exr(path, width, height, {{"color", components, data, stride}});
        });
    }
    std::string picture(const std::string& name, const Image4& image) {
        return picture(name, image.width, image.height, {"R", "G", "B", "A"}, &image.data()->x);
    }
    template <class T>
    std::string array(const std::string& name, const Shape& shape, const T* data) {
        return once(name + ".npy", [&](const std::string& path) { io::write_npy(path, dtype_of<T>, shape, data); });
    }
};

struct Dump {
    const Scene& scene;
    const frame::Settings& settings;
    const frame::Plan& plan;
    const frame::Frame& frame;
    const RunOptions& options;
    Dumper files;

    std::vector<std::string> lights;
    Geometry geometry;
    raster::Surfaces surfaces;
    std::unique_ptr<RayQuery> rays;  // built for rsm.all_rays alone

    // What the two raster passes read.
    Json surface_inputs() {
        const std::int64_t triangles = geometry.triangles.size(), materials = surfaces.masked.size();
        return {
            {"vertices", files.array("scene.vertices", {std::int64_t(geometry.vertices.size()), 8},
                                     reinterpret_cast<const float*>(geometry.vertices.data()))},
            {"triangles", files.array("scene.triangles", {triangles, 3},
                                      reinterpret_cast<const std::uint32_t*>(geometry.triangles.data()))},
            {"material", files.array("scene.material", {triangles}, geometry.material.data())},
            {"materials", files.array("scene.materials", {materials, 16}, surfaces.materials.data())},
            {"textures",
             files.array("scene.textures", {std::int64_t(surfaces.textures.size() / 4), 4}, surfaces.textures.data())},
            {"texels", files.array("scene.texels", {std::int64_t(surfaces.texels.size())}, surfaces.texels.data())},
            {"decode", files.array("scene.decode", {2, 256}, surfaces.decode.data())},
            {"tangents", files.array("scene.tangents", {std::int64_t(geometry.tangents.size()), 4},
                                     reinterpret_cast<const float*>(geometry.tangents.data()))}};
    }

    Json gbuffer_outputs() {
        const raster::GBuffer& g = frame.gbuffer;
        const Buffer<float> id = id_floats(g.id);
        return {{"position", files.picture("gbuffer.position", g.position)},
                {"normal", files.picture("gbuffer.normal", g.normal)},
                {"albedo", files.picture("gbuffer.albedo", g.albedo)},
                {"emission", files.picture("gbuffer.emission", g.emission)},
                {"depth", files.picture("gbuffer.depth", g.depth.width, g.depth.height, {"R"}, g.depth.data())},
                {"id", files.picture("gbuffer.id", g.id.width, g.id.height, {"R", "G"}, id.data())}};
    }

    Json map_outputs(int l, int map) {
        const raster::Rsm& r = frame.rsms[l][map];
        const std::string name = map_name(frame, lights, l, map) + ".";
        const std::int64_t side = r.size;
        Json ports = {{"position", files.picture(name + "position", r.position)},
                      {"normal", nullptr}, {"flux", nullptr}, {"records", nullptr}};
        if (r.flux.empty()) return ports;  // drawn for its depth alone
        ports["normal"] = files.picture(name + "normal", r.normal);
        ports["flux"] = files.picture(name + "flux", r.flux);
        ports["records"] = r.half ? files.array(name + "records", {side, side, 16}, r.half_records.data())
                                  : files.array(name + "records", {side, side, 16}, r.records.data());
        return ports;
    }

    // A port of a point light is a list of six files, null where a face sees nothing.
    Json rsm_outputs(int l) {
        if (frame.rsms[l].size() == 1) return map_outputs(l, 0);
        Json ports;
        for (const char* port : {"position", "normal", "flux", "records"}) ports[port] = Json::array();
        for (int m = 0; m < int(frame.rsms[l].size()); ++m) {
            const Json map = frame.rsms[l][m].size > 0 ? map_outputs(l, m) : Json::object();
            for (auto& [port, files_of_port] : ports.items()) files_of_port.push_back(map.value(port, Json(nullptr)));
        }
        return ports;
    }

    // What a pass of shadow.blur makes, listed as rsm_outputs() lists.
    Json blurred_maps(int l, const std::string& form) {
        const std::vector<Image4>& maps = (form == "horizontal" ? frame.maps_blurred_across : frame.maps_blurred)[l];
        Json all = Json::array();
        for (int m = 0; m < int(maps.size()); ++m) {
            const std::string face = maps.size() > 1 ? std::string(".") + raster::face_names[m] : "";
            all.push_back(maps[m].empty() ? Json(nullptr)
                                          : Json(files.picture("shadow.blur." + form + "." + lights[l] + face, maps[m])));
        }
        return all.size() == 1 ? all[0] : all;
    }

    std::string visibility(int l) {
        const Image4& size = frame.gbuffer.position;
        return files.picture("shadow." + lights[l] + ".visibility", size.width, size.height, {"R"},
                             frame.visibility.data() + l * size.size());
    }

    // The frame keeps the sum over the lights; each light's share is gathered again.
    void irradiance(const frame::PlannedStage& s, const rsm::Pattern& pattern, Json& outputs) {
        if (s.name == "rsm.all_rays" && !rays) rays = reference::build_ray_query(geometry, surfaces, settings.rsm.rays);
        Image4 image;
        rsm::RaysReport report;
        rsm::run_maps(settings.rsm,
                      frame::gather_inputs(scene, settings, frame, s.light, geometry, pattern, rays.get()),
                      frame.rsms[s.light], options, image, &report);
        const std::string name = s.name + "." + lights[s.light] + ".";
        outputs["irradiance"] = files.picture(name + "irradiance", image);
        if (rays) outputs["standard_error"] = files.picture(name + "standard_error", report.standard_error);
    }

    void gather(const frame::PlannedStage& s, Json& inputs, Json& outputs) {
        const int l = s.light;
        const rsm::Pattern pattern = rsm::pattern_of(settings.rsm, scene.lights[l].rsm_size, settings.seed);
        inputs = gather_points();
        const Json map = rsm_outputs(l);
        if (settings.rsm.gather == rsm::Gather::all_rays)
            inputs["rsm"] = map["records"];
        else
            for (const char* part : {"position", "normal", "flux"}) inputs[std::string("rsm_") + part] = map[part];
        if (pattern.samples > 0) {
            const bool paths = settings.rsm.gather == rsm::Gather::paths;
            const std::int64_t samples = pattern.samples, rotations = pattern.rotations;
            const std::string name = s.name + "." + lights[l] + ".";
            if (pattern.positions.empty())
                inputs["offsets"] = files.array(name + "offsets", {samples, rotations}, pattern.offsets.data());
            else
                inputs["positions"] = files.array(name + "positions", {samples, rotations, 2}, pattern.positions.data());
            const Shape weighed = paths ? Shape{samples, rotations} : Shape{samples};
            inputs["weights"] = files.array(name + "weights", weighed, pattern.weights.data());
            const Buffer<float> edges = rsm::slot_edges(settings.rsm);
            if (paths) inputs["edges"] = files.array(name + "edges", {std::int64_t(edges.size())}, edges.data());
        }
        irradiance(s, pattern, outputs);
    }

    // A path traced layer: of the camera's pixels, or of the G-buffer's points by the method's own transport.
    void traced(const frame::PlannedStage& s, Json& inputs, Json& outputs) {
        const bool own = frame::own_transport(s.layer);
        const Scene seen = own ? frame::lamps_only(scene) : scene;
        const raster::Surfaces seen_surfaces = raster::prepare(seen, geometry);
        const auto table =
            reference::light_table(seen, geometry, seen_surfaces, reference::environment_table(seen.environment));
        const std::string base = own ? "reference.lamps." : "reference.";
        inputs = surface_inputs();
        inputs["materials"] = files.array(base + "materials", {std::int64_t(seen_surfaces.masked.size()), 16},
                                          seen_surfaces.materials.data());
        inputs["lights"] = files.array(base + "lights", {table.count, 16}, table.rows.data());
        inputs["position"] = inputs["normal"] = nullptr;
        if (own) inputs.update(surface_points());
        const reference::Estimate& e = frame::find_traced(frame, s.layer)->estimate;
        const std::string name = s.layer == "color" ? "truth" : s.layer;
        outputs = {{"truth", files.picture(name, e.mean)}, {"truth.error", files.picture(name + ".error", e.error)}};
    }

    // What the picture is made of, named after the stage that made it.
    std::string radiance() {
        return files.picture(frame::find_traced(frame, "color") ? "truth" : "compose.radiance", frame.radiance);
    }

    Json surface_points() {
        const Json g = gbuffer_outputs();
        return {{"position", g["position"]}, {"normal", g["normal"]}};
    }

    // As filters of the indirect light leave them: gi/frame/filters.h names the files.
    std::string filtered(const frame::PlannedStage& s) {
        return files.picture(frame::filter_place(settings, s), frame::filter_result(frame, settings, s));
    }

    Json gather_points() {
        if (!frame::halves_indirect(settings)) return surface_points();
        return {{"position", files.picture("half_position", frame.half_position)},
                {"normal", files.picture("half_normal", frame.half_normal)}};
    }

    void filter(const frame::PlannedStage& s, Json& inputs, Json& outputs) {
        const Json points = surface_points();
        if (s.name == "filter.reduce") {
            inputs = {{"full", points.at(s.form)}};
            outputs = {{"reduced", filtered(s)}};
        } else if (s.name == "filter.upsample") {
            const Json half = gather_points();
            inputs = {{"coarse_irradiance", files.picture("gathered", frame.gathered)},
                      {"coarse_position", half.at("position")}, {"coarse_normal", half.at("normal")},
                      {"position", points.at("position")}, {"normal", points.at("normal")}};
            outputs = {{"upsampled", filtered(s)}};
        } else {
            const filter::BlurInputs in = frame::blur_inputs(settings, frame, s);
            const Buffer<float> spatial = filter::spatial_weights(settings.indirect, in.direction);
            const char* from = in.irradiance == &frame.gathered    ? "gathered"
                               : in.irradiance == &frame.upsampled ? "upsampled"
                                                                   : "blurred_across";
            const std::string name = s.name + (s.form.empty() ? "" : "." + s.form) + ".spatial";
            inputs = {{"irradiance", files.picture(from, *in.irradiance)},
                      {"position", points.at("position")}, {"normal", points.at("normal")},
                      {"spatial", files.array(name, {std::int64_t(spatial.size())}, spatial.data())}};
            outputs = {{"blurred", filtered(s)}};
        }
    }

    // Image-space radiosity, as its stages bind what they read.
    void image_space(const frame::PlannedStage& s, Json& inputs, Json& outputs) {
        frame::Plan one = plan;
        one.stages = {s};
        for (const StageData& data : parity::frame_data(scene, settings, one, frame)) {
            for (const Array& a : data.inputs.arrays) {
                const std::string name = data.id + "." + a.name;
                inputs[a.name] = a.dtype == DType::i32
                                     ? files.array(name, a.shape, reinterpret_cast<const std::int32_t*>(a.bytes.data()))
                                     : files.array(name, a.shape, reinterpret_cast<const float*>(a.bytes.data()));
            }
            const std::string made = parity::find_binding(s.name, s.label).outputs[0].name;
            outputs[made] = files.picture(data.id + "." + made, frame::isr_result(frame, s));
        }
    }

    // A view beside the frame: what image-space radiosity reads of it.
    void other_view(const frame::PlannedStage& s, Json& outputs) {
        const frame::SourceView& view = frame.views[std::size_t(s.view)];
        const std::string name = file_name(view.name) + ".";
        if (frame::draws_view(s.name))
            outputs = {{"position", files.picture(name + "gbuffer.position", view.gbuffer.position)},
                       {"normal", files.picture(name + "gbuffer.normal", view.gbuffer.normal)},
                       {"albedo", files.picture(name + "gbuffer.albedo", view.gbuffer.albedo)},
                       {"emission", files.picture(name + "gbuffer.emission", view.gbuffer.emission)}};
        if (s.name == "direct") outputs = {{"irradiance", files.picture(name + "direct.irradiance", view.direct)}};
    }

    void direct(Json& inputs, Json& outputs) {
        std::vector<raster::LightArgs> args;
        inputs = surface_points();
        inputs["visibility"] = Json::array();
        for (int l = 0; l < int(scene.lights.size()); ++l) {
            Light light = scene.lights[l];
            if (!light.on) light.intensity = glm::vec3(0);
            args.push_back(raster::light_args(light));
            inputs["visibility"].push_back(visibility(l));
        }
        inputs["lights"] =
            files.array("direct.lights", {std::int64_t(args.size()), 16}, reinterpret_cast<const float*>(args.data()));
        outputs["irradiance"] = files.picture("direct.irradiance", frame.direct);
    }

    Json stage(const frame::PlannedStage& s) {
        Json inputs = Json::object(), outputs = Json::object();
        if (frame::is_isr(s.name)) {
            image_space(s, inputs, outputs);
        } else if (s.view > 0) {
            other_view(s, outputs);
        } else if (s.name == "gbuffer") {
            inputs = surface_inputs();
            outputs = gbuffer_outputs();
        } else if (s.name == "rsm") {
            inputs = surface_inputs();
            outputs = rsm_outputs(s.light);
        } else if (s.name == "shadow.blur") {
            const bool first = s.form == "horizontal";
            inputs["depth_map"] = first ? rsm_outputs(s.light)["position"] : blurred_maps(s.light, "horizontal");
            outputs["blurred"] = blurred_maps(s.light, s.form);
        } else if (s.name == "shadow") {
            inputs = surface_points();
            inputs["map_position"] = direct::blurs_maps(settings.shadow) ? blurred_maps(s.light, "vertical")
                                                                         : rsm_outputs(s.light)["position"];
            outputs["visibility"] = visibility(s.light);
        } else if (s.name == "direct") {
            direct(inputs, outputs);
        } else if (frame::is_filter(s.name)) {
            filter(s, inputs, outputs);
        } else if (s.name == "compose") {
            const Json g = gbuffer_outputs();
            inputs = {{"normal", g["normal"]}, {"albedo", g["albedo"]}, {"emission", g["emission"]}};
            inputs["direct"] = files.picture("direct.irradiance", frame.direct);
            inputs["indirect"] = files.picture("indirect", frame.indirect);
            outputs["radiance"] = files.picture("compose.radiance", frame.radiance);
        } else if (s.name == "reference") {
            traced(s, inputs, outputs);
        } else if (s.name == "tonemap") {
            inputs["radiance"] = radiance();
            outputs["display"] = files.picture("tonemap.display", frame.display);
        } else {
            gather(s, inputs, outputs);
        }
        Json json = {{"stage", s.name}};
        if (s.light >= 0) json["light"] = scene.lights[s.light].name;
        if (!s.form.empty()) json["form"] = s.form;
        if (s.view > 0) json["view"] = frame.views[std::size_t(s.view)].name;
        if (!s.layer.empty()) json["layer"] = s.layer;
        json["inputs"] = inputs;
        json["outputs"] = outputs;
        return json;
    }
};

}  // namespace

void write_dump(const Scene& scene, const frame::Settings& settings, const frame::Plan& plan, const frame::Frame& frame,
                const RunOptions& options, Outputs& outputs) {
    Dump dump{scene, settings, plan, frame, options, {outputs, {}}, light_file_names(scene), flatten(scene), {}, {}};
    dump.surfaces = raster::prepare(scene, dump.geometry);
    Json stages = Json::array();
    for (const frame::PlannedStage& s : frame::as_it_ran(plan, frame).stages)
        if (s.needed) stages.push_back(dump.stage(s));
    const Json json = {{"settings", settings_json(settings)}, {"stages", stages}};
    outputs.write("dump/dump.json", [&](const std::string& path) { io::write_text(path, json_text(json)); });
}

}  // namespace plumb::cli
