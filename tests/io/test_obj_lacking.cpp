// OBJ and MTL files that lack something, or hold what has no part in a picture: they are read, a note a kind says what was
// done, and strict refuses what is lacking.
#include <fmt/format.h>

#include "files.h"
#include "io/image_file.h"
#include "io/obj.h"

using namespace plumb;
using namespace plumb::io;

namespace {

const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.5\n";
const std::string face = "f 1/1 2/1 3/1\n";

// A file with those notes, each of them in that order and complete; refused by strict at the first, if `refused`.
struct Lacking {
    std::string obj, mtl;
    std::vector<std::string> notes;
    std::string refusal;  // "": strict reads it too
};

void check(const Folder& folder, const Lacking& c) {
    CAPTURE(c.obj, c.mtl);
    folder.put("m.mtl", c.mtl);
    const std::string path = folder.put("m.obj", c.obj), place = folder / "";
    const ObjModel model = read_obj(path);
    REQUIRE(model.mesh.triangles.size() == 1);
    std::vector<std::string> notes;
    for (std::string note : model.notes) {
        for (std::size_t at; (at = note.find(place)) != note.npos;) note.erase(at, place.size());
        notes.push_back(note);
    }
    CHECK(notes == c.notes);
    if (c.refusal.empty())
        CHECK(read_obj(path, true).mesh.triangles.size() == 1);
    else
        require_message(error_of([&] { read_obj(path, true); }), {c.refusal, "; --strict refuses that"});
}

constexpr std::uint32_t red = 0xff0000ffu, green = 0xff00ff00u;

}  // namespace

TEST_CASE("obj: what is lacking is replaced and said, once a kind, and refused by strict", "[io]") {
    const Folder folder;
    const std::string m = "mtllib m.mtl\n", a = "newmtl a\nKd 0.25 0.25 0.25\n";
    const std::vector<Lacking> cases = {
        {m + triangle + "usemtl a\n" + face, a, {}, ""},
        {"mtllib no.mtl\nmtllib nor.mtl\n" + triangle + face, a,
         {"m.obj: line 1: mtllib: there is no file \"no.mtl\": materials that only it has are grey, 0.5 (and 1 more of the kind)"},
         "m.obj: line 1: mtllib: there is no file \"no.mtl\""},
        {"mtllib\n" + triangle + face, a, {"m.obj: line 1: mtllib names nothing: it is passed over"}, "line 1: mtllib names nothing"},
        {m + triangle + "usemtl aa\n" + face, a,
         {"m.obj: line 6: usemtl: unknown material \"aa\"; the nearest known one is \"a\": it is grey, 0.5"},
         "m.obj: line 6: usemtl: unknown material \"aa\"; the nearest known one is \"a\""},
        {triangle + "usemtl a\n" + face, a, {"m.obj: line 5: usemtl: unknown material \"a\"; no mtllib gives any: it is grey, 0.5"},
         "no mtllib gives any"},
        {triangle + "usemtl\n" + face, a, {"m.obj: line 5: usemtl names nothing: faces after it are grey, 0.5"}, "usemtl names nothing"},
        {triangle + "hello world\n\x01\x02\n" + face, a,
         {"m.obj: line 5: \"hello\" is not a statement of OBJ: it is passed over (and 1 more of the kind)"}, "line 5: \"hello\""},
        {triangle + "call b.obj\n" + face, a,
         {"m.obj: line 5: \"call\": calls of other files and programs are not read: it is passed over"}, "line 5: \"call\""},
        {triangle + "cstype bezier\ndeg 3\ncurv 0 1 1 2 3\nend\n" + face, a,
         {"m.obj: line 5: \"cstype\": free-form curves and surfaces are not read: they are not drawn (and 3 more of the kind)"},
         "free-form"},
        {triangle + "f 1 2\nf\n" + face, a,
         {"m.obj: line 5: f has 2 corners; a face has at least 3: it is passed over (and 1 more of the kind)"}, "f has 2 corners"},
        {triangle + "f 1// 2/1/ 3/\n", a, {}, ""},
        {triangle + "f 1/1/1 2/1/2 3/1/1\n", a,
         {"m.obj: line 5: f: normal 1 is out of range; the file has 0: the corner goes without (and 2 more of the kind)"}, "normal 1"},
        {triangle + "f 1/-2 2/2 3/1\n", a,
         {"m.obj: line 5: f: texture coordinate -2 is out of range; the file has 1: the corner goes without (and 1 more of the kind)"},
         "texture coordinate -2"},
        // Not read, and no fault of the file.
        {triangle + "p 1\nl 1 2\nl 2 3\n" + face, a, {"m.obj: points and lines are not drawn (1 and 2 statements)"}, ""},
        {"v 0 0 0 1 0 0\n" + triangle + "f 1 2 3\n", a, {"m.obj: the colours of 1 vertices are not read"}, ""},
        {"v 0 0 0 1\n" + triangle + "f 2 3 4\n", a, {}, ""},  // a weight
        {"g x\no y\ns 1\nvp 1\nlod 3\n" + triangle + face, a, {}, ""},
    };
    for (const Lacking& c : cases) check(folder, c);

    // A scene file can describe what no library has.
    const ObjModel model = read_obj(folder.put("m.obj", triangle + "usemtl brick\n" + face));
    REQUIRE(model.materials.size() == 1);
    CHECK(model.materials[0].name == "brick");
    CHECK(model.materials[0].reflectance == glm::vec3(0.5f));
}

TEST_CASE("mtl: what is lacking is replaced and said, once a kind, and refused by strict", "[io]") {
    const Folder folder;
    const std::string obj = "mtllib m.mtl\n" + triangle + face;
    const std::vector<Lacking> cases = {
        {obj, "# nothing\n", {"m.mtl: holds no material (newmtl): it is passed over"}, "holds no material"},
        {obj, "Kd 1\nnewmtl a\n", {"m.mtl: line 1: Kd before the first newmtl: it is passed over"}, "line 1: Kd before"},
        {obj, "newmtl\n", {"m.mtl: line 1: newmtl has no name: no face can name it"}, "newmtl has no name"},
        {obj, "newmtl a\nnewmtl a\n", {"m.mtl: line 2: material \"a\" is there already: the first of the name is taken"},
         "line 2: material \"a\""},
        {obj, "newmtl a\nKd 1.5 2 0\n", {"m.mtl: line 2: Kd = 1.5: expected 0 to 1: 1 is taken (and 1 more of the kind)"}, "Kd = 1.5"},
        {obj, "newmtl a\nKd spectral f.rfl\n", {"m.mtl: line 2: Kd: colours by \"spectral\" are not read: it is passed over"},
         "line 2: Kd"},
        {obj, "newmtl a\nmap_Kd\n", {"m.mtl: line 2: map_Kd names no file: its material goes without"}, "map_Kd names no file"},
        {obj, "newmtl a\nmap_Kd no.png\nmap_Ke nor.png\n",
         {"m.mtl: line 2: map_Kd: there is no file \"no.png\": its material goes without (and 1 more of the kind)"}, "no.png"},
        {obj, "newmtl a\nmap_Kd a.mov\n",
         {"m.mtl: line 2: map_Kd: there is no file \"a.mov\": its material goes without"}, "a.mov"},
        {obj, "newmtl a\nhello 1\n", {"m.mtl: line 2: \"hello\" is not a statement of MTL: it is passed over"}, "\"hello\""},
        // Not read, and no fault of the file.
        {obj, "newmtl a\nd 0.5\nnewmtl b\nTr 0.5\nnewmtl c\nd 1\nTr 1\n",
         {"m.mtl: what is transparent (d, Tr) is drawn opaque in 2 of 3 materials"}, ""},
        {obj, "newmtl a\nmap_Ks x.png\nTf 1 1 1\nKa 1 1 1\nNi 1.5\n", {"m.mtl: not read: Tf, map_Ks"}, ""},
    };
    for (const Lacking& c : cases) check(folder, c);
    folder.put("b.mov", "x");
    check(folder, {obj, "newmtl a\nmap_Kd b.mov\n",
                   {"m.mtl: line 2: map_Kd: \"b.mov\" is of no kind of pictures that is read: its material goes without"}, "b.mov"});

    // A picture that is there and damaged is no picture that is missing.
    folder.put("bad.png", "x");
    folder.put("m.mtl", "newmtl a\nmap_Kd bad.png\n");
    require_message(error_of([&] { read_obj(folder.put("m.obj", obj)); }), {"m.mtl: line 2: map_Kd: ", "bad.png"});
    // What goes without its picture keeps its colour, and the default without one.
    folder.put("m.mtl", "newmtl a\nmap_Kd no.png\nnewmtl b\nKd 0.25\nmap_Kd no.png\n");
    const ObjModel model = read_obj(folder / "m.obj");
    CHECK(model.materials[0].reflectance == glm::vec3(0.5f));
    CHECK(model.materials[1].reflectance == glm::vec3(0.25f));
    CHECK(model.textures.empty());
}

TEST_CASE("obj: mtllib names one file with blanks or several; each is read once", "[io]") {
    const Folder folder;
    folder.put("a b.mtl", "newmtl ab\nKd 0.125\n");
    folder.put("a.mtl", "newmtl a\nKd 0.25\n");
    folder.put("b.mtl", "newmtl b\nKd 0.5\n");
    const auto names = [&](const std::string& libraries) {
        std::string all;
        const ObjModel model = read_obj(folder.put("m.obj", libraries + triangle + face), true);
        for (const Material& m : model.materials) all += m.name + " ";
        return all;
    };
    CHECK(names("mtllib a b.mtl\n") == "ab default ");
    CHECK(names("mtllib b.mtl a.mtl\n") == "b a default ");
    CHECK(names("mtllib a.mtl\nmtllib a.mtl b.mtl\nmtllib a b.mtl\n") == "a b ab default ");
}

TEST_CASE("obj: names of files as other systems write them", "[io]") {
    const Folder folder;
    std::filesystem::create_directories(folder / "sub");
    folder.put("sub/t.mtl", "newmtl a\nKd 0.25\nmap_Kd ..\\pictures\\Bark.png\n");
    const std::uint8_t pixels[] = {255, 0, 0};
    std::filesystem::create_directories(folder / "pictures");
    write_png(folder / "pictures/Bark.png", 1, 1, pixels);
    const auto read = [&](const std::string& library, bool strict = false) {
        return read_obj(folder.put("m.obj", "mtllib " + library + "\n" + triangle + "usemtl a\n" + face), strict);
    };
    // Backslashes are no fault; another case, or another folder, is one.
    CHECK(read("sub\\t.mtl", true).textures.at(0).texels(0, 0) == red);
    for (const std::string library : {"C:\\models\\sub\\t.mtl", "sub/T.MTL", "SUB\\..\\sub\\T.mtl"}) {
        CAPTURE(library);
        if (library[0] == 'C') folder.put("t.mtl", "newmtl a\nKd 0.25\nmap_Kd pictures/bark.PNG\n");
        const ObjModel model = read(library);
        REQUIRE(model.textures.size() == 1);
        REQUIRE_FALSE(model.notes.empty());
        CHECK(model.notes[0].find("there is no file") != std::string::npos);
        require_message(error_of([&] { read(library, true); }), {"there is no file", "--strict"});
    }
    // A picture may lie beside the OBJ and not beside the library.
    folder.put("sub/t.mtl", "newmtl a\nmap_Kd pictures/Bark.png\n");
    CHECK(read("sub/t.mtl", true).textures.size() == 1);
    // A name ends where its line does, and not at a zero byte in it: there is a picture "x".
    write_png(folder / "x.png", 1, 1, pixels);
    std::filesystem::rename(folder / "x.png", folder / "x");
    folder.put("t.mtl", std::string("newmtl a\nmap_Kd x\0.png\n", 23));
    CHECK(read("t.mtl").textures.empty());
}

TEST_CASE("obj: UTF-16 and UTF-8 with a mark are read", "[io]") {
    const std::string text = "mtllib m.mtl\n" + triangle + "usemtl \xc3\xa9\xf0\x9f\x99\x82\n" + face;
    const auto utf16 = [](const std::u16string& units, bool big) {
        std::string bytes = big ? "\xfe\xff" : "\xff\xfe";
        for (const char16_t u : units) {
            const char low = char(u & 255), high = char(u >> 8);
            bytes += big ? high : low, bytes += big ? low : high;
        }
        return bytes;
    };
    std::u16string wide(u"mtllib m.mtl\n");
    for (const char c : triangle) wide += char16_t(c);
    wide += u"usemtl \u00e9\U0001f642\n";
    for (const char c : face) wide += char16_t(c);
    const std::u16string wide_library = u"newmtl \u00e9\U0001f642\nKd 0.25\n";
    for (const bool big : {false, true}) {
        const Folder folder;
        folder.put("m.mtl", utf16(wide_library, big));
        CHECK(read_obj(folder.put("m.obj", utf16(wide, big)), true).materials.at(0).reflectance == glm::vec3(0.25f));
        // Names are the same in any encoding.
        CHECK(read_obj(folder.put("m.obj", "\xef\xbb\xbf" + text), true).materials.size() == 1);
    }
}

TEST_CASE("mtl: pictures lie where -s, -o and -clamp put them", "[io]") {
    const Folder folder;
    const std::uint8_t pixels[] = {255, 0, 0, 0, 255, 0};
    write_png(folder / "t.png", 2, 1, pixels);
    write_png(folder / "2 t.png", 2, 1, pixels);
    folder.put("m.mtl",
               "newmtl plain\nmap_Kd t.png\n"
               "newmtl moved\nmap_Kd -blendu on -s 2 4 8 -texres 512 -o 0.5 0.25 -clamp on -bm 1 2 t.png\n"
               "newmtl one\nmap_Kd -s 3 2 t.png\n"
               "newmtl colourspace\nmap_Kd -colorspace linear t.png\n"
               "newmtl unknown\nmap_Kd -new 1 2 t.png\n");
    std::string text = "mtllib m.mtl\n" + triangle + "vn 0 0 1\n";
    for (const char* name : {"plain", "moved", "one", "colourspace", "unknown", "plain"})
        text += fmt::format("usemtl {}\nf 1/1/1 2/1/1 3/1/1\n", name);
    const ObjModel model = read_obj(folder.put("m.obj", text), true);
    const auto at = [&](std::size_t t) {
        const Vertex& v = model.mesh.vertices[model.mesh.triangles[t].x];
        return glm::vec2(v.u, 1 - v.v);  // v from the bottom, as the file has it
    };
    CHECK(at(0) == glm::vec2(0.25f, 0.5f));
    CHECK(at(1) == glm::vec2(2 * 0.25f + 0.5f, 4 * 0.5f + 0.25f));
    CHECK(at(2) == glm::vec2(3 * 0.25f, 2 * 0.5f));
    CHECK(at(3) == at(0));
    // What lies alike shares its vertices.
    CHECK(model.mesh.triangles[5] == model.mesh.triangles[0]);
    CHECK(model.mesh.triangles[3] == model.mesh.triangles[0]);
    CHECK(model.mesh.triangles[1].x != model.mesh.triangles[0].x);
    CHECK(model.mesh.vertices.size() == 9);
    REQUIRE(model.textures.size() == 2);  // the file with a blank, clamped, is another
    CHECK(model.textures[0].wrap_u == Wrap::repeat);
    CHECK(model.textures[1].wrap_u == Wrap::clamp_to_edge);
    REQUIRE(model.notes.size() == 1);
    CHECK(model.notes[0].find("options of pictures that are not read: -colorspace, -new") != std::string::npos);
}

TEST_CASE("mtl: map_d cuts out, map_Ke shines, bump is normals where it has their colours", "[io]") {
    const Folder folder;
    const std::uint8_t colours[] = {255, 0, 0, 0, 255, 0}, mask[] = {0, 0, 0, 255, 255, 255, 255, 0, 0, 102, 1, 1};
    const std::uint8_t normals[] = {128, 128, 255, 140, 120, 250}, heights[] = {10, 10, 10, 200, 200, 200};
    write_png(folder / "c.png", 2, 1, colours);
    write_png(folder / "m.png", 4, 1, mask);
    write_png(folder / "n.png", 2, 1, normals);
    write_png(folder / "h.png", 2, 1, heights);
    folder.put("m.mtl",
               "newmtl leaf\nmap_Kd c.png\nmap_d m.png\nmap_Bump n.png\n"
               "newmtl hole\nKd 0.25\nmap_d m.png\nbump h.png\n"
               "newmtl lamp\nmap_Ke c.png\nnewmtl bright\nKe 4\nmap_Ke c.png\nnorm h.png\n");
    const ObjModel model = read_obj(folder.put("m.obj", "mtllib m.mtl\n" + triangle + face), true);
    const std::vector<Material>& m = model.materials;
    const auto texture = [&](int i) -> const Texture& { return model.textures.at(std::size_t(i)); };

    // Of four texels of the mask the second and the fourth hold the centres of two, or begin there.
    CHECK(texture(m[0].texture).texels(0, 0) == red);
    CHECK(texture(m[0].texture).texels(1, 0) == ((green & 0xffffffu) | 102u << 24));
    CHECK(m[0].alpha_cutoff == 0.5f);
    CHECK(m[0].reflectance == glm::vec3(1));
    CHECK_FALSE(texture(m[0].normal_texture).srgb);
    CHECK(texture(m[0].normal_texture).texels(0, 0) == 0xffff8080u);

    CHECK(texture(m[1].texture).texels(0, 0) == 0x00ffffffu);
    CHECK(texture(m[1].texture).texels(1, 0) == 0xffffffffu);
    CHECK(m[1].reflectance == glm::vec3(0.25f));
    CHECK(m[1].normal_texture == -1);

    CHECK(texture(m[2].emission_texture).texels(1, 0) == green);
    CHECK(m[2].emission == glm::vec3(1));
    CHECK(m[3].emission == glm::vec3(4));
    CHECK(m[3].emission_texture == m[2].emission_texture);
    CHECK(m[3].normal_texture == -1);
    REQUIRE(model.notes.size() == 2);
    CHECK(model.notes[0].find("heights (bump) are not read in 2 of 4 materials") != std::string::npos);
    CHECK(model.notes[1].find("taken for a map of them in 1 of 4 materials") != std::string::npos);
}

TEST_CASE("mtl: Pr and Pm are glTF's roughness and metalness, in place of Ks", "[io]") {
    const Folder folder;
    folder.put("m.mtl", "newmtl rough\nKd 0.5\nPr 0.25\nnewmtl metal\nKd 1 0.5 0.25\nPm 1\nPr 0.125\nKs 1\nillum 2\nnewmtl dull\nPm 0.5\n"
                        "newmtl plain\nKd 0.5\n");
    const ObjModel model = read_obj(folder.put("m.obj", "mtllib m.mtl\n" + triangle + face), true);
    const std::vector<Material>& m = model.materials;
    CHECK((m[0].microfacet && m[0].roughness == 0.25f && m[0].metalness == 0));
    CHECK((m[1].microfacet && m[1].roughness == 0.125f && m[1].metalness == 1 && m[1].specular == glm::vec3(0)));
    CHECK((m[2].microfacet && m[2].roughness == 1 && m[2].metalness == 0.5f));
    CHECK_FALSE(m[3].microfacet);
    for (const char* bad : {"Pr 1.5", "Pm -1", "Pr x", "Pm nan", "Pr"}) {
        folder.put("m.mtl", std::string("newmtl a\n") + bad + "\n");
        require_message(error_of([&] { read_obj(folder / "m.obj"); }), {"m.mtl: line 2: P", "expected 0 to 1"});
    }
}

TEST_CASE("obj: texture coordinates that a material moves beyond all numbers are refused", "[io][robustness]") {
    const Folder folder;
    folder.put("m.mtl", "newmtl a\nmap_Kd -s 10 1 none.png\n");
    const std::string start = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 3e38\nvt 3e37\nusemtl a\n";
    CHECK(read_obj(folder.put("a.obj", start + "f 1/2 2/2 3/2\n")).mesh.triangles.size() == 1);
    require_message(error_of([&] { read_obj(folder.put("a.obj", start + "f 1/1 2/2 3/2\n")); }),
                    {"a.obj: line 8: f: vt 3e+38 0 is not finite once -s and -o of its material have moved it"});
}
