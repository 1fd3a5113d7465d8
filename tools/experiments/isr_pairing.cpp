// plumb experiment isr --pairing pov: printed ISR and direct light against POV-Ray, as ISR 5.2 has them, reading by reading.
//
// All readings of a view are held against the same models, through the same displays: what the thesis does not say (the unit of
// light, the factor 2 pi / N, what (29) adds, how many bounces the model has, ties) is a row each.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/compare_pictures.h"
#include "core/content_hasher.h"
#include "core/error.h"
#include "gi/compose/compose.h"
#include "tools/experiments/isr.h"
#include "tools/shared/batch_pov.h"
#include "tools/shared/sweep_subject.h"

namespace plumb::cli {

namespace {

enum class Display : int { smooth, bytes, linear_bytes };
constexpr const char* display_names[] = {"sRGB", "sRGB, 8 bits", "not encoded, 8 bits"};

// What POV-Ray made of a script, kept as it wrote it, under a key of the script: no build changes it.
Image4 pov_kept(const std::string& folder, const std::string& name, const Scene& scene, const io::PovOptions& options, double& seconds) {
    const std::string script = io::pov_text(scene, options);
    ContentHasher key;
    key.add(script);
    key.add(std::int32_t(options.size.x), std::int32_t(options.size.y));
    const BatchRecords records(folder);
    const std::string file = name + ".exr", path = folder + "/" + file;
    if (const std::optional<Json> found = records.find(name, key.hash)) {
        seconds = found->at("seconds");
        return read_radiance(path, options.size);
    }
    std::filesystem::create_directories(folder);
    io::write_pov(folder + "/" + name + ".pov", scene, options);
    seconds = run_povray(folder + "/" + name + ".pov", path, options.size, folder + "/" + name + ".log");
    const Image4 picture = read_radiance(path, options.size);
    std::error_code ignored;
    for (const char* beside : {".pov", ".log"}) std::filesystem::remove(folder + "/" + name + beside, ignored);
    records.keep(name, key.hash, {file}, {{"seconds", seconds}});
    return picture;
}

// A picture as it is compared: of bytes n / 255.
compare::Picture shown(const Image4& radiance, double exposure, Display display, const RunOptions& options) {
    compose::TonemapParams params;
    params.exposure = float(exposure);
    if (display == Display::linear_bytes) params.gamma = 1;
    Image4 image;
    compose::run(params, compose::TonemapInputs{&radiance}, options, image);
    compare::Picture picture = isr_rgb(image);
    if (display != Display::smooth)
        for (float& v : picture.data) v = std::floor(255 * v + 0.5f) / 255;
    return picture;
}

struct Model {
    std::string name;
    Image4 radiance;
};

std::vector<std::string> model_names() {
    return {"POV-Ray, table 1", "POV-Ray, brightness 1", "traced, one bounce", "traced, all bounces"};
}

std::vector<Model> models_of(const IsrCommon& common, const std::string& name, const std::string& folder, const Scene& scene,
                             double& seconds) {
    const RunOptions& options = common.options;
    const std::vector<std::string> names = model_names();
    std::vector<Model> models;
    io::PovOptions pov;
    pov.preset = io::PovPreset::published, pov.size = scene.frame_size;
    models.push_back({names[0], pov_kept(folder, name + "_table_1", scene, pov, seconds)});
    pov.brightness = 1;
    double ignored = 0;
    models.push_back({names[1], pov_kept(folder, name + "_brightness_1", scene, pov, ignored)});
    const frame::Frame direct = isr_frame(scene, isr_settings(scene, "direct", {}), options);
    models.push_back({names[2], isr_own_picture(scene, direct, 1, common.request.samples, options).mean});
    reference::PathParams params;
    params.samples = common.request.samples;
    const std::unique_ptr<reference::PathScene> paths = reference::prepare(scene, params.rays);
    models.push_back({names[3], reference::trace(params, *paths, scene.camera, scene.frame_size, scene.seed, options).mean});
    return models;
}

Json pair_json(const IsrPair& p) {
    auto optional = [](const std::optional<double>& v) { return v ? Json(*v) : Json(nullptr); };
    return {p.direct_error, p.isr_error, optional(p.direct_pearson), optional(p.isr_pearson), p.better, p.worse};
}
Json pairing_json(const IsrPairing& p) {
    Json pairs = Json::array();
    for (const IsrPair& pair : p.pairs) pairs.push_back(pair_json(pair));
    return {p.pov_s, pairs};
}
IsrPairing pairing_of(const std::string& name, const Json& json) {
    auto optional = [](const Json& v) { return v.is_null() ? std::nullopt : std::optional(v.get<double>()); };
    IsrPairing p{name};
    p.pov_s = json.at(0);
    std::size_t i = 0;
    for (const std::string& model : model_names())
        for (const IsrReading& reading : isr_readings())
            for (const char* display : display_names) {
                const Json& j = json.at(1).at(i++);
                p.pairs.push_back({model, reading.name, display, j.at(0), j.at(1), optional(j.at(2)), optional(j.at(3)), j.at(4), j.at(5)});
            }
    return p;
}

IsrPairing measure(const IsrCommon& common, const BatchView& view, const std::string& folder) {
    const RunOptions& options = common.options;
    IsrPairing result{view.name};
    // What POV-Ray cannot show is left out of all pictures.
    const Scene scene = io::pov_scene(common.scenes.scene(view, common.request.size));
    const std::vector<Model> models = models_of(common, view.name, folder, scene, result.pov_s);
    // Every reading beside direct light with its own shadows and its own buffers.
    struct Rendered {
        Image4 direct, isr;
    };
    std::vector<Rendered> rendered;
    for (const IsrReading& reading : isr_readings()) {
        std::vector<std::string> direct = reading.sets;
        direct.push_back("isr.mode=F4");
        rendered.push_back({isr_frame(scene, isr_settings(scene, "isr", direct), options).radiance,
                            isr_frame(scene, isr_settings(scene, "isr", reading.sets), options).radiance});
    }
    compare::Options how;
    how.perceptual = false, how.threads = options.threads, how.encoding = compare::Encoding::ldr_srgb;
    for (const Model& model : models) {
        const double exposure = isr_exposure(model.radiance);
        std::vector<compare::Picture> truths;
        for (int d = 0; d < 3; ++d) truths.push_back(shown(model.radiance, exposure, Display(d), options));
        for (std::size_t i = 0; i < rendered.size(); ++i)
            for (int d = 0; d < 3; ++d) {
                const compare::Picture direct = shown(rendered[i].direct, exposure, Display(d), options),
                                       isr = shown(rendered[i].isr, exposure, Display(d), options);
                const compare::Report a = compare::compare(direct, truths[std::size_t(d)], how),
                                      b = compare::compare(isr, truths[std::size_t(d)], how);
                if (!a.mean_error || !b.mean_error) throw InputError("a picture with values that are no numbers: expected finite ones");
                const IsrPair pair{model.name,  isr_readings()[i].name, display_names[d], *a.mean_error,
                                   *b.mean_error, a.pearson,            b.pearson,
                                   compare::share_improved(truths[std::size_t(d)], direct, isr).value_or(0),
                                   compare::share_improved(truths[std::size_t(d)], isr, direct).value_or(0)};
                result.pairs.push_back(pair);
            }
    }
    return result;
}

}  // namespace

const std::vector<IsrReading>& isr_readings() {
    static const std::vector<IsrReading> all = [] {
        const std::vector<std::string> printed{"isr.variant=published", "isr.ssao_rings=4", "isr.k_ssao=0.5", "isr.k_isr=0.5"};
        auto with = [&](std::vector<std::string> more) {
            std::vector<std::string> sets = printed;
            sets.insert(sets.end(), more.begin(), more.end());
            return sets;
        };
        return std::vector<IsrReading>{
            {"as printed", printed, "(25), (26) and (29) with the factor 2 pi / N, 80 samples, k_ssao = k_isr = 0.5"},
            {"without k_ssao", with({"isr.k_ssao=0"}), "what indirect light alone does"},
            {"without k_isr", with({"isr.k_isr=0"}), "what ambient occlusion alone does"},
            {"2 pi / N left out", with({"isr.solid_angle=none"}), "the form factor has its solid angle already"},
            {"2 pi / N for the area", with({"isr.solid_angle=hemisphere"}), "each sample covers 2 pi / N of the hemisphere (4.4)"},
            {"2 pi / N for the area, without k_ssao", with({"isr.solid_angle=hemisphere", "isr.k_ssao=0"}), "indirect light of that alone"},
            {"occlusion added", with({"isr.ssao_term=occlusion"}), "(29) word by word: what is occluded is brighter"},
            {"PX in metres", with({"isr.length_unit=1"}), "(26) with a vector that is not unit"},
            {"a colour of 1 is 1 W/(m2 sr)", with({"isr.light_unit=1"}), "no unit of light: the lamps' watts decide"},
            {"printed, layout and shadows too", with({"render.layout=isr", "shadow.mode=esm", "shadow.variant=published"}),
             "fig. 4.1 and Listing 8; direct light has them as well"},
            {"corrected", {"isr.ambient=none"}, "ours by default: rings"}};
    }();
    return all;
}

std::vector<IsrPairing> isr_pairing(const IsrCommon& common, const std::vector<BatchView>& views, const std::string& folder) {
    std::string texts;
    for (const IsrReading& r : isr_readings()) texts += fmt::format("{}: {}\n", r.name, fmt::join(r.sets, " "));
    std::vector<IsrPairing> all;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const BatchView& view = views[i];
        show_progress(fmt::format("{}, {} of {}", view.name, i + 1, views.size()));
        ContentHasher key;
        key.add(program_hash(), common.scenes.content(view, common.request.size), std::int32_t(common.request.samples));
        key.add(texts);
        const std::string name = "pairing_" + view.name;
        if (const std::optional<Json> found = common.results.find(name, key.hash)) {
            all.push_back(pairing_of(view.name, *found));
            continue;
        }
        try {
            all.push_back(measure(common, view, folder));
            common.results.keep(name, key.hash, pairing_json(all.back()));
        } catch (const InputError& e) {
            all.push_back({view.name, e.what()});
        }
    }
    return all;
}

}  // namespace plumb::cli
