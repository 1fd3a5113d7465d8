#include "tests/foreign/exported.h"

#include <cstring>
#include <stdexcept>

#include "tests/program/program.h"

namespace plumb::foreign {

Exported::Exported(const std::string& folder) {
    const std::string scene = PLUMB_SOURCE_DIR "/tests/foreign/scene.toml";
    const program::Result r = program::run({"export", scene, "--stage", "all", "-o", folder});
    if (r.exit != 0) throw std::runtime_error(r.err);
    manifest_ = io::read_manifest(folder + "/manifest.toml");
}

const io::ManifestStage& Exported::stage(const std::string& name) const {
    for (const io::ManifestStage& s : manifest_.stages)
        if (s.stage == name) return s;
    throw std::runtime_error("the export has no stage " + name);
}

std::vector<float> Exported::numbers(const std::string& name, const std::string& input) const {
    const io::ManifestStage& s = stage(name);
    const auto at = s.inputs.find(input);
    if (at == s.inputs.end()) throw std::runtime_error(name + " has no input " + input);
    const Array array = io::read_dump(at->second).array;
    std::vector<float> out(array.bytes.size() / sizeof(float));
    std::memcpy(out.data(), array.bytes.data(), array.bytes.size());
    return out;
}

Image4 Exported::image(const std::string& name, const std::string& input) const {
    const std::vector<float> texels = numbers(name, input);
    const io::DumpSpec& spec = stage(name).inputs.at(input);
    Image4 out(spec.width, spec.height);
    if (texels.size() != 4 * out.size())
        throw std::runtime_error(name + ": " + input + " is no image of four components");
    std::memcpy(out.data(), texels.data(), texels.size() * sizeof(float));
    return out;
}

std::vector<double> Exported::uniform(const std::string& name, const std::string& member) const {
    const io::ManifestStage& s = stage(name);
    const auto at = s.uniforms.find(member);
    if (at == s.uniforms.end()) throw std::runtime_error(name + " has no uniform " + member);
    return at->second;
}

glm::dvec3 Exported::vector(const std::string& name, const std::string& member) const {
    const std::vector<double> v = uniform(name, member);
    return {v.at(0), v.at(1), v.at(2)};
}

Clip clip_of(const std::vector<double>& to_x, const std::vector<double>& to_y, const std::vector<double>& to_w,
             glm::ivec2 size, glm::dvec2 planes) {
    Clip clip(0.0);
    const double scale = planes.y / (planes.y - planes.x);
    for (int c = 0; c < 4; ++c) {
        const double w = to_w.at(std::size_t(c));
        clip[c][0] = to_x.at(std::size_t(c)) * 2 / size.x - w;
        clip[c][1] = to_y.at(std::size_t(c)) * 2 / size.y - w;
        clip[c][2] = scale * w - (c == 3 ? scale * planes.x : 0.0);
        clip[c][3] = w;
    }
    return clip;
}

void set_light(io::ManifestStage& stage, const glm::mat4& clip, bool y_up) {
    for (const char* member : {"to_texel_x", "to_texel_y", "to_texel_w", "size"})
        stage.uniforms.erase(std::string("map.") + member);
    io::ViewSpec& view = stage.views["map"];
    for (int i = 0; i < 16; ++i) view.view_proj[std::size_t(i)] = double(clip[i % 4][i / 4]);
    view.y_up = y_up;
}

void set(io::ManifestStage& stage, const std::string& name, const glm::vec3& value) {
    std::vector<double>& to = stage.uniforms.at(name);
    for (std::size_t c = 0; c < 3; ++c) to.at(c) = double(value[int(c)]);
}

io::ManifestStage bare(const Exported& exported, const std::string& name, const std::string& label) {
    const io::ManifestStage& from = exported.stage(name);
    io::ManifestStage out;
    out.stage = name, out.label = label;
    out.width = from.width, out.height = from.height;
    out.uniforms = from.uniforms;
    return out;
}

}  // namespace plumb::foreign
