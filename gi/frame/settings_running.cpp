#include <algorithm>

#include "gi/frame/frame_graph.h"

namespace plumb::frame {

namespace {

using Change = std::function<void(Settings&)>;

// What brings into a frame the stages that not every frame has, the nearest first.
std::vector<Change> changes() {
    std::vector<Change> all = {[](Settings& s) { s.method = Method::rsm; }};
    for (const rsm::GatherStage& gather : rsm::gather_stages)
        all.push_back([=](Settings& s) {
            s.method = Method::rsm, s.rsm.gather = gather.gather, s.rsm.texels = gather.texels;
        });
    all.push_back([](Settings& s) { s.method = Method::rsm, s.indirect.resolution = filter::Resolution::half; });
    for (const filter::Blur blur : {filter::Blur::full, filter::Blur::separable})
        all.push_back([=](Settings& s) { s.method = Method::rsm, s.indirect.blur = blur; });
    all.push_back([](Settings& s) { s.method = Method::rsm, s.reuse.frames = std::max(s.reuse.frames, 4); });
    const Change isr = [](Settings& s) { s.method = Method::isr; };
    const Change shows_indirect = [=](Settings& s) {
        isr(s);
        if (!gathers_isr(s)) s.isr.mode = isr::Mode::f2;
    };
    all.insert(all.end(), {isr, shows_indirect});
    all.push_back([=](Settings& s) { shows_indirect(s), s.isr.layers = std::max(s.isr.layers, 2); });
    all.push_back([=](Settings& s) { shows_indirect(s), s.isr.cameras = std::max(s.isr.cameras, 1); });
    all.push_back([=](Settings& s) { shows_indirect(s), s.isr.bounces = std::max(s.isr.bounces, 2); });
    all.push_back([=](Settings& s) { shows_indirect(s), s.isr.blur = isr::Blur::gaussian; });
    all.push_back([](Settings& s) { s.method = Method::rsm, s.shadow.mode = direct::ShadowMode::esm; });
    all.push_back([](Settings& s) {
        if (s.method == Method::reference || !casts_shadows(s)) s.method = Method::rsm;
        s.shadow.filter = direct::VisibilityFilter::gaussian;
    });
    for (const screen::AoMethod method : {screen::AoMethod::ssao, screen::AoMethod::horizon})
        all.push_back([=](Settings& s) {
            if (s.method == Method::reference) s.method = Method::rsm;
            s.ao.method = method;
        });
    for (const screen::March march : {screen::March::steps, screen::March::hierarchical})
        all.push_back([=](Settings& s) {
            if (s.method == Method::reference) s.method = Method::rsm;
            s.reflect.march = march;
        });
    all.push_back([](Settings& s) {
        if (s.method == Method::reference) s.method = Method::rsm;
        if (s.reflect.march == screen::March::off) s.reflect.march = screen::March::steps;
        s.reflect.lobe = screen::Lobe::phong, s.reflect.variant = screen::ReflectVariant::corrected;
    });
    all.push_back([](Settings& s) { s.method = Method::probes; });
    all.push_back([](Settings& s) { s.method = Method::probes, s.lod.levels = std::max(s.lod.levels, 2); });
    all.push_back([](Settings& s) { s.method = Method::radiosity; });
    for (const probes::IndirectShadow shadow : {probes::IndirectShadow::spheres, probes::IndirectShadow::rays})
        all.push_back([=](Settings& s) { s.method = Method::probes, s.probe_run.indirect_shadow = shadow; });
    for (const zbuffer::Technique technique : {zbuffer::Technique::cads_p, zbuffer::Technique::cads})
        all.push_back([=](Settings& s) { s.method = Method::zbuffer, s.zbuffer.technique = technique; });
    return all;
}

bool runs(const Settings& settings, const std::string& stage, const std::string& form) {
    Scene scene;
    scene.lights.resize(1);
    const FrameGraph graph(scene, settings, Geometry{});
    return std::any_of(graph.nodes().begin(), graph.nodes().end(), [&](const PlannedNode& node) {
        return node.listed && node.plan.name == stage && (form.empty() || has_form(node.plan, form));
    });
}

}  // namespace

bool has_form(const PlannedStage& stage, const std::string& form) {
    return (stage.form == form && stage.view == 0) || stage.label == stage.name + " (" + form + ")";
}

Settings settings_running(const Settings& settings, const std::string& stage, const std::string& form) {
    // Of the method reference hardly any stage is needed.
    if (settings.method != Method::reference && runs(settings, stage, form)) return settings;
    for (const Change& change : changes()) {
        Settings other = settings;
        change(other);
        if (runs(other, stage, form)) return other;
    }
    return settings;
}

}  // namespace plumb::frame
