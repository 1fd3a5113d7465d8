// plumb_fuzz_seeds <folder>: small files of each format, as our own writers and OpenImageIO's make them, for fuzzing to
// begin with: <folder>/<format>/<name>. What is kept of them is in tests/fuzz/corpus.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/bundle.h"
#include "io/bundle_file.h"
#include "io/file.h"
#include "io/npy.h"
#include "png_parts.h"

namespace {

namespace fs = std::filesystem;
using namespace plumb;
using Json = nlohmann::ordered_json;

fs::path root;

void put(const std::string& format, const std::string& name, const std::string& bytes) {
    fs::create_directories(root / format);
    io::write_text((root / format / name).string(), bytes);
}

// ---- OBJ and MTL

void put_obj() {
    put("obj", "all",
        "# a comment\nmtllib a.mtl\no thing\ng one\ns 1\nv 0 0 0\nv 1 0 0 1\nv 0 1 0 0.5 0.5 0.5\nv 1 1 0\nvt 0 0\nvt 1\n"
        "vt 0 1 0\nvn 0 0 1\nvn 0 0 0\nusemtl a\nf 1/1/1 2/2/1 3/3/1\nusemtl b c\nf -4//1 -3//1 -1//2 -2//1\nf 1 2 \\\n 4 3\n"
        "usemtl m\nf 1/1 2/2 4/3 # behind\nl 1 2\np 1\n");
    put("obj", "concave", "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\nv 0 2 0\nv 1 1 1\nf 1 2 3 4 5\nf 1 2 3 4 5 6\nf 1 1 2\n");
    put("obj", "dos", "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\nvp 0 0 0\r\nlod 1\r\nbevel on\r\n");
    put("mtl", "all",
        "newmtl a\nKa 0 0 0\nKd 0.5 0.4 0.3\nKs 0.2 0.2 0.2\nNs 20\nNi 1.5\nd 1\nillum 2\nmap_Kd a.png\n"
        "newmtl b\nKe 1 2 3\nKs 1\nillum 3\nNs 1e9\n# end\n");
    put("mtl", "maps",
        "newmtl a\nmap_Kd -s 2 2 -o 0.5 0 -texres 256 -colorspace sRGB a.png\nTr 0.5\nmap_d a.png\nmap_Bump -bm 1 a.png\n"
        "map_Ke -clamp on a.png\nPm 1\nPr 0.3\nnewmtl b\nmap_Kd .\\a.png\nrefl -type sphere a.png\n");
}

// ---- glTF

struct Gltf {
    Json json = Json::parse(R"({"asset": {"version": "2.0"}, "buffers": [{}], "bufferViews": [], "accessors": []})");
    std::string buffer;

    int view(const std::string& bytes) {
        buffer.resize((buffer.size() + 3) / 4 * 4);
        json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}});
        buffer += bytes;
        return int(json["bufferViews"].size()) - 1;
    }
    template <class T>
    static std::string bytes_of(const std::vector<T>& values) {
        std::string bytes(values.size() * sizeof(T), '\0');
        std::memcpy(bytes.data(), values.data(), bytes.size());
        return bytes;
    }
    template <class T>
    int add(const std::vector<T>& values, int component, const std::string& type, std::size_t count) {
        json["accessors"].push_back(
            {{"bufferView", view(bytes_of(values))}, {"componentType", component}, {"type", type}, {"count", count}});
        return int(json["accessors"].size()) - 1;
    }

    void put_both(const std::string& name) {
        Json text = json, binary = json;
        std::string padded = buffer;
        padded.resize((padded.size() + 3) / 4 * 4);
        text["buffers"][0] = {{"byteLength", buffer.size()}, {"uri", "data:application/octet-stream;base64," + base64()}};
        binary["buffers"][0] = {{"byteLength", buffer.size()}};
        put("gltf", name, text.dump());
        std::string chunk = binary.dump();
        chunk.resize((chunk.size() + 3) / 4 * 4, ' ');
        const auto word = [](std::size_t n) { return bytes_of(std::vector<std::uint32_t>{std::uint32_t(n)}); };
        put("glb", name,
            "glTF" + word(2) + word(28 + chunk.size() + padded.size()) + word(chunk.size()) + "JSON" + chunk +
                word(padded.size()) + std::string("BIN\0", 4) + padded);
    }
    std::string base64() const {
        const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string out;
        for (std::size_t i = 0; i < buffer.size(); i += 3) {
            std::uint32_t bits = 0;
            for (std::size_t k = 0; k < 3; ++k)
                bits = bits << 8 | (i + k < buffer.size() ? std::uint8_t(buffer[i + k]) : 0u);
            for (std::size_t k = 0; k < 4; ++k) out += i + k > buffer.size() ? '=' : digits[bits >> (18 - 6 * k) & 63];
        }
        return out;
    }
};

const std::vector<float> corners = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

std::string small_png() {
    const std::string rows = {0, 1, 2, 3, 4, 5, 6, 0, 7, 8, 9, 10, 11, 12};
    return fuzz::join_png({{"IHDR", std::string("\0\0\0\2\0\0\0\2\10\2\0\0\0", 13)}, {"IDAT", fuzz::deflate(rows)}, {"IEND", ""}});
}

void put_gltf() {
    {
        Gltf g;  // textures and their samplers, two materials
        g.add<float>(corners, 5126, "VEC3", 4);
        g.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0}, 5126, "VEC3", 4);
        g.add<float>({0, 1, 1, 1, 1, 0, 0, 0}, 5126, "VEC2", 4);
        g.add<std::uint16_t>({0, 1, 2, 0, 2, 3}, 5123, "SCALAR", 6);
        g.add<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0, 1}, 5126, "VEC4", 4);
        g.json.update(Json::parse(R"({
            "extensionsUsed": ["KHR_texture_transform", "KHR_materials_emissive_strength"],
            "images": [{"mimeType": "image/png", "bufferView": 5}],
            "samplers": [{"magFilter": 9728, "minFilter": 9987, "wrapS": 33071, "wrapT": 33648}],
            "textures": [{"source": 0, "sampler": 0}, {"source": 0}],
            "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.5, 0.75, 1],
                "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "rotation": 1,
                "scale": [2, 2]}}}, "metallicFactor": 0.5, "roughnessFactor": 0.2}},
                {"emissiveFactor": [1, 1, 0], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 5}},
                "normalTexture": {"index": 1, "scale": 0.5}, "emissiveTexture": {"index": 1}, "alphaMode": "MASK",
                "alphaCutoff": 0.3, "doubleSided": true}],
            "meshes": [{"primitives": [
                {"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 2, "TANGENT": 4}, "indices": 3, "material": 0},
                {"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 2, "TANGENT": 4}, "indices": 3, "material": 1}]}],
            "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0})"));
        g.view(small_png());
        g.put_both("textures");
    }
    {
        Gltf g;  // nodes, cameras, lights, strips and fans without normals
        g.add<float>(corners, 5126, "VEC3", 4);
        g.add<std::uint8_t>({0, 1, 3, 2}, 5121, "SCALAR", 4);
        g.json.update(Json::parse(R"({
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 10, "color": [1, 0.5, 0.25]},
                {"type": "spot", "range": 5, "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.6}}, {"type": "directional"}]}},
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "zfar": 10, "aspectRatio": 1}},
                {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}}],
            "meshes": [{"name": "m", "primitives": [{"attributes": {"POSITION": 0}, "mode": 5, "indices": 1},
                {"attributes": {"POSITION": 0}, "mode": 6}, {"attributes": {"POSITION": 0}, "mode": 0},
                {"attributes": {"POSITION": 0}, "mode": 1}]}],
            "nodes": [{"children": [1, 2, 3], "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [2, 2, 2]},
                {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}, {"camera": 0, "mesh": 0},
                {"camera": 1, "extensions": {"KHR_lights_punctual": {"light": 0}}},
                {"extensions": {"KHR_lights_punctual": {"light": 1}}}, {"extensions": {"KHR_lights_punctual": {"light": 2}}}],
            "scenes": [{"nodes": [0, 4]}, {"nodes": [0, 4, 5]}], "scene": 1})"));
        g.put_both("nodes");
    }
    {
        Gltf g;  // sparse, strided and normalised accessors, our own extras
        g.add<float>({0, 0, 0, 9, 1, 0, 0, 9, 1, 1, 0, 9}, 5126, "VEC3", 3);
        g.json["bufferViews"][0]["byteStride"] = 16;
        g.add<std::uint8_t>({0, 255, 128, 0, 255, 255, 0, 0}, 5121, "VEC2", 3);
        g.json["accessors"][1]["normalized"] = true;
        g.view(Gltf::bytes_of(std::vector<std::uint16_t>{1, 2}));
        g.view(Gltf::bytes_of(std::vector<float>{1, 0, 0, 0, 1, 0}));
        g.json["accessors"].push_back(Json::parse(R"({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": {"count": 2,
            "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 3}}})"));
        g.add<std::uint32_t>({0}, 5125, "SCALAR", 1);
        g.json.update(Json::parse(R"({
            "materials": [{"extras": {"plumb": {"specular": [0.1, 0.1, 0.1], "exponent": 20, "mirror": [0.2, 0, 0]}}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 2, "TEXCOORD_0": 1, "TEXCOORD_1": 1}, "material": 0,
                "extras": {"plumb": {"order": 3}}}]}, {"primitives": [{"attributes": {"POSITION": 0}}]}],
            "nodes": [{"mesh": 0, "extras": {"plumb": {"dynamic": true, "share": 0.5}}}, {"mesh": 1}]})"));
        g.put_both("sparse");
    }
    {
        Gltf g;  // skins, morph targets, colours, animations
        g.add<float>(corners, 5126, "VEC3", 3);
        g.add<std::uint8_t>({0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5121, "VEC4", 3);
        g.add<float>({0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 5126, "VEC4", 3);
        g.add<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1}, 5126, "MAT4", 2);
        g.add<std::uint8_t>({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255}, 5121, "VEC4", 3);
        g.json["accessors"][4]["normalized"] = true;
        g.json.update(Json::parse(R"({
            "skins": [{"joints": [1, 2], "inverseBindMatrices": 3, "skeleton": 1}],
            "animations": [{"channels": [], "samplers": []}],
            "materials": [{"alphaMode": "BLEND", "occlusionTexture": {"index": 0}}],
            "images": [{"uri": "a%20b.png"}], "textures": [{"source": 0}],
            "meshes": [{"weights": [0.5], "primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2, "COLOR_0": 4},
                "targets": [{"POSITION": 0}], "material": 0}]}],
            "nodes": [{"mesh": 0, "skin": 0}, {"children": [2]}, {"translation": [0, 1, 0]}],
            "scenes": [{"nodes": [0, 1]}], "scene": 0})"));
        g.put_both("skin");
    }
}

// ---- Pictures

std::string word(std::uint32_t value) {
    return {char(value >> 24), char(value >> 16 & 255), char(value >> 8 & 255), char(value & 255)};
}

void put_png() {
    struct Kind {
        int colour, channels;
        std::vector<int> depths;
    };
    const std::vector<Kind> kinds = {{0, 1, {1, 2, 4, 8, 16}}, {2, 3, {8, 16}}, {3, 1, {1, 2, 4, 8}}, {4, 2, {8, 16}}, {6, 4, {8, 16}}};
    constexpr int width = 5, height = 5;
    for (const Kind& kind : kinds)
        for (const int depth : kind.depths)
            for (const int interlace : {0, 1}) {
                // Adam7: first column and row, and their steps, of each pass (ISO 15948, 8.2).
                constexpr int passes[7][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4}, {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
                std::string rows;
                for (int pass = 0; pass < (interlace ? 7 : 1); ++pass) {
                    const int x = interlace ? passes[pass][0] : 0, y = interlace ? passes[pass][1] : 0;
                    const int dx = interlace ? passes[pass][2] : 1, dy = interlace ? passes[pass][3] : 1;
                    const int columns = x < width ? (width - x + dx - 1) / dx : 0;
                    for (int row = y; row < height && columns > 0; row += dy) {
                        rows += char(row % 5);  // all five filters
                        for (int i = 0; i < (columns * kind.channels * depth + 7) / 8; ++i) rows += char(row * 8 + i);
                    }
                }
                std::vector<fuzz::PngChunk> chunks = {
                    {"IHDR", word(width) + word(height) + std::string{char(depth), char(kind.colour), 0, 0, char(interlace)}}};
                if (kind.colour == 3) chunks.push_back({"PLTE", std::string(std::size_t(3) << depth, 'p')});
                if (kind.colour == 3) chunks.push_back({"tRNS", std::string("\x80\x40", 2)});
                if (kind.colour == 0) chunks.push_back({"tRNS", std::string("\0\1", 2)});
                if (kind.colour == 2) chunks.push_back({"gAMA", word(45455)});
                if (kind.colour == 6) chunks.push_back({"sRGB", std::string(1, '\0')});
                if (kind.colour == 4) chunks.push_back({"tEXt", std::string("a\0b", 3)});
                chunks.push_back({"IDAT", fuzz::deflate(rows)});
                chunks.push_back({"IEND", ""});
                put("png", "c" + std::to_string(kind.colour) + "_" + std::to_string(depth) + (interlace ? "_adam7" : ""),
                    fuzz::join_png(chunks));
            }
}

std::string encoded(const std::string& format, const OIIO::ImageSpec& spec) {
    std::vector<unsigned char> file;
    OIIO::Filesystem::IOVecOutput memory(file);
    const auto output = OIIO::ImageOutput::create(format);
    if (!output || !output->supports("ioproxy")) return {};
    output->set_ioproxy(&memory);
    std::vector<float> values(std::size_t(spec.width) * std::size_t(spec.height) * std::size_t(spec.nchannels));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = float(i % 7) / 8;
    if (!output->open("a", spec) || !output->write_image(OIIO::TypeDesc::FLOAT, values.data()) || !output->close()) return {};
    return {file.begin(), file.end()};
}

void put_exr() {
    for (const char* compression : {"none", "rle", "zip", "zips", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"})
        for (const auto type : {OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::HALF, OIIO::TypeDesc::UINT}) {
            OIIO::ImageSpec spec(6, 4, 4, type);
            spec.channelnames = {"R", "G", "B", "depth.V"};
            spec.attribute("compression", compression);
            spec.attribute("DateTime", "");
            const std::string name = std::string(compression) + "_" + spec.format.c_str();
            put("exr", name, encoded("openexr", spec));
            spec.tile_width = spec.tile_height = 4;
            if (type == OIIO::TypeDesc::HALF) put("exr", name + "_tiled", encoded("openexr", spec));
        }
    OIIO::ImageSpec window(3, 2, 1, OIIO::TypeDesc::FLOAT);
    window.channelnames = {"Y"};
    window.x = 1, window.y = 2, window.full_width = 8, window.full_height = 8;
    window.attribute("compression", "zip");
    put("exr", "window", encoded("openexr", window));
}

void put_pictures() {
    // The order of fuzz_picture().
    const auto put_kind = [](int kind, const std::string& name, const std::string& bytes) {
        if (!bytes.empty()) put("picture", name, char(kind) + bytes);
    };
    OIIO::ImageSpec rgb(4, 3, 3, OIIO::TypeDesc::UINT8), floats(4, 3, 3, OIIO::TypeDesc::FLOAT);
    put_kind(0, "hdr", encoded("hdr", floats));
    const std::string pixels(4 * 2 * 3, '\x3f');
    put_kind(1, "pfm", "PF\n2 1\n-1.0\n" + pixels);
    put_kind(1, "pfm_grey", "Pf\n2 3\n1.0\n" + pixels);
    for (const char* compression : {"none", "lzw", "zip", "packbits"})
        for (const auto type : {OIIO::TypeDesc::UINT8, OIIO::TypeDesc::UINT16, OIIO::TypeDesc::FLOAT}) {
            OIIO::ImageSpec spec(4, 3, 3, type);
            spec.attribute("compression", compression);
            spec.attribute("DateTime", "");
            put_kind(2, std::string("tif_") + compression + "_" + spec.format.c_str(), encoded("tiff", spec));
            spec.tile_width = spec.tile_height = 16;
            if (type == OIIO::TypeDesc::UINT8) put_kind(2, std::string("tif_tiled_") + compression, encoded("tiff", spec));
        }
    for (const bool packed : {false, true}) {
        std::vector<std::uint32_t> head(32);
        head[0] = 0x20534444, head[1] = 124, head[2] = packed ? 0x81007 : 0x100f, head[3] = 4, head[4] = 4, head[5] = packed ? 8 : 16;
        head[19] = 32, head[20] = packed ? 4 : 0x41, head[21] = packed ? 0x31545844 : 0, head[22] = packed ? 0 : 32;
        head[23] = 0xff0000, head[24] = 0xff00, head[25] = 0xff, head[26] = 0xff000000u, head[27] = 0x1000;
        if (packed) head[22] = head[23] = head[24] = head[25] = head[26] = 0;
        put_kind(3, packed ? "dds_dxt1" : "dds", Gltf::bytes_of(head) + std::string(packed ? 8 : 64, 'x'));
    }
    put_kind(4, "jpg", encoded("jpeg", rgb));
    put_kind(5, "ppm", "P6\n2 2\n255\n" + std::string(12, 'a'));
    put_kind(5, "ppm_text", "P3\n# c\n2 1\n15\n1 2 3 4 5 6\n");
    put_kind(5, "pgm", "P5\n2 2\n65535\n" + std::string(8, 'a'));
    put_kind(5, "pbm", "P4\n9 2\n" + std::string(4, 'a'));
    put_kind(6, "bmp", encoded("bmp", rgb));
    for (const char* compression : {"none", "rle"}) {
        OIIO::ImageSpec spec(4, 3, 4, OIIO::TypeDesc::UINT8);
        spec.attribute("compression", compression);
        put_kind(7, std::string("tga_") + compression, encoded("targa", spec));
    }
}

// ---- TOML, arrays

void put_toml() {
    put("toml", "scene", std::string(1, '\0') + R"(seed = 1
[frame]
size = [16, 8]
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
fov_y_deg = 39
near = 0.1
far = 100
[[material]]
name = "a"
reflectance = [0.5, 0.5, 0.5]
texture = "a.png"
[[mesh]]
generate = "cornell"
translate = [0, 1, 0]
[[light]]
name = "key"
type = "spot"
position = [0, 1.9, 0]
direction = [0, -1, 0]
cone_deg = [55, 65]
intensity = [12, 12, 12]
rsm_size = 128
[render]
method = "rsm"
[rsm]
radius = 1
)");
    put("toml", "cameras", "\1# how\n[[camera]]\nscene = \"box\"\nname = \"box_01\"\nposition = [0, 1, 4]\nlook_at = [0, 1, 0]\n"
                           "up = [0, 1, 0]\nfov_y_deg = 50\nexposure = 1.5\nframe = 2\n");
    const std::string manifest = R"(device = "A"
profile = "ideal"
[[stage]]
stage = "rsm.disc"
size = [4, 2]
[stage.params]
samples = 400
[stage.uniforms]
intensity = [1, 2.5, 3]
map.to_texel_x = 0.5
[stage.input.position]
file = "p.raw"
vk_format = "VK_FORMAT_R16G16B16A16_SFLOAT"
width = 4
height = 2
flip_y = true
[stage.output.irradiance]
file = "i.exr"
layer = "color"
)";
    put("toml", "manifest", "\2" + manifest);
    put("toml", "manifest_json", "\3" R"({"device": "A", "stage": [{"stage": "rsm.disc", "size": [4, 2], "params": {"samples": 400},
"input": {"position": {"file": "p.raw", "gl_format": "GL_RGBA16F", "width": 4, "height": 2}},
"output": {"irradiance": {"file": "i.npy"}}}]})");
}

void put_arrays() {
    const std::string path = (root / "array.tmp").string();
    const std::vector<float> values = {1, 2, 3, 4, 5, 6};
    Array array{"a", DType::f32, {2, 3}, Bytes(24)};
    std::memcpy(array.bytes.data(), values.data(), 24);
    io::write_npy(path, array);
    put("array", "npy", std::string(1, '\0') + io::read_text(path));
    Bundle bundle;
    plumb::add(bundle, "a", {2, 3}, values.data());
    plumb::add(bundle, "b", {6}, values.data());
    io::write_bundle(path, bundle);
    put("array", "bundle", "\1" + io::read_text(path));
    fs::remove(path);
}

}  // namespace

int main(int count, char** words) {
    if (count != 2) {
        std::fprintf(stderr, "usage: plumb_fuzz_seeds <folder>\n");
        return 2;
    }
    root = words[1];
    put_obj(), put_gltf(), put_png(), put_exr(), put_pictures(), put_toml(), put_arrays();
}
