#include <cmath>
#include <functional>

#include "gltf_files.h"
#include "tests/png_bytes.h"

using namespace plumb;
using namespace plumb::io;

namespace {

struct Malformed {
    const char* kind;
    std::function<void(GltfSample&)> change;
    std::string message;  // after "a.gltf: "
};

Json& primitive(GltfSample& s) { return s.json["meshes"][0]["primitives"][0]; }

void give_textures(GltfSample& s) {
    s.json["images"] = Json::array({{{"uri", "none.png"}}});
    s.json["textures"] = Json::array({{{"source", 0}}});
    s.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
}

void give_light(GltfSample& s, const std::string& light) {
    s.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({Json::parse(light)});
    s.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
}

void give_camera(GltfSample& s, const std::string& camera) {
    s.json["cameras"] = Json::array({Json::parse(camera)});
    s.json["nodes"][0]["camera"] = 0;
}

void give_sparse(GltfSample& s, std::uint16_t index) {
    s.add<std::uint16_t>({index}, 5123, "SCALAR", 1);
    s.add<float>({5, 6, 7}, 5126, "VEC3", 3);
    s.json["accessors"][0]["sparse"] = Json::parse(
        R"({"count": 1, "indices": {"bufferView": 4, "componentType": 5123}, "values": {"bufferView": 5}})");
}

const double nan_value = std::nan("");

// Values in JSON that a test puts anywhere: the place and the cause have to come back.
const std::vector<Malformed> cases = {
    {"version 1", [](GltfSample& s) { s.json["asset"]["version"] = "1.0"; },
     "/asset/version = \"1.0\": expected glTF 2.0"},
    {"no asset", [](GltfSample& s) { s.json.erase("asset"); }, "/asset: is missing"},
    {"asset is a number", [](GltfSample& s) { s.json["asset"] = 3; }, "/asset = 3: expected an object"},
    {"required extension", [](GltfSample& s) { s.json["extensionsRequired"] = {"KHR_draco_mesh_compression"}; },
     "/extensionsRequired/0 = \"KHR_draco_mesh_compression\": the file requires an extension that is not read"},
    {"list is an object", [](GltfSample& s) { s.json["meshes"] = Json::object({{"a", 1}}); },
     "/meshes: expected an array"},
    {"name is a number", [](GltfSample& s) { s.json["materials"][0]["name"] = 7; },
     "/materials/0/name = 7: expected a string"},

    {"buffer without a length", [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "data:;base64,AAAA"}}; },
     "/buffers/0/byteLength: is missing"},
    {"buffer of no bytes",
     [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "data:;base64,"}, {"byteLength", 0}}; },
     "/buffers/0/byteLength = 0: expected 1 to"},
    {"buffer shorter than declared",
     [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "data:;base64,AAAA"}, {"byteLength", 4}}; },
     "/buffers/0/byteLength = 4: the buffer has 3 bytes"},
    {"huge buffer", [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "data:;base64,AAAA"}, {"byteLength", 1e15}}; },
     "/buffers/0/byteLength = 1e+15: expected 1 to"},
    {"negative length", [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "data:;base64,AA"}, {"byteLength", -4}}; },
     "/buffers/0/byteLength = -4: expected a whole number from 0 on"},
    {"buffer without uri", [](GltfSample& s) { s.json["buffers"][0] = {{"byteLength", 4}}; },
     "/buffers/0: has no uri, and no GLB chunk holds it"},
    {"buffer file missing",
     [](GltfSample& s) { s.json["buffers"][0] = {{"byteLength", 4}, {"uri", "none.bin"}}; },
     "/buffers/0/uri: "},
    {"not base64", [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "data:;base64,A*AA"}, {"byteLength", 3}}; },
     "a data: URI that is not base64"},
    {"data URI of text", [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "data:,abc"}, {"byteLength", 3}}; },
     "a data: URI that is not base64"},
    {"data URI without comma",
     [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "data:base64"}, {"byteLength", 3}}; },
     "a data: URI without a comma"},
    {"remote buffer",
     [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "http://example.org/a.bin"}, {"byteLength", 3}}; },
     "only files beside this one and data: are read"},
    {"absolute path", [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "/etc/passwd"}, {"byteLength", 3}}; },
     "expected the name of a file beside this one"},
    {"broken percent code", [](GltfSample& s) { s.json["buffers"][0] = {{"uri", "a%2"}, {"byteLength", 3}}; },
     "\"%\" without two hexadecimal digits"},

    {"view beyond its buffer", [](GltfSample& s) { s.json["bufferViews"][0]["byteLength"] = 1000; },
     "/bufferViews/0: bytes 0 to 1000 of a buffer of"},
    {"view offset beyond its buffer", [](GltfSample& s) { s.json["bufferViews"][0]["byteOffset"] = 1000; },
     "/bufferViews/0: bytes 1000 to"},
    {"negative view offset", [](GltfSample& s) { s.json["bufferViews"][0]["byteOffset"] = -8; },
     "/bufferViews/0/byteOffset = -8: expected a whole number from 0 on"},
    {"view of no buffer", [](GltfSample& s) { s.json["bufferViews"][0]["buffer"] = 1; },
     "/bufferViews/0/buffer = 1: out of range; the file has 1 buffers"},
    {"stride too small", [](GltfSample& s) { s.json["bufferViews"][0]["byteStride"] = 8; },
     "/bufferViews/0/byteStride = 8: an element has 12 bytes"},
    {"odd stride", [](GltfSample& s) { s.json["bufferViews"][0]["byteStride"] = 13; },
     "/bufferViews/0/byteStride = 13: expected a multiple of 4"},
    {"huge stride", [](GltfSample& s) { s.json["bufferViews"][0]["byteStride"] = 256; },
     "/bufferViews/0/byteStride = 256: expected 4 to 252"},

    {"accessor of no view", [](GltfSample& s) { s.json["accessors"][0]["bufferView"] = 9; },
     "/accessors/0/bufferView = 9: out of range; the file has 4 bufferViews"},
    {"accessor beyond its view", [](GltfSample& s) { s.json["accessors"][0]["count"] = 5; },
     "/accessors/0: 5 elements end at byte 60 of a bufferView of 48"},
    {"accessor offset beyond its view", [](GltfSample& s) { s.json["accessors"][0]["byteOffset"] = 4; },
     "/accessors/0: 4 elements end at byte 52 of a bufferView of 48"},
    {"huge offset", [](GltfSample& s) { s.json["accessors"][0]["byteOffset"] = 9007199254740992.0; },
     "/accessors/0/byteOffset = 9.007199254740992e+15: expected 0 to"},
    {"huge count", [](GltfSample& s) { s.json["accessors"][0]["count"] = 4294967295u; },
     "/accessors/0/count = 4294967295: expected 1 to 268435456"},
    {"count of nothing", [](GltfSample& s) { s.json["accessors"][0]["count"] = 0; },
     "/accessors/0/count = 0: expected 1 to"},
    {"fractional count", [](GltfSample& s) { s.json["accessors"][0]["count"] = 3.5; },
     "/accessors/0/count = 3.5: expected a whole number"},
    {"zeros without end",
     [](GltfSample& s) { s.json["accessors"][0].erase("bufferView"), s.json["accessors"][0]["count"] = 1 << 28; },
     "/accessors/0/count = 268435456: accessors without a bufferView have 268435456 elements; a file of"},
    {"coordinates moved beyond all numbers",
     [](GltfSample& s) {
         const float far = 3e38f;
         std::memcpy(s.buffer.data() + s.json["bufferViews"][2]["byteOffset"].get<std::size_t>() + 8, &far, 4);
         const std::string picture = png_bytes::png(png_bytes::header(1, 1) + png_bytes::data(std::string(4, '\0')));
         s.json["images"] = Json::array({{{"uri", "data:image/png;base64," + base64(picture)}}});
         s.json["textures"] = Json::array({{{"source", 0}}});
         s.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] =
             Json::parse(R"({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [10, 1]}}})");
     },
     "/meshes/0/primitives/0/attributes/TEXCOORD_0 = 2: element 1 is not finite once KHR_texture_transform has moved it"},
    {"zeros again and again",
     [](GltfSample& s) {
         s.json["accessors"][0].erase("bufferView"), s.json["accessors"][0]["count"] = 3999;
         s.json["meshes"][0]["primitives"] = Json::array({{{"attributes", {{"POSITION", 0}}}}, {{"attributes", {{"POSITION", 0}}}}});
     },
     "/accessors/0/count = 3999: accessors without a bufferView have 7998 elements; a file of"},
    {"unknown component", [](GltfSample& s) { s.json["accessors"][0]["componentType"] = 5124; },
     "/accessors/0/componentType = 5124: expected one of"},
    {"positions of integers", [](GltfSample& s) { s.json["accessors"][0]["componentType"] = 5123; },
     "/accessors/0/componentType = 5123: expected 5126 (float) at /meshes/0/primitives/0/attributes/POSITION"},
    {"unknown type", [](GltfSample& s) { s.json["accessors"][0]["type"] = "VEC5"; },
     "/accessors/0/type = \"VEC5\": expected SCALAR"},
    {"positions in two dimensions", [](GltfSample& s) { s.json["accessors"][0]["type"] = "VEC2"; },
     "/accessors/0/type = \"VEC2\": expected VEC3 at /meshes/0/primitives/0/attributes/POSITION"},
    {"coordinates not normalized",
     [](GltfSample& s) {
         s.json["accessors"][2]["componentType"] = 5121;
     },
     "/accessors/2: integers that are not normalized"},
    // 3.7.2.1: floats, or unsigned bytes or shorts.
    {"coordinates of signed bytes",
     [](GltfSample& s) {
         s.json["accessors"][2]["componentType"] = 5120;
         s.json["accessors"][2]["normalized"] = true;
     },
     "/accessors/2/componentType = 5120: expected 5121, 5123 or 5126 at /meshes/0/primitives/0/attributes/TEXCOORD_0"},
    {"coordinates of signed shorts",
     [](GltfSample& s) {
         s.json["accessors"][2]["componentType"] = 5122;
         s.json["accessors"][2]["normalized"] = true;
     },
     "/accessors/2/componentType = 5122: expected 5121, 5123 or 5126 at /meshes/0/primitives/0/attributes/TEXCOORD_0"},
    {"indices of signed shorts", [](GltfSample& s) { s.json["accessors"][3]["componentType"] = 5122; },
     "/accessors/3/componentType = 5122: expected one of 5121, 5123, 5125 at /meshes/0/primitives/0/indices"},
    {"position is NaN", [](GltfSample& s) { s.buffer.replace(4, 4, bytes_of<float>({float(nan_value)})); },
     "/accessors/0: element 0 is not finite"},
    {"position is infinite", [](GltfSample& s) { s.buffer.replace(12, 4, bytes_of<float>({INFINITY})); },
     "/accessors/0: element 1 is not finite"},
    {"normal is NaN", [](GltfSample& s) { s.buffer.replace(48, 4, bytes_of<float>({float(nan_value)})); },
     "/accessors/1: element 0 is not finite"},
    {"sparse index out of range", [](GltfSample& s) { give_sparse(s, 4); },
     "/accessors/0/sparse/indices: index 4 is out of range; the accessor has 4 elements"},
    {"sparse count beyond the accessor",
     [](GltfSample& s) { give_sparse(s, 3), s.json["accessors"][0]["sparse"]["count"] = 5; },
     "/accessors/0/sparse/count = 5: expected 1 to 4"},
    {"sparse beyond its view",
     [](GltfSample& s) { give_sparse(s, 3), s.json["accessors"][0]["sparse"]["count"] = 2; },
     "/accessors/0/sparse/indices: 2 elements end at byte 4 of a bufferView of 2"},
    {"sparse without values",
     [](GltfSample& s) { give_sparse(s, 3), s.json["accessors"][0]["sparse"].erase("values"); },
     "/accessors/0/sparse/values: is missing"},

    {"index out of range", [](GltfSample& s) { s.buffer.replace(128, 2, bytes_of<std::uint16_t>({4})); },
     "/meshes/0/primitives/0/indices = 3: element 0 is 4: out of range; there are 4 vertices"},
    {"restart of a strip", [](GltfSample& s) { s.buffer.replace(130, 2, bytes_of<std::uint16_t>({65535})); },
     "/meshes/0/primitives/0/indices = 3: element 1 is 65535: out of range"},
    {"indices of floats", [](GltfSample& s) { primitive(s)["indices"] = 1; },
     "/accessors/1/type = \"VEC3\": expected SCALAR at /meshes/0/primitives/0/indices"},
    {"no such accessor of indices", [](GltfSample& s) { primitive(s)["indices"] = 4; },
     "/meshes/0/primitives/0/indices = 4: out of range; the file has 4 accessors"},
    {"negative accessor", [](GltfSample& s) { primitive(s)["attributes"]["NORMAL"] = -1; },
     "/meshes/0/primitives/0/attributes/NORMAL = -1: expected a whole number"},
    {"no such material", [](GltfSample& s) { primitive(s)["material"] = 1; },
     "/meshes/0/primitives/0/material = 1: out of range; the file has 1 materials"},
    {"no positions", [](GltfSample& s) { primitive(s)["attributes"].erase("POSITION"); },
     "holds no triangle: 1 primitive without POSITION"},
    {"no attributes", [](GltfSample& s) { primitive(s).erase("attributes"); },
     "/meshes/0/primitives/0/attributes: is missing"},
    {"no primitives", [](GltfSample& s) { s.json["meshes"][0].erase("primitives"); },
     "/meshes/0/primitives: is missing"},
    {"unknown mode", [](GltfSample& s) { primitive(s)["mode"] = 7; },
     "/meshes/0/primitives/0/mode = 7: expected 0 to 6"},
    {"half a triangle", [](GltfSample& s) { s.json["accessors"][3]["count"] = 5; },
     "/meshes/0/primitives/0: 5 corners; expected three a triangle"},
    {"fewer normals than positions", [](GltfSample& s) { s.json["accessors"][1]["count"] = 3; },
     "/meshes/0/primitives/0/attributes/NORMAL = 1: has 3 elements; POSITION has 4"},
    {"tangent without a side",
     [](GltfSample& s) {
         primitive(s)["attributes"]["TANGENT"] =
             s.add<float>({1, 0, 0, 1, 1, 0, 0, 0.5f, 1, 0, 0, 1, 1, 0, 0, 1}, 5126, "VEC4", 4);
     },
     "/meshes/0/primitives/0/attributes/TANGENT = 4: element 1 has w = 0.5; expected 1 or -1"},
    {"only points", [](GltfSample& s) { primitive(s)["mode"] = 0; }, "holds no triangle: 1 primitive of points"},
    {"no mesh in the scene", [](GltfSample& s) { s.json["nodes"][0].erase("mesh"); }, "holds no triangle"},
    {"order with a hole",
     [](GltfSample& s) {
         primitive(s)["extras"]["plumb"]["order"] = s.add<std::uint32_t>({0, 2}, 5125, "SCALAR", 1);
     },
     "/meshes/0: extras/plumb/order: triangle 2 is out of range or there twice"},

    {"node is its own child", [](GltfSample& s) { s.json["nodes"][0]["children"] = {0}; },
     "/nodes/0: is its own ancestor"},
    {"cycle of nodes",
     [](GltfSample& s) {
         s.json["nodes"].push_back({{"children", {2}}});
         s.json["nodes"].push_back({{"children", {1}}});
     },
     "is its own ancestor"},
    {"two parents",
     [](GltfSample& s) {
         s.json["nodes"].push_back({{"children", {3}}});
         s.json["nodes"].push_back({{"children", {3}}});
         s.json["nodes"].push_back(Json::object());
     },
     "/nodes/2/children/0 = 3: node 1 is its parent already"},
    {"no such child", [](GltfSample& s) { s.json["nodes"][0]["children"] = {5}; },
     "/nodes/0/children/0 = 5: out of range; the file has 1 nodes"},
    {"no such node", [](GltfSample& s) { s.json["scenes"][0]["nodes"] = {1}; },
     "/scenes/0/nodes/0 = 1: out of range; the file has 1 nodes"},
    {"a node listed twice", [](GltfSample& s) { s.json["scenes"][0]["nodes"] = {0, 0}; },
     "/scenes/0/nodes/1 = 0: is listed twice"},
    {"a child as root",
     [](GltfSample& s) {
         s.json["nodes"].push_back({{"children", {0}}});
     },
     "/scenes/0/nodes/0 = 0: expected a root; node 1 is its parent"},
    {"no such scene", [](GltfSample& s) { s.json["scene"] = 1; }, "/scene = 1: out of range; the file has 1 scenes"},
    {"no such mesh", [](GltfSample& s) { s.json["nodes"][0]["mesh"] = 1; },
     "/nodes/0/mesh = 1: out of range; the file has 1 meshes"},
    {"flat matrix", [](GltfSample& s) { s.json["nodes"][0]["scale"] = {1, 0, 1}; },
     "/nodes/0: its transform to the world cannot be inverted"},
    {"flat parent",
     [](GltfSample& s) {
         s.json["nodes"].push_back({{"children", {0}}, {"scale", {0, 0, 0}}});
         s.json["scenes"][0]["nodes"] = {1};
     },
     "/nodes/0: its transform to the world cannot be inverted"},
    {"matrix of 15", [](GltfSample& s) { s.json["nodes"][0]["matrix"] = std::vector<int>(15, 1); },
     "/nodes/0/matrix: expected 16 numbers"},
    {"perspective matrix", [](GltfSample& s) { s.json["nodes"][0]["matrix"] = std::vector<int>(16, 1); },
     "/nodes/0/matrix: expected 0, 0, 0, 1 in the last row"},
    {"matrix and translation",
     [](GltfSample& s) {
         s.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
         s.json["nodes"][0]["translation"] = {1, 2, 3};
     },
     "/nodes/0/translation: stands beside matrix"},
    {"no rotation", [](GltfSample& s) { s.json["nodes"][0]["rotation"] = {0, 0, 0, 0}; },
     "/nodes/0/rotation: expected a quaternion of length 1"},
    {"word for a number", [](GltfSample& s) { s.json["nodes"][0]["translation"] = {0, "1", 0}; },
     "/nodes/0/translation/1 = \"1\": expected a number"},

    {"reflectance above 1",
     [](GltfSample& s) { s.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 2, 1, 1}; },
     "/materials/0/pbrMetallicRoughness/baseColorFactor/1 = 2: expected 0 to 1"},
    {"colour of three", [](GltfSample& s) { s.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1}; },
     "/materials/0/pbrMetallicRoughness/baseColorFactor: expected 4 numbers"},
    {"negative emission", [](GltfSample& s) { s.json["materials"][0]["emissiveFactor"] = {0, -1, 0}; },
     "/materials/0/emissiveFactor/1 = -1: expected 0 to 1"},
    {"unknown alpha mode", [](GltfSample& s) { s.json["materials"][0]["alphaMode"] = "GLASS"; },
     "/materials/0/alphaMode = \"GLASS\": expected OPAQUE, MASK or BLEND"},
    {"mirror above 1", [](GltfSample& s) { s.json["materials"][0]["extras"]["plumb"]["mirror"] = {0, 0, 1.5}; },
     "/materials/0/extras/plumb/mirror/2 = 1.5: expected 0 to 1"},
    {"exponent below 0", [](GltfSample& s) { s.json["materials"][0]["extras"]["plumb"]["exponent"] = -1; },
     "/materials/0/extras/plumb/exponent = -1: expected 0 to 1000000"},
    {"more reflected than received",
     [](GltfSample& s) { s.json["materials"][0]["extras"]["plumb"]["specular"] = {0, 0, 0.5}; },
     "/materials/0/extras/plumb: material \"paint\" reflects more than it receives: reflectance 0.75 + specular "
     "0.5 + mirror 0 in blue"},
    {"no such texture",
     [](GltfSample& s) { s.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 3; },
     "/materials/0/pbrMetallicRoughness/baseColorTexture/index = 3: out of range; the file has 0 textures"},
    {"texture without a number",
     [](GltfSample& s) { s.json["materials"][0]["normalTexture"] = Json::object({{"scale", 1}}); },
     "/materials/0/normalTexture/index: is missing"},
    {"no such image", [](GltfSample& s) { give_textures(s), s.json["textures"][0]["source"] = 1; },
     "/textures/0/source = 1: out of range; the file has 1 images"},
    {"no such sampler", [](GltfSample& s) { give_textures(s), s.json["textures"][0]["sampler"] = 0; },
     "/images/0/uri: "},
    {"picture missing", give_textures, "none.png: cannot be read: No such file or directory"},
    {"picture of text",
     [](GltfSample& s) { give_textures(s), s.json["images"][0]["uri"] = "data:image/png;base64,AAAA"; },
     "/images/0/uri: byte 0: does not begin as a .png file does"},
    {"picture of nothing",
     [](GltfSample& s) { give_textures(s), s.json["images"][0]["uri"] = "data:image/png;base64,"; },
     "/images/0/uri: is empty; expected a picture"},
    {"picture twice", [](GltfSample& s) { give_textures(s), s.json["images"][0]["bufferView"] = 0; },
     "/images/0: expected either uri or bufferView"},
    {"picture in no view", [](GltfSample& s) { give_textures(s), s.json["images"][0] = {{"bufferView", 9}}; },
     "/images/0/bufferView = 9: out of range; the file has 4 bufferViews"},

    {"camera without a lens", [](GltfSample& s) { give_camera(s, R"({"type": "perspective"})"); },
     "/cameras/0/perspective: is missing"},
    {"unknown camera", [](GltfSample& s) { give_camera(s, R"({"type": "fisheye"})"); },
     "/cameras/0/type = \"fisheye\": expected perspective or orthographic"},
    {"near plane at 0",
     [](GltfSample& s) { give_camera(s, R"({"type": "perspective", "perspective": {"yfov": 1, "znear": 0}})"); },
     "/cameras/0/perspective: camera: near = 0: must be above 0"},
    {"no angle of view",
     [](GltfSample& s) { give_camera(s, R"({"type": "perspective", "perspective": {"yfov": 0, "znear": 1}})"); },
     "/cameras/0/perspective: camera: fov_y_deg = 0: must be above 0"},
    {"far plane before near",
     [](GltfSample& s) {
         give_camera(s, R"({"type": "perspective", "perspective": {"yfov": 1, "znear": 2, "zfar": 1}})");
     },
     "/cameras/0/perspective: camera: far = 1: must be above near"},
    {"no such camera", [](GltfSample& s) { s.json["nodes"][0]["camera"] = 0; },
     "/nodes/0/camera = 0: out of range; the file has 0 cameras"},
    {"unknown light", [](GltfSample& s) { give_light(s, R"({"type": "area"})"); },
     "/extensions/KHR_lights_punctual/lights/0/type = \"area\": expected directional, point or spot"},
    {"negative light", [](GltfSample& s) { give_light(s, R"({"type": "point", "intensity": -1})"); },
     "/extensions/KHR_lights_punctual/lights/0/intensity = -1: expected a number of at least 0"},
    {"spot without a cone", [](GltfSample& s) { give_light(s, R"({"type": "spot"})"); },
     "/extensions/KHR_lights_punctual/lights/0/spot: is missing"},
    {"inner cone outside",
     [](GltfSample& s) {
         give_light(s, R"({"type": "spot", "spot": {"innerConeAngle": 0.6, "outerConeAngle": 0.5}})");
     },
     "/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle = 0.6: is larger than outerConeAngle"},
    {"no such light", [](GltfSample& s) { s.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 2; },
     "/nodes/0/extensions/KHR_lights_punctual/light = 2: out of range; the file has 0 lights"},
};

std::string error(const std::string& name, const std::string& content) {
    const Folder folder;
    return error_of([&] { load(folder, name, content); });
}

}  // namespace

TEST_CASE("gltf: a malformed value is one line with file, place and cause", "[io][robustness]") {
    CHECK(error("a.gltf", square().gltf()) == "");
    CHECK(cases.size() >= 60);
    for (const Malformed& malformed : cases) {
        CAPTURE(malformed.kind);
        GltfSample sample = square();
        malformed.change(sample);
        require_message(error("a.gltf", sample.gltf()), {"a.gltf: ", malformed.message});
    }
}

TEST_CASE("gltf: text that is not JSON is refused at its byte", "[io][robustness]") {
    const std::vector<std::pair<std::string, std::string>> texts = {
        {"", "a.gltf: is empty; expected glTF"},
        {"{", "a.gltf: byte 2: "},
        {"[]", "a.gltf: /: expected an object"},
        {"{\"asset\": {\"version\": \"2.0\"}} x", "a.gltf: byte 31: "},
        {"{\"asset\": {\"version\": \"2.0\", \"version\": \"2.0\"}}", "an object holds \"version\" twice"},
        {"{\"asset\": {\"version\": \"2.0\"}, \"scene\": 1e999}", "number overflow"},
        {"{\"asset\": \"\xff\"}", "byte 12: "},
        {"{\"a\": \"\n\"}", "a.gltf: byte 8: "},
        {"{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [NaN]}", "a.gltf: byte "},
    };
    for (const auto& [text, message] : texts) {
        CAPTURE(text);
        require_message(error("a.gltf", text), {message});
    }
    // A byte order mark is not JSON's, but does no harm.
    CHECK(error("a.gltf", "\xef\xbb\xbf" + square().gltf()) == "");
}

TEST_CASE("gltf: deep nesting and floods of values are refused before they are parsed", "[io][robustness]") {
    for (std::size_t n : {65u, 1000000u}) {
        require_message(error("a.gltf", std::string(n, '[')), {"a.gltf: byte 64: values nested deeper than 64"});
        std::string objects;
        for (std::size_t i = 0; i < n; ++i) objects += "{\"\\\"[\":";
        require_message(error("a.gltf", objects), {"values nested deeper than 64"});
    }
    std::string flood = "[0";
    for (int i = 0; i < (1 << 24); ++i) flood += ",0";
    require_message(error("a.gltf", flood + "]"), {"more than 16777216 values"});
    // Nodes may nest as deep as they like.
    GltfSample chain = square();
    for (int n = 1; n < 100000; ++n) chain.json["nodes"].push_back({{"children", {n + 1}}});
    chain.json["nodes"].push_back({{"mesh", 0}});
    chain.json["scenes"][0]["nodes"] = {1};
    CHECK(error("a.gltf", chain.gltf()) == "");
}

TEST_CASE("glb: a header or a chunk that lies is refused at its byte", "[io][robustness]") {
    const std::string good = square().glb();
    CHECK(error("a.glb", good) == "");
    const auto changed = [&](std::size_t at, std::uint32_t value) {
        return std::string(good).replace(at, 4, bytes_of<std::uint32_t>({value}));
    };
    const std::uint32_t size = std::uint32_t(good.size());
    const std::vector<std::pair<std::string, std::string>> files = {
        {"", "a.glb: is empty; expected glTF"},
        {"glTF", "a.glb: byte 4: the header of 12 bytes is cut off"},
        {changed(0, 0x46546c66), "a.glb: byte 0: does not begin as a .glb file does, with \"glTF\""},
        {changed(4, 1), "a.glb: byte 4: GLB version 1; expected 2"},
        {changed(8, size + 1), "a.glb: byte 8: declares"},
        {good + "x", "a.glb: byte 8: declares"},
        {changed(12, 0xfffffffc), "a.glb: byte 12: a chunk of 4294967292 bytes;"},
        {changed(12, 5), "a.glb: byte 12: a chunk of 5 bytes; expected a multiple of 4"},
        {changed(16, 0x004e4942), "a.glb: byte 16: the first chunk is not JSON"},
        {std::string(good).substr(0, 8) + bytes_of<std::uint32_t>({12}), "a.glb: byte 12: there is no JSON chunk"},
    };
    for (const auto& [file, message] : files) {
        CAPTURE(message);
        require_message(error("a.glb", file), {message});
    }
}

TEST_CASE("glb: cut off at any byte it is refused, changed at any byte it loads or is refused", "[io][robustness]") {
    const Folder folder;
    CHECK(load_damaged(folder, "a.glb", square().glb(), [](const std::string& path) { read_gltf(path); }) == 0);
}
