// A small glTF document that tests change one value at a time.
#pragma once

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "files.h"
#include "io/gltf.h"

namespace plumb::io {

using Json = nlohmann::json;

template <class T>
std::string bytes_of(const std::vector<T>& values) {
    std::string bytes(values.size() * sizeof(T), '\0');
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}

inline std::string base64(const std::string& bytes) {
    const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[bits >> (18 - 6 * k) & 63];
    }
    return out;
}

// A document and its buffer. add() appends an array as bufferView and accessor and returns the accessor's index.
struct GltfSample {
    Json json = Json::parse(R"({"asset": {"version": "2.0"}, "buffers": [{}], "bufferViews": [], "accessors": []})");
    std::string buffer;

    template <class T>
    std::size_t add(const std::vector<T>& values, int component, const std::string& type, std::size_t components) {
        buffer.resize((buffer.size() + 3) / 4 * 4);
        json["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", values.size() * sizeof(T)}});
        buffer += bytes_of(values);
        json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                     {"componentType", component},
                                     {"type", type},
                                     {"count", values.size() / components}});
        return json["accessors"].size() - 1;
    }

    std::string gltf() const {
        Json out = json;
        if (out["buffers"].size() == 1 && out["buffers"][0].empty())
            out["buffers"][0] = {{"byteLength", buffer.size()},
                                 {"uri", "data:application/octet-stream;base64," + base64(buffer)}};
        return out.dump();
    }
    std::string glb() const {
        Json out = json;
        if (out["buffers"][0].empty()) out["buffers"][0] = {{"byteLength", buffer.size()}};
        std::string text = out.dump(), binary = buffer;
        text.resize((text.size() + 3) / 4 * 4, ' ');
        binary.resize((binary.size() + 3) / 4 * 4);
        const auto word = [](std::size_t n) { return bytes_of(std::vector<std::uint32_t>{std::uint32_t(n)}); };
        return "glTF" + word(2) + word(28 + text.size() + binary.size()) + word(text.size()) + "JSON" + text +
               word(binary.size()) + std::string("BIN\0", 4) + binary;
    }
};

// A square of two triangles in the plane z = 0, normals +z, with u16 indices: accessors 0 to 3.
inline GltfSample square() {
    GltfSample s;
    s.add<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 5126, "VEC3", 3);
    s.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 5126, "VEC3", 3);
    s.add<float>({0, 1, 1, 1, 1, 0, 0, 0}, 5126, "VEC2", 2);
    s.add<std::uint16_t>({0, 1, 2, 0, 2, 3}, 5123, "SCALAR", 1);
    s.json.update(Json::parse(R"({
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3,
                                    "material": 0}]}],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.5, 0.75, 1],
                                                                 "metallicFactor": 0}}],
        "nodes": [{"name": "square", "mesh": 0}],
        "scenes": [{"nodes": [0]}], "scene": 0})"));
    return s;
}

inline GltfModel load(const Folder& folder, const std::string& name, const std::string& content,
                      const GltfOptions& options = {}) {
    return read_gltf(folder.put(name, content), options);
}
inline GltfModel load(const GltfSample& sample, const GltfOptions& options = {}) {
    const Folder folder;
    return load(folder, "a.gltf", sample.gltf(), options);
}

}  // namespace plumb::io
