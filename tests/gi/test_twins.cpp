// A kernel and its twin are one text written twice. Their taps (names and order) are held against each other, read from
// the text of both; what they bind: test_stage_bindings.cpp.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

namespace {

std::string text_of(const std::string& path) {
    std::ifstream file(std::string(PLUMB_SOURCE_DIR) + "/" + path);
    REQUIRE(file.good());
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
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
    {"raster/gbuffer_kernel.h", {"raster/gbuffer.glsl"}, {"object", "z"}},
    {"raster/rsm_kernel.h", {"raster/rsm.frag"}, {"z"}},  // the objects are not bound
    {"gi/rsm/gather_kernel.h", {"gi/rsm/gather_form.glsl", "gi/rsm/gather_disc.glsl", "gi/rsm/gather_all.comp"}},
    {"gi/rsm/texels_kernel.h", {"gi/rsm/whole_texels.glsl", "gi/rsm/continuous_texels.glsl"}},
    {"gi/rsm/paths_kernel.h", {"gi/rsm/gather_paths.glsl"}},
    {"gi/direct/log_blur_kernel.h", {"gi/direct/log_blur.comp"}},
    {"gi/direct/shadow_kernel.h", {"gi/direct/shadow.comp"}},
    {"gi/direct/visibility_filter_kernel.h", {"gi/direct/visibility_filter.comp"}},
    {"gi/direct/direct_kernel.h", {"gi/direct/direct.comp"}},
    {"gi/filter/weights_kernel.h", {"gi/filter/weights.glsl"}},
    {"gi/filter/reduce_kernel.h", {"gi/filter/reduce.comp"}},
    {"gi/filter/upsample_kernel.h", {"gi/filter/upsample.comp"}},
    {"gi/filter/blur_kernel.h", {"gi/filter/blur.comp"}},
    {"gi/isr/downsample_kernel.h", {"gi/isr/downsample.comp"}},
    {"gi/isr/gather_kernel.h", {"gi/isr/gather_by.glsl", "gi/isr/gather.comp"}},
    {"gi/isr/bounce_kernel.h", {"gi/isr/bounce.comp"}},
    {"gi/isr/unseen_kernel.h", {"gi/isr/unseen.comp"}},
    {"gi/isr/gather_camera_kernel.h", {"gi/isr/gather_camera.comp"}},
    {"gi/isr/ssao_kernel.h", {"gi/isr/ssao.comp"}},
    {"gi/isr/blur_kernel.h", {"gi/isr/blur.comp"}},
    {"gi/isr/upsample_kernel.h", {"gi/isr/upsample.comp"}},
    {"gi/isr/compose_kernel.h", {"gi/isr/compose.comp"}},
    {"gi/ddgi/blend_kernel.h", {"gi/ddgi/blend.comp"}},
    {"gi/ddgi/border_kernel.h", {"gi/ddgi/border.comp"}},
    {"gi/ddgi/sample_kernel.h", {"gi/ddgi/sample.comp"}},
    {"gi/radiosity/items_kernel.h", {"gi/radiosity/items.comp"}},
    {"gi/radiosity/gather_kernel.h", {"gi/radiosity/gather.comp"}},
    {"gi/radiosity/lookup_kernel.h", {"gi/radiosity/lookup.comp"}},
    {"gi/radiosity/reduce_kernel.h", {"gi/radiosity/reduce.comp"}},
    {"gi/probes/basis_kernel.h", {"gi/probes/basis.comp"}},
    {"gi/probes/irradiance_kernel.h", {"gi/probes/irradiance.comp"}},
    {"gi/probes/lightmap_write_kernel.h", {"gi/probes/lightmap_write.comp"}},
    {"gi/probes/coefficients_kernel.h", {"gi/probes/coefficients.comp"}},
    {"gi/probes/density_kernel.h", {"gi/probes/density.comp"}},
    {"gi/probes/lambda_kernel.h", {"gi/probes/lambda.comp"}},
    {"gi/probes/radiance_kernel.h", {"gi/probes/radiance.comp"}},
    {"gi/probes/lightmap_kernel.h", {"gi/probes/lightmap_levels.glsl"}},
    {"gi/probes/level_kernel.h", {"gi/probes/level.comp", "gi/probes/level.glsl"}},
    {"gi/probes/share_kernel.h", {"gi/probes/share.comp"}},
    {"gi/probes/supports_kernel.h", {"gi/probes/supports.comp"}},
    {"gi/probes/lightmap_uv_kernel.h", {"gi/probes/lightmap_uv.comp"}},
    {"gi/probes/lookup_kernel.h", {"gi/probes/lookup.comp"}},
    {"gi/probes/indirect_shadow_kernel.h", {"gi/probes/indirect_shadow.comp"}},
    {"gi/probes/relief_kernel.h", {"gi/probes/relief.comp"}},
    {"gi/probes/volume_kernel.h", {"gi/probes/volume.glsl", "gi/probes/volume.comp"}},
    {"gi/zbuffer/shade_kernel.h", {"gi/zbuffer/shade.glsl"}},
    {"gi/zbuffer/vertices_kernel.h", {"gi/zbuffer/vertices.comp"}},
    {"gi/zbuffer/interpolate_kernel.h", {"gi/zbuffer/seen_triangle.glsl", "gi/zbuffer/interpolate.comp"}},
    {"gi/zbuffer/pixels_kernel.h", {"gi/zbuffer/pixels.comp"}},
    {"gi/screen/view_kernel.h", {"gi/screen/view.glsl"}},
    {"gi/screen/reuse_kernel.h", {"gi/screen/reuse.comp"}},
    {"gi/screen/ssao_kernel.h", {"gi/screen/ssao.comp"}},
    {"gi/screen/horizon_kernel.h", {"gi/screen/horizon.comp"}},
    {"gi/screen/blur_kernel.h", {"gi/screen/blur.comp"}},
    {"gi/screen/occlude_kernel.h", {"gi/screen/occlude.comp"}},
    {"gi/screen/mirrored_ray_kernel.h", {"gi/screen/mirrored_ray.glsl"}},
    {"gi/screen/lobe_kernel.h", {"gi/screen/lobe.comp"}},
    {"gi/screen/reflect_kernel.h", {"gi/screen/reflect.comp"}},
    {"gi/screen/nearest_kernel.h", {"gi/screen/nearest.comp"}},
    {"gi/screen/cells_kernel.h", {"gi/screen/cells.comp"}},
    {"gi/screen/mirror_kernel.h", {"gi/screen/mirror.comp"}},
    {"gi/compose/compose_kernel.h", {"gi/compose/compose.comp"}},
    {"gi/compose/tonemap_kernel.h", {"gi/compose/tonemap.comp"}},
};
// One traces rays; the other is what validate holds shaders against that read through samplers: no frame runs it.
const std::string without_twin[] = {"gi/rsm/all_rays_kernel.h", "gi/rsm/sampled_kernel.h"};

}  // namespace

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
