// A kernel and its twin are one text written twice. Their uniform blocks (names, order and std140 offsets) and their
// taps (names and order) are held against each other, read from the text of the twin.
#include <catch2/catch.hpp>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "gi/compose/compose_kernel.h"
#include "gi/compose/tonemap_kernel.h"
#include "gi/direct/direct_kernel.h"
#include "gi/direct/shadow_kernel.h"
#include "gi/rsm/gather_kernel.h"

using namespace plumb;

namespace {

struct Member {
    std::string name;
    std::size_t offset;
    bool operator==(const Member& other) const { return name == other.name && offset == other.offset; }
};
std::ostream& operator<<(std::ostream& out, const Member& m) { return out << m.name << " at " << m.offset; }

std::string text_of(const std::string& path) {
    std::ifstream file(std::string(PLUMB_SOURCE_DIR) + "/" + path);
    REQUIRE(file.good());
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

// The members between the braces that follow `opening` in the file, with their std140 offsets: float, int and uint take
// 4 bytes, vec4 16 on a multiple of 16, vec3 12 on a multiple of 16, and a struct as much as its members, rounded up to
// 16 (OpenGL 4.6, 7.6.2.2).
std::vector<Member> members_of_twin(const std::string& path, const std::string& opening) {
    const std::string all = text_of(path);
    const std::size_t at = all.find(opening);
    REQUIRE(at != all.npos);
    const std::size_t begin = all.find('{', at), end = all.find('}', begin);
    const std::string body = all.substr(begin, end - begin);

    std::vector<Member> members;
    std::size_t next = 0;
    const std::regex declaration(R"((float|int|uint|vec3|vec4|Projection)\s+(\w+)\s*;)");
    for (std::sregex_iterator i(body.begin(), body.end(), declaration), none; i != none; ++i) {
        const std::string type = (*i)[1];
        const bool map = type == "Projection";
        const std::size_t alignment = map || type[0] == 'v' ? 16 : 4;
        const std::size_t size = map ? 64 : type == "vec4" ? 16 : type == "vec3" ? 12 : 4;
        next = (next + alignment - 1) / alignment * alignment;
        members.push_back({(*i)[2], next});
        next += size;
    }
    return members;
}

// What the pattern's groups match, in order of the files' text.
std::vector<std::string> matches(const std::vector<std::string>& paths, const std::regex& pattern) {
    std::vector<std::string> found;
    for (const std::string& path : paths) {
        const std::string all = text_of(path);
        for (std::sregex_iterator i(all.begin(), all.end(), pattern), none; i != none; ++i)
            found.push_back((*i)[1].matched ? (*i)[1] : (*i)[2]);
    }
    return found;
}
// Names of taps; "sample" where the number of the sample is set, "choice" where an index is chosen.
std::vector<std::string> taps_of_kernel(const std::string& path) {
    std::vector<std::string> taps =
        matches({path}, std::regex(R"rx(\btap\("(\w+)"|(\btap\.sample|\bchosen)\((?!const|\)))rx"));
    std::replace(taps.begin(), taps.end(), std::string("tap.sample"), std::string("sample"));
    std::replace(taps.begin(), taps.end(), std::string("chosen"), std::string("choice"));
    return taps;
}
std::vector<std::string> taps_of_twin(const std::vector<std::string>& paths) {
    std::vector<std::string> taps = matches(paths, std::regex(R"(\bTAP\((\w+),|\b(TAP_SAMPLE|CHOICE)\()"));
    std::replace(taps.begin(), taps.end(), std::string("TAP_SAMPLE"), std::string("sample"));
    std::replace(taps.begin(), taps.end(), std::string("CHOICE"), std::string("choice"));
    return taps;
}

struct TappedTwin {
    std::string kernel;
    std::vector<std::string> twins;            // files that mirror it, in the order of its functions
    std::vector<std::string> of_explain = {};  // first: what explain() lists before it calls the kernel
};
const TappedTwin tapped_twins[] = {
    {"raster/project_kernel.h", {"raster/project.glsl"}},
    {"raster/texture_kernel.h", {"raster/texture.glsl"}},
    {"raster/surface_kernel.h", {"raster/surface.glsl"}},
    {"raster/gbuffer_kernel.h", {"raster/gbuffer.frag"}, {"object", "z"}},
    {"raster/rsm_kernel.h", {"raster/rsm.frag"}, {"z"}},  // the objects are not bound
    {"gi/rsm/gather_kernel.h", {"gi/rsm/gather_form.glsl", "gi/rsm/gather.comp", "gi/rsm/gather_all.comp"}},
    {"gi/direct/shadow_kernel.h", {"gi/direct/shadow.comp"}},
    {"gi/direct/direct_kernel.h", {"gi/direct/direct.comp"}},
    {"gi/compose/compose_kernel.h", {"gi/compose/compose.comp"}},
    {"gi/compose/tonemap_kernel.h", {"gi/compose/tonemap.comp"}},
};
const std::string without_twin[] = {"gi/rsm/all_rays_kernel.h"};  // traces rays

#define AT(type, member) Member{#member, offsetof(type, member)}

}  // namespace

TEST_CASE("twins: rsm.disc and rsm.all bind the kernel's uniforms", "[twins][std140]") {
    using U = rsm::GatherUniforms;
    const std::vector<Member> kernel{
        AT(U, map),   AT(U, least_distance2), AT(U, scale), AT(U, samples), AT(U, rotations),
        AT(U, width), AT(U, height),          AT(U, seed),  AT(U, reach)};
    CHECK(members_of_twin("gi/rsm/gather_form.glsl", "struct GatherUniforms") == kernel);
}

TEST_CASE("twins: the projection onto a map is one struct", "[twins][std140]") {
    using P = raster::Projection;
    const std::vector<Member> map{AT(P, to_texel_x), AT(P, to_texel_y), AT(P, to_texel_w), AT(P, least_w),
                                  AT(P, low),        AT(P, high),       AT(P, size)};
    CHECK(members_of_twin("raster/project.glsl", "struct Projection") == map);
    CHECK(sizeof(P) == 64);
}

TEST_CASE("twins: shadow and direct bind the kernels' uniforms", "[twins][std140]") {
    using S = direct::ShadowUniforms;
    const std::vector<Member> shadow{AT(S, map),       AT(S, eye),         AT(S, forward),   AT(S, footprint_scale),
                                     AT(S, footprint_base), AT(S, bias),   AT(S, slope_bias), AT(S, max_slope),
                                     AT(S, perspective), AT(S, kernel),    AT(S, samples),   AT(S, published),
                                     AT(S, face),      AT(S, width),       AT(S, height)};
    CHECK(members_of_twin("gi/direct/shadow.comp", "uniform ShadowUniforms") == shadow);
    using D = direct::DirectUniforms;
    const std::vector<Member> direct{AT(D, lights), AT(D, width), AT(D, height)};
    CHECK(members_of_twin("gi/direct/direct.comp", "uniform DirectUniforms") == direct);
    using L = raster::LightArgs;
    const std::vector<Member> light{AT(L, position), AT(L, cos_outer), AT(L, direction),
                                    AT(L, falloff_scale), AT(L, intensity), AT(L, directional)};
    CHECK(members_of_twin("raster/light.glsl", "struct LightArgs") == light);
}

TEST_CASE("twins: compose and tonemap bind the kernels' uniforms", "[twins][std140]") {
    using C = compose::ComposeUniforms;
    const std::vector<Member> compose{AT(C, environment), AT(C, inv_pi), AT(C, width), AT(C, height), AT(C, padding)};
    CHECK(members_of_twin("gi/compose/compose.comp", "uniform ComposeUniforms") == compose);
    using T = compose::TonemapUniforms;
    const std::vector<Member> tonemap{AT(T, op), AT(T, exposure), AT(T, width), AT(T, height)};
    CHECK(members_of_twin("gi/compose/tonemap.comp", "uniform TonemapUniforms") == tonemap);
}

TEST_CASE("twins: every tap of a kernel is in its twin, in the same order", "[twins][tap]") {
    for (const TappedTwin& t : tapped_twins) {
        INFO(t.kernel);
        const std::vector<std::string> kernel = taps_of_kernel(t.kernel);
        std::vector<std::string> twin = taps_of_twin(t.twins);
        if (!t.of_explain.empty()) {
            // They stand in main(), behind functions that the kernel's text has first, too.
            const auto at = std::search(twin.begin(), twin.end(), t.of_explain.begin(), t.of_explain.end());
            REQUIRE(at != twin.end());
            twin.erase(at, at + std::ptrdiff_t(t.of_explain.size()));
        }
        CHECK(kernel.size() > 0);
        CHECK(twin == kernel);
    }
}

TEST_CASE("twins: every kernel that has taps is held against a twin", "[twins][tap]") {
    const std::filesystem::path root(PLUMB_SOURCE_DIR);
    for (const char* folder : {"core", "raster", "gi"})
        for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
            const std::string path = std::filesystem::relative(entry.path(), root).generic_string();
            if (!std::regex_search(path, std::regex("_kernel\\.h$")) || taps_of_kernel(path).empty()) continue;
            INFO(path);
            const bool held = std::any_of(std::begin(tapped_twins), std::end(tapped_twins),
                                          [&](const TappedTwin& t) { return t.kernel == path; });
            const bool excepted = std::count(std::begin(without_twin), std::end(without_twin), path) > 0;
            CHECK(held != excepted);
        }
}
