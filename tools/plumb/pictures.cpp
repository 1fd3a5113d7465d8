#include "tools/plumb/pictures.h"

#include "gi/compose/compose.h"
#include "io/file.h"
#include "raster/light_view.h"
#include "tools/shared/options.h"

namespace plumb::cli {

namespace {

const std::vector<std::string> rgb = {"R", "G", "B"}, xyz = {"X", "Y", "Z"};

io::Layer layer(const std::string& name, const std::vector<std::string>& components, const Image4& image) {
    return {name, components, &image.data()->x, 4};
}

}  // namespace

Buffer<float> id_floats(const Image<glm::ivec2>& id) {
    Buffer<float> floats;
    floats.reserve(2 * id.size());
    for (const glm::ivec2& i : id.texels) {
        floats.push_back(float(i.x));
        floats.push_back(float(i.y));
    }
    return floats;
}

std::string map_name(const frame::Frame& frame, const std::vector<std::string>& lights, int light, int map) {
    const std::string name = "rsm." + lights[std::size_t(light)];
    return frame.rsms[std::size_t(light)].size() == 1 ? name : name + "." + raster::face_names[map];
}

bool runs(const frame::Plan& plan, const std::string& stage, int light) {
    for (const frame::PlannedStage& s : plan.stages)
        if (s.name == stage && s.light == light) return s.needed;
    return false;
}

std::string picture_name(const Scene& scene) { return file_name(io::stem_of(scene.name)); }

void write_pictures(const Scene& scene, const frame::Plan& plan, const frame::Frame& frame, const std::string& name,
                    Outputs& outputs, const frame::MirrorClasses* classes) {
    const std::vector<std::string> lights = light_file_names(scene);
    const frame::Plan ran = frame::plan_after_run(plan, frame);
    const raster::GBuffer& g = frame.gbuffer;
    const std::size_t pixels = frame.radiance.size();

    // Everything of the camera's size goes into one file.
    const Buffer<float> id = id_floats(g.id);
    std::vector<io::Layer> layers = {layer("color", rgb, frame.radiance)};
    if (!frame::find_traced(frame, "color")) {
        layers.push_back(layer("direct", rgb, frame.direct));
        layers.push_back(layer("indirect", rgb, frame.indirect));
    }
    for (const io::Layer& always :
         {layer("albedo", rgb, g.albedo), layer("emission", rgb, g.emission), layer("position", xyz, g.position),
          layer("normal", xyz, g.normal), io::Layer{"depth", {"Z"}, &g.position.data()->w, 4},
          io::Layer{"zbuffer", {"Z"}, g.depth.data(), 1}, io::Layer{"id", {"X", "Y"}, id.data(), 2}})
        layers.push_back(always);
    for (const frame::Traced& traced : frame.traced) {
        const bool picture = traced.layer == "color";
        if (!picture) layers.push_back(layer(traced.layer, rgb, traced.estimate.mean));
        layers.push_back(layer(picture ? "truth.error" : traced.layer + ".error", rgb, traced.estimate.error));
    }
    if (!frame.indirect_error.empty()) layers.push_back(layer("indirect.error", rgb, frame.indirect_error));
    const frame::ReliefBuffers& relief = frame.probes.relief;
    if (!frame.reflect.reflection.empty()) layers.push_back(layer("reflection", rgb, frame.reflect.reflection));
    if (classes) layers.push_back({"reflection.class", {"Y"}, classes->of_pixel.data(), 1});
    if (!frame.ao.open.empty()) layers.push_back({"ao", {"Y"}, &frame.ao.open.data()->x, 4});
    if (!frame.zbuffer.sent.empty()) layers.push_back(layer("sent", rgb, frame.zbuffer.sent));
    if (!relief.made.glossy.empty()) layers.push_back(layer("glossy", rgb, relief.made.glossy));
    for (const frame::ReliefBuffers::Layer& of : relief.layers)
        if (!of.radiance.empty()) layers.push_back(layer(of.name, rgb, of.radiance));
    for (int l = 0; l < int(lights.size()); ++l) {
        if (runs(ran, "shadow", l))
            layers.push_back({"shadow." + lights[l], {"Y"}, frame::shadows_of(frame).data() + l * pixels, 1});
    }
    const glm::ivec2 size = scene.frame_size;
    outputs.write(name + ".exr", [&](const std::string& path) { io::write_exr(path, size.x, size.y, layers); });

    // What was gathered, before it was filtered, has a size of its own.
    if (!frame.gathered.empty())
        outputs.write(name + ".gathered.exr", [&](const std::string& path) {
            std::vector<io::Layer> own = {layer("irradiance", rgb, frame.gathered), {"depth", {"Z"}, &frame.gathered.data()->w, 4}};
            if (!frame.reused_age.empty()) {
                own.push_back({"frames", {"Y"}, &frame.reused_age.data()->x, 4});
                own.push_back({"ghost", {"Y"}, &frame.reused_age.data()->z, 4});
            }
            io::write_exr(path, frame.gathered.width, frame.gathered.height, own);
        });

    // Write the reflective shadow maps.
    for (int l = 0; l < int(lights.size()); ++l) {
        std::vector<io::Layer> maps;
        const int side = scene.lights[std::size_t(l)].rsm_size;
        for (int m = 0; m < int(frame.rsms[l].size()); ++m) {
            const raster::Rsm& rsm = frame.rsms[l][m];
            if (rsm.size == 0) continue;
            const std::string base = map_name(frame, lights, l, m) + ".";
            maps.push_back(layer(base + "position", xyz, rsm.position));
            if (!rsm.normal.empty()) maps.push_back(layer(base + "normal", xyz, rsm.normal));
            if (!rsm.flux.empty()) maps.push_back(layer(base + "flux", rgb, rsm.flux));
            maps.push_back({base + "depth", {"Z"}, &rsm.position.data()->w, 4});
        }
        if (maps.empty()) continue;
        outputs.write(name + ".rsm." + lights[l] + ".exr",
                      [&](const std::string& path) { io::write_exr(path, side, side, maps); });
    }

    auto write_png = [&](const std::string& file, const Image4& display) {
        const std::vector<unsigned char> bytes = compose::to_bytes(display);
        outputs.write(file, [&](const std::string& path) { io::write_png(path, size.x, size.y, bytes.data()); });
    };
    write_png(name + ".png", frame.display);
    if (!frame.truth_display.empty()) write_png(name + ".truth.png", frame.truth_display);
    if (!frame.zbuffer.vertex_normals.empty()) write_png(name + ".vertex_normals.png", frame.zbuffer.vertex_normals);
    for (const frame::ReliefBuffers::Layer& of : relief.layers)
        if (!of.display.empty()) write_png(name + "." + of.name + ".png", of.display);
}

}  // namespace plumb::cli
