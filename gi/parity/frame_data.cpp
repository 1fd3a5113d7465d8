#include <algorithm>

#include "core/error.h"
#include "gi/compose/compose.h"
#include "gi/direct/direct.h"
#include "gi/direct/log_blur.h"
#include "gi/filter/filter.h"
#include "gi/frame/filters.h"
#include "gi/frame/isr.h"
#include "gi/isr/isr.h"
#include "gi/parity/stages.h"
#include "gi/rsm/gather.h"
#include "raster/bindings.h"
#include "raster/light_view.h"

namespace plumb::parity {

namespace {

// A light's name as a part of a file's: letters, digits and '-' stay.
std::string word_of(const std::string& name) {
    std::string word;
    for (const char c : name)
        word += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ? c : '_';
    return word.empty() ? "light" : word;
}

Image4 or_zeros(const Image4& image, glm::ivec2 size) { return image.empty() ? Image4(size.x, size.y) : image; }

struct Builder {
    const Scene& scene;
    const frame::Settings& settings;
    const frame::Frame& frame;
    Geometry geometry;
    raster::Surfaces surfaces;
    std::vector<Light> lights;
    std::vector<std::string> words;                 // of the lights, no two alike
    std::vector<std::vector<raster::Rsm>> maps{};   // [light][map]; size 0 where a face sees nothing
    Image4 position, normal, albedo, emission, direct, indirect, radiance;
    frame::Frame filtered{};                        // what filters read, where they run: zeros for what is missing
    Buffer<float> visibility;
    std::vector<std::vector<Image4>> blurred{};     // [light][map]
    std::vector<StageData> out{};

    Builder(const Scene& s, const frame::Settings& t, const frame::Frame& f)
        : scene(s), settings(t), frame(f), geometry(flatten(s)), surfaces(raster::prepare(s, geometry)) {
        for (Light light : s.lights) {
            if (!light.on) light.intensity = glm::vec3(0);
            lights.push_back(light);
            std::string word = word_of(light.name);
            while (std::find(words.begin(), words.end(), word) != words.end()) word += "_";
            words.push_back(word);
        }
        const glm::ivec2 size = s.frame_size;
        const raster::GBuffer& g = f.gbuffer;
        position = or_zeros(g.position, size), normal = or_zeros(g.normal, size);
        albedo = or_zeros(g.albedo, size), emission = or_zeros(g.emission, size);
        direct = or_zeros(f.direct, size), indirect = or_zeros(f.indirect, size);
        radiance = or_zeros(f.radiance, size);
        if (frame::filters_indirect(t)) add_filtered();
        if (frame::gathers_isr(t)) add_image_space();
        visibility = f.visibility;
        visibility.resize(s.lights.size() * position.size(), 1.0f);
    }

    void add_filtered() {
        const glm::ivec2 size = scene.frame_size, half = frame::gather_size(settings, size);
        frame::Frame& f = filtered;
        f.gbuffer.position = position, f.gbuffer.normal = normal;
        f.half_position = or_zeros(frame.half_position, half), f.half_normal = or_zeros(frame.half_normal, half);
        f.gathered = or_zeros(frame.gathered, half);
        f.upsampled = or_zeros(frame.upsampled, size), f.blurred_across = or_zeros(frame.blurred_across, size);
    }

    // What method isr reads and makes: zeros for what is missing.
    void add_image_space() {
        frame::Frame& f = filtered;
        raster::GBuffer& g = f.gbuffer;
        g.position = position, g.normal = normal, g.albedo = albedo, g.emission = emission;
        g.depth = frame.gbuffer.depth, g.exact_depth = frame.gbuffer.exact_depth;
        f.direct = direct, f.indirect = indirect, f.isr = frame.isr, f.views = frame.views;
        frame::begin_views(scene, settings, f);
        for (std::size_t v = 1; v < f.views.size(); ++v) {
            frame::SourceView& view = f.views[v];
            raster::GBuffer& seen = view.gbuffer;
            for (Image4* image : {&seen.position, &seen.normal, &seen.albedo, &seen.emission, &view.direct})
                *image = or_zeros(*image, view.size);
        }
        for (const frame::IsrStage& stage : frame::isr_stages(scene, settings)) {
            frame::PlannedStage of;
            of.name = stage.name, of.form = stage.form, of.view = stage.view, of.pass = stage.pass;
            Image4& image = frame::isr_result(f, of);
            const glm::ivec2 size = frame::isr_size(scene, settings, of);
            if (glm::ivec2(image.width, image.height) != size) image = Image4(size.x, size.y);
        }
    }

    View view_of(const frame::PlannedStage& stage) const {
        const glm::ivec2 size = size_of(stage);
        const Camera& camera = stage.view == 0 ? scene.camera : filtered.views[std::size_t(stage.view)].camera;
        return make_view(camera, double(size.x) / size.y, scene.convention, size);
    }
    glm::ivec2 size_of(const frame::PlannedStage& stage) const {
        return stage.view == 0 ? scene.frame_size : filtered.views[std::size_t(stage.view)].size;
    }
    const Image4& position_of(const frame::PlannedStage& stage) const {
        return stage.view == 0 ? position : filtered.views[std::size_t(stage.view)].gbuffer.position;
    }
    const Image4& normal_of(const frame::PlannedStage& stage) const {
        return stage.view == 0 ? normal : filtered.views[std::size_t(stage.view)].gbuffer.normal;
    }
    const Buffer<float>& visibility_of(const frame::PlannedStage& stage) const {
        return stage.view == 0 ? visibility : filtered.views[std::size_t(stage.view)].visibility;
    }

    // A light's maps as the frame drew them, or as it would have.
    const std::vector<raster::Rsm>& maps_of(int light) {
        if (maps.empty()) maps.resize(lights.size());
        std::vector<raster::Rsm>& of_light = maps[std::size_t(light)];
        if (!of_light.empty()) return of_light;
        glm::vec3 low(0), high(0);
        bounds(geometry, low, high);
        const std::vector<View> views = raster::light_views(lights[std::size_t(light)], low, high);
        const std::vector<raster::Rsm> none;
        const std::size_t l = std::size_t(light);
        const std::vector<raster::Rsm>& drawn = l < frame.rsms.size() ? frame.rsms[l] : none;
        for (std::size_t m = 0; m < views.size(); ++m) {
            if (m < drawn.size() && drawn[m].size > 0)
                of_light.push_back(drawn[m]);
            else if (views.size() == 1 || raster::may_see(views[m], low, high))
                of_light.push_back(raster::unseen_rsm(lights[l], views[m]));
            else
                of_light.emplace_back().view = views[m];
        }
        return of_light;
    }

    // As the stage shadow.blur makes them, whatever the frame holds; none where maps are not blurred.
    const std::vector<Image4>& blurred_of(int light) {
        blurred.resize(lights.size());
        std::vector<Image4>& of_light = blurred[std::size_t(light)];
        if (direct::blurs_maps(settings.shadow) && of_light.empty())
            direct::blur_maps(settings.shadow, maps_of(light), {}, of_light);
        return of_light;
    }

    void append_map_blur(const frame::PlannedStage& stage) {
        const double range = direct::depth_range(maps_of(stage.light));
        each_map(stage.light, [&](const raster::Rsm& map, int face) {
            direct::LogBlurInputs in{&map.position, direct::Direction::horizontal, range};
            Image4 across;
            if (stage.form == "vertical") {
                direct::run(settings.shadow, in, {}, across);
                in = {&across, direct::Direction::vertical, range};
            }
            keep(direct::data_of(settings.shadow, in), stage.label, stage.light, face);
            // A face's name stays last.
            out.back().id.insert(stage.name.size(), "." + stage.form);
        });
    }

    void keep(StageData data, const std::string& label, int light = -1, int map = -1) {
        data.label = label;
        data.id = data.stage;
        if (light >= 0) data.id += "." + words[std::size_t(light)];
        if (map >= 0) {
            data.id += std::string(".") + raster::face_names[map];
            data.label += std::string(" ") + raster::face_names[map];
        }
        out.push_back(owned(find_binding(data.stage, data.label), data));  // what is lent here does not outlive the frame
    }
    // Of a stage of a view beside the frame.
    void name_view(const frame::PlannedStage& stage, std::size_t first) {
        for (std::size_t i = first; stage.view > 0 && i < out.size(); ++i)
            out[i].id += "." + word_of(filtered.views[std::size_t(stage.view)].name);
    }

    void append_image_space(const frame::PlannedStage& stage) {
        const isr::IsrParams& params = settings.isr;
        const isr::Pattern of_gather = isr::gather_pattern(params), of_ssao = isr::ssao_pattern(params);
        StageData data;
        if (stage.name == "isr.downsample") {
            data = isr::data_of(params, frame::downsample_inputs(scene, filtered, stage));
        } else if (stage.name == "isr.gather") {
            data = isr::data_of(params, frame::gather_inputs(scene, settings, filtered, stage, of_gather));
        } else if (stage.name == "isr.gather_camera") {
            data = isr::data_of(params, frame::camera_gather_inputs(scene, settings, filtered, stage, of_gather));
        } else if (stage.name == "isr.unseen") {
            data = isr::data_of(params, frame::unseen_inputs(scene, settings, filtered, stage));
        } else if (stage.name == "isr.ssao") {
            data = isr::data_of(params, frame::ssao_inputs(scene, settings, filtered, of_ssao));
        } else if (stage.name == "isr.bounce") {
            data = isr::data_of(params, frame::bounce_inputs(scene, settings, filtered, stage));
        } else if (stage.name == "isr.blur") {
            data = isr::data_of(params, frame::isr_blur_inputs(settings, filtered, stage));
        } else if (stage.name == "isr.upsample") {
            data = isr::data_of(params, frame::upsample_inputs(scene, settings, filtered));
        } else {
            data = isr::data_of(params, frame::compose_inputs(scene, filtered));
        }
        keep(std::move(data), stage.label);
        if (!stage.form.empty()) out.back().id += "." + word_of(stage.form);
    }

    void keep_filter(StageData data, const frame::PlannedStage& stage) {
        keep(std::move(data), stage.label);
        if (!stage.form.empty()) out.back().id += "." + stage.form;
    }

    // Calls one(map, face) for each map of the light that sees something; face is -1 where it is the only one.
    template <class One>
    void each_map(int light, One one) {
        const std::vector<raster::Rsm>& all = maps_of(light);
        for (std::size_t m = 0; m < all.size(); ++m)
            if (all[m].size > 0) one(all[m], all.size() > 1 ? int(m) : -1);
    }

    void append(const frame::PlannedStage& stage) {
        const std::size_t first = out.size();
        if (frame::is_isr(stage.name))
            append_image_space(stage);
        else
            append_other(stage);
        name_view(stage, first);
    }

    void append_other(const frame::PlannedStage& stage) {
        const int l = stage.light;
        if (stage.name == "gbuffer.layer") {
            const glm::ivec2 size = size_of(stage);
            const Image1& behind = *frame::peeled_depth(scene, settings, filtered, stage.view);
            keep(raster::gbuffer_layer_data(geometry, surfaces, view_of(stage), size,
                                            behind.empty() ? Image1(size.x, size.y) : behind),
                 stage.label);
        } else if (stage.name == "gbuffer") {
            keep(raster::gbuffer_data(geometry, surfaces, view_of(stage), size_of(stage)), stage.label);
        } else if (stage.name == "rsm") {
            each_map(l, [&](const raster::Rsm& map, int face) {
                keep(raster::rsm_data(geometry, surfaces, lights[std::size_t(l)], map.view), stage.label, l, face);
            });
        } else if (stage.name == "shadow.blur") {
            append_map_blur(stage);
        } else if (stage.name == "shadow") {
            const direct::ShadowInputs in{&position_of(stage), &normal_of(stage), maps_of(l), nullptr, blurred_of(l)};
            each_map(l, [&](const raster::Rsm&, int face) {
                keep(direct::data_of(settings.shadow, in, std::max(face, 0)), stage.label, l, face);
            });
        } else if (stage.name == "direct") {
            const direct::DirectInputs in{&position_of(stage), &normal_of(stage), &lights, &visibility_of(stage), nullptr,
                                          compose::reads_density(settings.compose)};
            keep(direct::data_of(settings.direct, in), stage.label);
        } else if (frame::is_gather(stage.name) && stage.name != "rsm.all_rays") {
            const rsm::Pattern pattern =
                rsm::pattern_of(settings.rsm, lights[std::size_t(l)].rsm_size, settings.seed);
            each_map(l, [&](const raster::Rsm& map, int face) {
                const bool half = frame::halves_indirect(settings);
                const rsm::GatherInputs in{half ? &filtered.half_position : &position,
                                           half ? &filtered.half_normal : &normal, &map, &pattern, settings.seed};
                keep(rsm::data_of(settings.rsm, in), stage.label, l, face);
            });
        } else if (stage.name == "filter.reduce") {
            keep_filter(filter::data_of(settings.indirect, filter::ReduceInputs{&frame::reduce_input(filtered, stage)}), stage);
        } else if (stage.name == "filter.upsample") {
            keep_filter(filter::data_of(settings.indirect, frame::upsample_inputs(filtered)), stage);
        } else if (stage.name == "filter.blur") {
            keep_filter(filter::data_of(settings.indirect, frame::blur_inputs(settings, filtered, stage)), stage);
        } else if (stage.name == "compose") {
            const compose::ComposeInputs in{&normal, &albedo, &emission, &direct, &indirect, scene.environment.radiance};
            keep(compose::data_of(settings.compose, in), stage.label);
        } else if (stage.name == "tonemap") {
            keep(compose::data_of(settings.tonemap, compose::TonemapInputs{&radiance}), stage.label);
        }
    }
};

}  // namespace

std::vector<StageData> frame_data(const Scene& scene, const frame::Settings& settings, const frame::Plan& plan,
                                  const frame::Frame& frame) {
    Builder builder(scene, settings, frame);
    for (const frame::PlannedStage& stage : plan.stages)
        if (stage.needed) builder.append(stage);
    return std::move(builder.out);
}

}  // namespace plumb::parity
