// Malformed scene files as the user meets them: exit code 2, one line that names the file and the place, nothing
// written. The readers' own tests (tests/io) have many more; here the whole program runs, under the sanitizers too.
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <set>

#include "tests/png_bytes.h"
#include "tests/program/program.h"

using namespace plumb::program;

namespace {

struct Bad {
    const char* kind;
    std::string file;   // that is rendered
    std::string bytes;  // of it
    std::string names;  // what the line must say, besides the file
    std::vector<std::pair<std::string, std::string>> beside = {};  // further files
};

const std::string triangle_obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

// A scene of one mesh, with more lines.
std::string toml(const std::string& more, const std::string& mesh = "mesh.obj") {
    return "[[mesh]]\nfile = \"" + mesh + "\"\n" + more;
}

// What others read all the same: refused by --strict, drawn without it, with a note.
std::vector<Bad> lacking_obj() {
    return {
        {"texture index out of range", "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/2 3/1\n", "5"},
        {"normal index out of range", "n.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 1 0\nf 1//1 2//1 3//9\n", "5"},
        {"missing material library", "o.obj", "mtllib none.mtl\n" + triangle_obj, "none.mtl"},
        {"unknown material", "p.obj", "mtllib p.mtl\nusemtl gold\n" + triangle_obj, "gold", {{"p.mtl", "newmtl tin\n"}}},
        {"material without a name", "r.obj", "mtllib r.mtl\n" + triangle_obj, "r.mtl", {{"r.mtl", "newmtl\nKd 1 1 1\n"}}},
        {"missing texture", "t.obj", "mtllib t.mtl\nusemtl a\n" + triangle_obj, "none.png",
         {{"t.mtl", "newmtl a\nmap_Kd none.png\n"}}},
    };
}

std::vector<Bad> bad_obj() {
    return {
        {"empty file", "a.obj", "", ""},
        {"no triangles", "b.obj", "v 0 0 0\nv 1 0 0\n", ""},
        {"index out of range", "c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "4"},
        {"index zero", "d.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "4"},
        {"negative index out of range", "e.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 -2 -1\n", "4"},
        {"NaN vertex", "f.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "1"},
        {"infinite vertex", "g.obj", "v 0 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n", "2"},
        {"number overflows", "h.obj", "v 0 0 0\nv 1e39 0 0\nv 0 1 0\nf 1 2 3\n", "2"},
        {"not a number", "i.obj", "v 0 0 0\nv one 0 0\nv 0 1 0\nf 1 2 3\n", "2"},
        {"too few numbers", "j.obj", "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", "2"},
        {"face of two corners", "k.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "4"},
        {"face of one corner", "l.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1\n", "4"},
        {"binary file", "q.obj", std::string("\x7f\x45\x4c\x46\0\0\1\2v\0\0", 11), ""},
        {"reflectance is no number", "s.obj", "mtllib s.mtl\n" + triangle_obj, "s.mtl", {{"s.mtl", "newmtl a\nKd x 1 1\n"}}},
        {"texture is no picture", "u.obj", "mtllib u.mtl\nusemtl a\n" + triangle_obj, "u.png",
         {{"u.mtl", "newmtl a\nmap_Kd u.png\n"}, {"u.png", "this is text"}}},
        {"texture cut off", "v.obj", "mtllib v.mtl\nusemtl a\n" + triangle_obj, "v.png",
         {{"v.mtl", "newmtl a\nmap_Kd v.png\n"}, {"v.png", "\x89PNG\r\n\x1a\n"}}},
    };
}

std::vector<Bad> bad_toml() {
    std::vector<Bad> bad = {
        {"scene file is no text", "a.toml", std::string("\xff\xfe[\0f\0r\0", 8), ""},
        {"TOML syntax", "b.toml", "[[mesh]\nfile = 1\n", "1"},
        {"unknown key", "c.toml", toml("[frame]\nsise = [4, 4]\n"), "sise"},
        {"unknown table", "d.toml", toml("[fram]\nsize = [4, 4]\n"), "fram"},
        {"wrong type", "e.toml", toml("[frame]\nsize = \"large\"\n"), "size"},
        {"size of zero", "f.toml", toml("[frame]\nsize = [0, 4]\n"), "size"},
        {"size too large", "g.toml", toml("[frame]\nsize = [1000000, 4]\n"), "size"},
        {"far before near", "h.toml", toml("[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\nnear = 2\nfar = 1\n"), "far"},
        {"camera looks nowhere", "i.toml", toml("[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 5]\n"), "look_at"},
        {"NaN in the scene", "j.toml", toml("[camera]\nposition = [nan, 0, 5]\nlook_at = [0, 0, 0]\n"), "position"},
        {"unknown convention", "k.toml", "convention = \"metal\"\n" + toml(""), "metal"},
        {"unknown light type", "l.toml", toml("[[light]]\nname = \"a\"\ntype = \"area\"\n"), "type"},
        {"two lights of a name", "m.toml", toml("[[light]]\nname = \"a\"\n[[light]]\nname = \"a\"\n"), "name"},
        {"negative intensity", "n.toml", toml("[[light]]\nname = \"a\"\nintensity = [-1, 0, 0]\n"), "intensity"},
        {"cone of 90 degrees", "o.toml", toml("[[light]]\nname = \"a\"\ncone_deg = [80, 95]\n"), "cone_deg"},
        {"unknown method", "p.toml", toml("[render]\nmethod = \"magic\"\n"), "magic"},
        {"unknown layout", "q.toml", toml("[render]\nlayout = \"fp8\"\n"), "fp8"},
        {"parameter out of range", "r.toml", toml("[rsm]\nsamples = 0\n"), "samples"},
        {"transform cannot be inverted", "s.toml", toml("scale = 0\n"), "scale"},
        {"unknown generator", "t.toml", "[[mesh]]\ngenerate = \"casle\"\n", "casle"},
        {"mesh without a source", "u.toml", "[[mesh]]\ntranslate = [0, 0, 0]\n", "file"},
        {"missing mesh file", "v.toml", toml("", "none.obj"), "none.obj"},
        {"unknown kind of mesh", "w.toml", toml("", "mesh.fbx"), "mesh.fbx", {{"mesh.fbx", "x"}}},
        {"deep TOML", "x.toml", "a = " + std::string(100000, '[') + "\n", ""},
    };
    for (Bad& b : bad) b.beside.push_back({"mesh.obj", triangle_obj});
    return bad;
}

// One triangle: 36 bytes of positions, then indices 0, 1, 2 as u16.
const std::string buffer64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA=";

// A glTF document that is right, with one piece of text replaced.
std::string gltf(const std::string& from = "", const std::string& to = "") {
    std::string text =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],)"
        R"("materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.25,1]}}],)"
        R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
        R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],)"
        R"("buffers":[{"byteLength":44,"uri":"data:application/octet-stream;base64,)" +
        buffer64 + R"("}]})";
    if (!from.empty()) {
        const std::size_t at = text.find(from);
        REQUIRE(at != std::string::npos);
        text.replace(at, from.size(), to);
    }
    return text;
}

std::string word(std::uint32_t value) { return std::string(reinterpret_cast<const char*>(&value), 4); }
std::string glb(std::string json, std::uint32_t version = 2, int length_error = 0, std::uint32_t chunk_error = 0) {
    while (json.size() % 4) json += ' ';
    const std::uint32_t length = std::uint32_t(20 + json.size());
    return "glTF" + word(version) + word(length + std::uint32_t(length_error)) +
           word(std::uint32_t(json.size()) + chunk_error) + "JSON" + json;
}

std::vector<Bad> bad_gltf() {
    return {
        {"empty glTF", "a.gltf", "", ""},
        {"JSON syntax", "b.gltf", "{\"asset\":", ""},
        {"JSON cut off", "c.gltf", gltf().substr(0, 300), ""},
        {"deep JSON", "d.gltf", "{\"asset\":" + std::string(1000000, '['), ""},
        {"wrong version of glTF", "e.gltf", gltf("\"2.0\"", "\"1.0\""), "/asset/version"},
        {"no asset", "f.gltf", gltf("\"asset\":{\"version\":\"2.0\"},", ""), "asset"},
        {"unknown extension required", "g.gltf", gltf("{\"asset\"", "{\"extensionsRequired\":[\"KHR_magic\"],\"asset\""), "KHR_magic"},
        {"node index out of range", "h.gltf", gltf("\"nodes\":[0]", "\"nodes\":[7]"), "/scenes/0/nodes/0"},
        {"mesh index out of range", "i.gltf", gltf("{\"mesh\":0}", "{\"mesh\":3}"), "/nodes/0/mesh"},
        {"accessor index out of range", "j.gltf", gltf("\"POSITION\":0", "\"POSITION\":9"), "/meshes/0/primitives/0"},
        {"negative index", "k.gltf", gltf("\"indices\":1", "\"indices\":-1"), "/meshes/0/primitives/0/indices"},
        {"material index out of range", "l.gltf", gltf("\"material\":0", "\"material\":4"), "/meshes/0/primitives/0/material"},
        {"node cycle", "m.gltf", gltf("{\"mesh\":0}", "{\"mesh\":0,\"children\":[0]}"), "/nodes/0"},
        {"longer node cycle", "n.gltf", gltf("{\"mesh\":0}", "{\"mesh\":0,\"children\":[1]},{\"children\":[0]}"), "/nodes/"},
        {"view beyond its buffer", "o.gltf", gltf("\"byteOffset\":36", "\"byteOffset\":40"), "/bufferViews/1"},
        {"negative offset", "p.gltf", gltf("\"byteOffset\":36", "\"byteOffset\":-4"), "/bufferViews/1/byteOffset"},
        {"accessor beyond its view", "q.gltf", gltf("\"count\":3,\"type\":\"VEC3\"", "\"count\":4,\"type\":\"VEC3\""), "/accessors/0"},
        {"huge count", "r.gltf", gltf("\"count\":3,\"type\":\"SCALAR\"", "\"count\":4000000000000,\"type\":\"SCALAR\""), "/accessors/1"},
        {"wrong component type", "s.gltf", gltf("5126", "5127"), "/accessors/0/componentType"},
        {"wrong accessor type", "t.gltf", gltf("\"VEC3\"", "\"VEC7\""), "/accessors/0/type"},
        {"vertex index out of range", "u.gltf", gltf("AAAAAAABAAIAAAA=", "AAAAAAABAAkAAAA="), "/meshes/0/primitives/0"},
        {"buffer shorter than declared", "v.gltf", gltf("\"byteLength\":44", "\"byteLength\":4400"), "/buffers/0"},
        {"data is not base64", "w.gltf", gltf(buffer64, "!!!!"), "/buffers/0/uri"},
        {"missing buffer file", "x.gltf", gltf("data:application/octet-stream;base64," + buffer64, "none.bin"), "none.bin"},
        {"buffer outside the folder", "y.gltf", gltf("data:application/octet-stream;base64," + buffer64, "../../etc/passwd"), "/buffers/0/uri"},
        {"transform cannot be inverted", "z.gltf", gltf("{\"mesh\":0}", "{\"mesh\":0,\"scale\":[0,1,1]}"), "/nodes/0"},
        {"type mismatch in JSON", "aa.gltf", gltf("\"nodes\":[0]", "\"nodes\":\"all\""), "/scenes/0/nodes"},
        {"reflectance above 1", "bb.gltf", gltf("[1,0.5,0.25,1]", "[7,0.5,0.25,1]"), "/materials/0"},
        {"NaN vertex in a buffer", "cc.gltf", gltf("AAAAAAAAAAAAAAAAAACAPw", "AADAfwAAAAAAAAAAAACAPw"), "/accessors/0"},
        {"GLB magic", "dd.glb", "glTT" + glb(gltf()).substr(4), ""},
        {"GLB version", "ee.glb", glb(gltf(), 1), "version"},
        {"GLB length", "ff.glb", glb(gltf(), 2, 100), ""},
        {"GLB chunk length", "gg.glb", glb(gltf(), 2, 0, 4096), ""},
        {"GLB cut off", "hh.glb", glb(gltf()).substr(0, 17), ""},
    };
}

// Textures that only decoding finds out.
std::vector<Bad> bad_png() {
    std::vector<Bad> bad;
    for (const auto& [kind, bytes, message] : plumb::png_bytes::bad_pngs()) {
        const std::string name = "a" + std::to_string(bad.size());
        bad.push_back({kind, name + ".obj", "mtllib " + name + ".mtl\nusemtl a\n" + triangle_obj, message,
                       {{name + ".png", bytes}, {name + ".mtl", "newmtl a\nmap_Kd " + name + ".png\n"}}});
    }
    return bad;
}

void check(const std::vector<Bad>& corpus, const std::string& name, bool strict = false) {
    const std::string folder = fresh_folder("malformed_" + name);
    for (const Bad& bad : corpus) {
        INFO(bad.kind << ": " << bad.file);
        write(folder + "/" + bad.file, bad.bytes);
        for (const auto& [file, bytes] : bad.beside) write(folder + "/" + file, bytes);
        const std::vector<std::string> before = files_in(folder);
        std::vector<std::string> command = {"render", bad.file, "-o", "out"};
        if (strict) command.push_back("--strict");
        const Result r = run(command, folder);
        INFO(r.err);
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(r.err.find("plumb: ") == 0);
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK(r.err.size() < 400);
        const bool named = r.err.find(bad.file) != std::string::npos ||
                           (!bad.beside.empty() && r.err.find(bad.beside[0].first) != std::string::npos);
        CHECK(named);
        CHECK(r.err.find(bad.names) != std::string::npos);
        CHECK(files_in(folder) == before);
    }
}

}  // namespace

TEST_CASE("malformed: OBJ, MTL and textures", "[program][robustness]") { check(bad_obj(), "obj"); }
TEST_CASE("malformed: OBJ and MTL that lack something are drawn, and refused where one is strict", "[program][robustness]") {
    check(lacking_obj(), "lacking", true);
    const std::string folder = fresh_folder("malformed_lacking_drawn");
    for (const Bad& bad : lacking_obj()) {
        INFO(bad.kind << ": " << bad.file);
        write(folder + "/" + bad.file, bad.bytes);
        for (const auto& [file, bytes] : bad.beside) write(folder + "/" + file, bytes);
        const Result r = run({"render", bad.file, "-o", "out", "--size", "8x8"}, folder);
        CHECK(r.exit == 0);
        CHECK(r.err.empty());
        const std::size_t note = r.out.find("note: ");
        REQUIRE(note != std::string::npos);
        CHECK(r.out.find(bad.names, note) != std::string::npos);
    }
}
TEST_CASE("malformed: PNG textures with right checksums", "[program][robustness]") { check(bad_png(), "png"); }
TEST_CASE("malformed: TOML", "[program][robustness]") { check(bad_toml(), "toml"); }
TEST_CASE("malformed: glTF and GLB", "[program][robustness]") { check(bad_gltf(), "gltf"); }

TEST_CASE("malformed: sixty files of thirty kinds at least, and the sound ones render", "[program][robustness]") {
    std::set<std::string> kinds;
    std::size_t files = 0;
    for (const auto& corpus : {bad_obj(), lacking_obj(), bad_png(), bad_toml(), bad_gltf()})
        for (const Bad& bad : corpus) kinds.insert(bad.kind), ++files;
    CHECK(files >= 60);
    CHECK(kinds.size() >= 30);

    // What the malformed ones were made from is accepted: it is the damage that is refused.
    const std::string folder = fresh_folder("malformed_sound");
    const std::string tiny = "[frame]\nsize = [8, 8]\n";
    write(folder + "/mesh.obj", triangle_obj);
    write(folder + "/mesh.gltf", gltf());
    write(folder + "/mesh.glb", glb(gltf()));
    for (const char* mesh : {"mesh.obj", "mesh.gltf", "mesh.glb"}) {
        write(folder + "/scene.toml", toml(tiny, mesh));
        const Result r = run({"render", "scene.toml", "-o", "out"}, folder);
        INFO(mesh << ": " << r.err);
        CHECK(r.exit == 0);
    }
}
