#include "io/glb_parts.h"

#include <algorithm>

#include "core/error.h"
#include "io/file.h"
#include "io/gltf_document.h"

namespace plumb::io {
namespace {

constexpr const char* lists[] = {"nodes",    "cameras", "materials", "meshes",     "textures",
                                 "samplers", "images",  "accessors", "bufferViews"};

std::string word(std::size_t n) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) bytes += char(n >> 8 * i & 255);
    return bytes;
}

}  // namespace

GlbParts::GlbParts(const std::string& path) : path_(path) {
    json_["asset"] = {{"version", "2.0"}, {"generator", own_generator}};
    json_["scene"] = 0;
    json_["scenes"] = Json::array({{{"nodes", Json::array()}}});
    for (const char* list : lists) json_[list] = Json::array();
}

void GlbParts::fail(const std::string& cause) const { throw InputError(shown(path_), "", "cannot be written: " + cause); }

void GlbParts::write_chunks() {
    for (const char* list : lists)
        if (json_[list].empty()) json_.erase(list);
    if (!extensions_.empty()) json_["extensionsUsed"] = extensions_;
    if (bytes_ > 0) json_["buffers"] = Json::array({{{"byteLength", bytes_}}});
    std::string text;
    try {
        text = json_.dump();
    } catch (const Json::exception&) {
        fail("a name is not UTF-8");
    }
    text.append((4 - text.size() % 4) % 4, ' ');
    const std::size_t total = 12 + 8 + text.size() + (bytes_ > 0 ? 8 + bytes_ : 0);
    if (total > 0xffffffffu) fail("more than 4 GiB");
    std::string head = "glTF" + word(2) + word(total) + word(text.size()) + "JSON";
    std::vector<std::string_view> parts = {head, text};
    const std::string binary = word(bytes_) + std::string("BIN\0", 4);
    if (bytes_ > 0) parts.push_back(binary);
    parts.insert(parts.end(), parts_.begin(), parts_.end());
    write_file(path_, parts);
}

void GlbParts::use_extension(const char* name) {
    if (std::find(extensions_.begin(), extensions_.end(), name) == extensions_.end()) extensions_.push_back(name);
}

void GlbParts::add_node(Json node) {
    json_["scenes"][0]["nodes"].push_back(json_["nodes"].size());
    json_["nodes"].push_back(std::move(node));
}

std::size_t GlbParts::add_view(std::string bytes, int target) {
    Json view = {{"buffer", 0}, {"byteOffset", bytes_}, {"byteLength", bytes.size()}};
    if (target != no_target) view["target"] = target;
    bytes.append((4 - bytes.size() % 4) % 4, '\0');
    bytes_ += bytes.size();
    parts_.push_back(std::move(bytes));
    json_["bufferViews"].push_back(std::move(view));
    return json_["bufferViews"].size() - 1;
}

std::size_t GlbParts::add_positions(const std::vector<glm::vec3>& values) {
    glm::vec3 low = values.at(0), high = low;
    for (const glm::vec3& p : values)
        for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
    const std::size_t accessor = add_accessor(values, "VEC3", f32, vertices);
    json_["accessors"].back()["min"] = numbers(low);
    json_["accessors"].back()["max"] = numbers(high);
    return accessor;
}

// Floats are written as the doubles that they are, which JSON gives in full.
GlbParts::Json GlbParts::numbers(const glm::vec3& v) { return {double(v.x), double(v.y), double(v.z)}; }

}  // namespace plumb::io
