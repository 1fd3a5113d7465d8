#include "mutate_json.h"

#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

namespace plumb::fuzz {
namespace {

using Json = nlohmann::ordered_json;
using Random = std::minstd_rand;

std::size_t pick(Random& random, std::size_t count) { return count == 0 ? 0 : random() % count; }

Json any_value(Random& random) {
    static const std::vector<Json> values = {
        0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 255, 256, 1023, 65535, 65536, 1048575, 268435455, 2147483647, 4294967295u, 4294967296,
        9007199254740991, 18446744073709551615u, -1, -2147483648, 0.5, -0.5, 1.5, 1e-45, 1e38, 1e39, 1e308, -1e308, 3.14159,
        5120, 5121, 5122, 5123, 5125, 5126, 9728, 9729, 9984, 9987, 33071, 33648, 10497, 34962, 34963,
        true, false, nullptr, "", "a", "SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT4", "MASK", "BLEND", "OPAQUE",
        "perspective", "orthographic", "spot", "point", "directional", "2.0", "a.bin", "a%20b.bin", "data:,",
        "data:application/octet-stream;base64,AAAA", "data:image/png;base64,iVBORw0KGgo=", "image/png", "image/jpeg",
        Json::array(), Json::object(), Json::array({0}), Json::array({1, 2, 3}), Json::array({0, 0, 0, 1})};
    return values[pick(random, values.size())];
}

std::string any_key(Random& random) {
    static constexpr const char* keys[] = {
        "asset", "version", "minVersion", "buffers", "byteLength", "uri", "bufferViews", "buffer", "byteOffset", "byteStride",
        "target", "accessors", "bufferView", "componentType", "count", "type", "max", "min", "normalized", "sparse", "indices",
        "values", "meshes", "primitives", "attributes", "POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0",
        "JOINTS_0", "WEIGHTS_0", "mode", "targets", "weights", "material", "materials", "pbrMetallicRoughness",
        "baseColorFactor", "baseColorTexture", "metallicFactor", "roughnessFactor", "metallicRoughnessTexture",
        "normalTexture", "occlusionTexture", "emissiveTexture", "emissiveFactor", "alphaMode", "alphaCutoff", "doubleSided",
        "index", "texCoord", "scale", "strength", "textures", "sampler", "source", "samplers", "magFilter", "minFilter",
        "wrapS", "wrapT", "images", "mimeType", "nodes", "mesh", "camera", "skin", "children", "matrix", "translation",
        "rotation", "scenes", "scene", "cameras", "perspective", "orthographic", "aspectRatio", "yfov", "zfar", "znear", "xmag",
        "ymag", "skins", "joints", "skeleton", "inverseBindMatrices", "animations", "extensions", "extras",
        "extensionsUsed", "extensionsRequired", "KHR_lights_punctual", "KHR_materials_emissive_strength",
        "emissiveStrength", "KHR_texture_transform", "offset", "lights", "light", "color", "intensity", "range", "spot",
        "innerConeAngle", "outerConeAngle", "name", "plumb", "order", "specular", "mirror", "exponent", "dynamic", "share"};
    return keys[pick(random, std::size(keys))];
}

// All values of a document, containers too.
void list(Json& value, std::vector<Json*>& all) {
    all.push_back(&value);
    for (std::size_t i = all.size() - 1; i < all.size(); ++i)
        if (all[i]->is_structured())
            for (Json& child : *all[i]) all.push_back(&child);
}

void remove_child(Json& parent, std::size_t which) {
    auto at = parent.begin();
    std::advance(at, std::ptrdiff_t(which));
    parent.erase(at);
}

void change(Json& value, const Json& other, Random& random) {
    switch (pick(random, 6)) {
        case 0: value = any_value(random); return;
        case 1: value = other; return;
        case 2:
            if (value.is_number_integer() || value.is_number_unsigned())
                value = value.get<std::int64_t>() + (pick(random, 2) == 0 ? 1 : -1);
            else if (value.is_number_float())
                value = value.get<double>() * (pick(random, 2) == 0 ? -1.0 : 1e20);
            else if (value.is_structured() && !value.empty())
                remove_child(value, pick(random, value.size()));
            return;
        case 3:
            if (value.is_structured() && !value.empty()) remove_child(value, pick(random, value.size()));
            return;
        default:
            if (value.is_array())
                value.push_back(pick(random, 2) == 0 ? any_value(random) : other);
            else if (value.is_object())
                value[any_key(random)] = pick(random, 2) == 0 ? any_value(random) : other;
            else
                value = any_value(random);
    }
}

}  // namespace

std::optional<std::string> mutate_json(const std::string& text, std::uint32_t seed) {
    Json document = Json::parse(text, nullptr, false);
    if (document.is_discarded()) return {};
    Random random(seed);
    random.discard(2);
    std::vector<Json*> all;
    list(document, all);
    const Json other = *all[pick(random, all.size())];
    change(*all[pick(random, all.size())], other, random);
    return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace plumb::fuzz
