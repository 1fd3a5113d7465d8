// plumb lightmap --check: whether a lightmap that somebody else made is right.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/lightmap_pictures.h"
#include "io/file.h"
#include "io/image_file.h"
#include "tools/plumb/lightmap.h"
#include "tools/plumb/lightmap_report.h"
#include "tools/shared/outputs.h"
#include "tools/shared/scene_command.h"

namespace plumb::cli {

namespace {

bool encoded(const std::string& file) {
    const std::string extension = io::extension_of(file);
    for (const char* e : {"png", "jpg", "jpeg", "bmp", "tga", "gif"})
        if (extension == e) return true;
    return false;
}

// Red, green and blue, or one channel for all three.
Image4 read_map(const std::string& file, const std::string& layer) {
    if (encoded(file)) throw InputError(io::shown(file), "", "is encoded for a display: expected linear light, an EXR say");
    io::FloatPicture picture = io::read_picture(file);
    const std::vector<std::string> names = io::layer_names(picture);
    const bool unnamed = std::find(names.begin(), names.end(), "") != names.end();
    if (!layer.empty() || names.size() > 1 || !unnamed)
        picture = io::select_layer(picture, layer.empty() && !unnamed && names.size() == 1 ? names[0] : layer, file);
    std::array<std::size_t, 3> from{};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto at = std::find(picture.channels.begin(), picture.channels.end(), std::string(1, "RGB"[c]));
        from[c] = picture.channels.size() == 1 ? 0 : std::size_t(at - picture.channels.begin());
        if (from[c] >= picture.channels.size())
            throw InputError(io::shown(file), "", fmt::format("has the channels {}: expected R, G and B, or a single one",
                                                              fmt::join(picture.channels, ", ")));
    }
    Image4 map(picture.width, picture.height);
    for (std::size_t i = 0; i < map.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) map.texels[i][int(c)] = picture.data[i * picture.channels.size() + from[c]];
    return map;
}

double scale_of(const std::string& text) {
    if (text == "pi") return host::pi;
    char* end = nullptr;
    const double scale = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != 0 || !(scale > 0) || !std::isfinite(scale))
        throw InputError("--scale " + io::printable(text) + ": expected a number above 0, or pi");
    return scale;
}

void multiply(Image4& map, double scale, const std::string& file) {
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            for (int c = 0; c < 3; ++c) {
                const float value = map(x, y)[c];
                if (!std::isfinite(value) || !std::isfinite(float(double(value) * scale)))
                    throw InputError(io::shown(file), "", fmt::format("texel {},{} is {} in {}: expected finite numbers", x, y, value, "RGB"[c]));
                map(x, y)[c] = float(double(value) * scale);
            }
}

void check_options(const LightmapOptions& given) {
    if (!given.error_file.empty()) throw InputError("lightmap: --error writes the error of a map that is made here: not with --check");
    if (!given.size.empty()) throw InputError("lightmap: --size: the map that is checked has one of its own");
    namespace fs = std::filesystem;
    std::error_code error;
    if (!given.html.empty()) {
        const std::string parent = io::folder_of(given.html);
        if (fs::is_directory(given.html, error)) throw InputError(io::shown(given.html), "", "is a folder");
        if (!parent.empty() && !fs::is_directory(parent, error))
            throw InputError(io::shown(given.html), "", "cannot be written: there is no folder of that name");
        for (const std::string& read : {given.checked, given.checked_error, given.scene.file})
            if (!read.empty() && fs::equivalent(given.html, read, error)) throw InputError(io::shown(given.html), "", "is read here");
    }
    if (!given.output.empty() && fs::exists(given.output, error) && !fs::is_directory(given.output, error))
        throw InputError(io::shown(given.output), "", "is a file: --check writes a folder of pictures");
}

std::vector<probes::DebugLayer> pictures_of(const Image4& map, const LightmapScene& s, const probes::Lightmap& l,
                                            const probes::ReceiverIrradiance& truth, const probes::LightmapCheck& check,
                                            const RunOptions& options) {
    probes::DebugView view;
    view.size = s.scene.frame_size;
    view.view = make_view(s.scene.camera, double(view.size.x) / view.size.y);
    return probes::lightmap_pictures(map, l, truth, check, {}, view, options);
}

void write_pictures(const std::string& folder, const std::vector<probes::DebugLayer>& layers, const Image4& map,
                    const probes::Lightmap& l, const probes::ReceiverIrradiance& truth) {
    Outputs outputs(folder);
    std::string legend = "check.exr: map, truth, its standard error, and map - truth; irradiance, W/m2\n";
    for (const probes::DebugLayer& layer : layers) {
        std::vector<std::uint8_t> rgb;
        for (const glm::vec4& t : layer.picture.texels)
            for (int c = 0; c < 3; ++c) rgb.push_back(std::uint8_t(255 * std::clamp(t[c], 0.0f, 1.0f) + 0.5f));
        outputs.write(layer.name + ".png",
                      [&](const std::string& path) { io::write_png(path, layer.picture.width, layer.picture.height, rgb.data()); });
        legend += fmt::format("{}.png: {}\n", layer.name, layer.meaning);
    }
    const Image4 mean = probes::scatter(l.receivers, truth.mean), error = probes::scatter(l.receivers, truth.error);
    Image4 difference = mean;
    for (const glm::ivec2& t : l.receivers.texel) difference(t.x, t.y) = map(t.x, t.y) - mean(t.x, t.y);
    outputs.write("check.exr", [&](const std::string& path) {
        const std::vector<std::string> rgb = {"R", "G", "B"};
        io::write_exr(path, map.width, map.height, {{"map", rgb, &map.data()->x}, {"truth", rgb, &mean.data()->x},
                                                    {"error", rgb, &error.data()->x}, {"difference", rgb, &difference.data()->x}});
    });
    outputs.write("README.txt", [&](const std::string& path) { io::write_text(path, legend); });
    outputs.commit();
}

}  // namespace

int check_user_lightmap(const LightmapOptions& given) {
    check_options(given);
    const double scale = scale_of(given.scale);
    Image4 map = read_map(given.checked, given.layer), map_error;
    const glm::ivec2 size(map.width, map.height);
    multiply(map, scale, given.checked);
    if (!given.checked_error.empty()) {
        map_error = read_map(given.checked_error, "");
        multiply(map_error, scale, given.checked_error);
        if (map_error.width != size.x || map_error.height != size.y)
            throw InputError(io::shown(given.checked_error), "", fmt::format("is {} x {} texels; the map is {} x {}", map_error.width,
                                                                             map_error.height, size.x, size.y));
    }
    const LightmapScene scene = load_lightmap_scene(given);
    const std::string layout = layout_of(given, scene);
    const probes::Lightmap l = lightmap_of(given, scene, layout, size, io::shown(given.checked));
    const probes::ReceiverIrradiance truth = trace_lightmap(given, scene, l);
    const probes::LightmapCheck check = probes::check_lightmap(map, map_error, l, truth);
    const LightmapReport report{given, scene, layout, l, truth, check, verdict_of(given, check)};

    std::vector<std::string> written;
    std::vector<probes::DebugLayer> layers;
    if (!given.output.empty() || !given.html.empty())
        layers = pictures_of(map, scene, l, truth, check, given.common.run_options());
    if (!given.output.empty()) write_pictures(given.output, layers, map, l, truth), written.push_back(given.output);
    if (!given.html.empty()) io::write_text(given.html, lightmap_page(report, layers)), written.push_back(given.html);
    if (given.common.json)
        std::fputs(json_text(lightmap_json(report)).c_str(), stdout);
    else {
        print_notes(scene.scene);
        std::fputs(lightmap_text(report).c_str(), stdout);
        for (const std::string& path : written) fmt::print("wrote {}\n", io::shown(path));
    }
    return report.verdict.empty() ? success : disagreement;
}

}  // namespace plumb::cli
