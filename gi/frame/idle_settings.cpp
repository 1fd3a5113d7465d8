#include "gi/frame/idle_settings.h"

#include <algorithm>
#include <vector>

#include "gi/frame/isr.h"
#include "gi/frame/mirrors.h"

namespace plumb::frame {

namespace {

using direct::VisibilityFilter;
using screen::AoMethod;
using screen::AoViews;
using screen::Lobe;
using screen::March;

// What is idle where `holds`: those keys of the table, or all of it but `but`.
struct Idle {
    std::string table;
    std::vector<std::string> keys;  // empty: all
    std::string but;
    bool (*holds)(const Settings&, const Scene&);
    std::string reason;
};

const std::vector<Idle>& idles() {
    static const auto is = [](const Settings& s, AoMethod of) { return s.ao.method == of; };
    static const std::vector<Idle> all = {
        {"ao", {}, "", [](const Settings& s, const Scene&) { return s.method == Method::reference; }, "paths are traced instead"},
        {"ao", {}, "method", [](const Settings& s, const Scene&) { return is(s, AoMethod::off); }, "ao.method is off"},
        {"ao", {"samples", "variant", "views", "weight_bias"}, "", [](const Settings& s, const Scene&) { return is(s, AoMethod::horizon); }, "ao.method is horizon"},
        {"ao", {"slices", "steps"}, "", [](const Settings& s, const Scene&) { return is(s, AoMethod::ssao); }, "ao.method is ssao"},
        {"ao", {"weight_bias"}, "", [](const Settings& s, const Scene&) { return s.ao.views == AoViews::camera; }, "ao.views is camera"},
        {"ao", {"views"}, "", [](const Settings& s, const Scene&) { return !casts_shadows(s); }, "no light has a map: nothing casts shadows"},
        {"reflect", {}, "", [](const Settings& s, const Scene&) { return s.method == Method::reference; }, "paths are traced instead"},
        {"reflect", {}, "march", [](const Settings& s, const Scene&) { return s.reflect.march == March::off; }, "reflect.march is off"},
        {"reflect", {}, "lobe", [](const Settings& s, const Scene& scene) { return !any_mirror(scene) && (s.reflect.lobe == Lobe::off || !any_lobe(scene)); }, "nothing mirrors"},
        {"reflect", {"lobe", "rays"}, "", [](const Settings&, const Scene& scene) { return !any_lobe(scene); }, "no material has a lobe"},
        {"reflect", {"views"}, "", [](const Settings& s, const Scene&) { return !casts_shadows(s); }, "no light has a map: nothing casts shadows"},
        {"reflect", {"bias"}, "", [](const Settings& s, const Scene&) { return s.reflect.variant == screen::ReflectVariant::published; }, "reflect.variant is published"},
        {"reflect", {"rays"}, "", [](const Settings& s, const Scene&) { return s.reflect.lobe == Lobe::off; }, "reflect.lobe is off"},
        {"reflect", {"bisections"}, "", [](const Settings& s, const Scene&) { return s.reflect.march == March::hierarchical; }, "reflect.march is hierarchical"},
        {"reflect", {"cells"}, "", [](const Settings& s, const Scene&) { return s.reflect.march == March::steps; }, "reflect.march is steps"},
        {"reuse", {}, "", [](const Settings& s, const Scene&) { return s.method != Method::rsm; }, ""},
        {"reuse", {}, "frames", [](const Settings& s, const Scene&) { return s.reuse.frames == 0; }, "reuse.frames is 0"},
        {"shadow", {"filter", "filter_radius", "filter_sigma", "filter_sigma_depth", "filter_sigma_normal"}, "",
         [](const Settings& s, const Scene&) { return !casts_shadows(s); }, "nothing casts shadows"},
        {"shadow", {"filter_radius", "filter_sigma", "filter_sigma_depth", "filter_sigma_normal"}, "",
         [](const Settings& s, const Scene&) { return !filters_shadows(s); }, "shadow.filter is none"},
        {"shadow", {"filter_sigma_depth", "filter_sigma_normal"}, "",
         [](const Settings& s, const Scene&) { return s.shadow.filter == VisibilityFilter::gaussian; }, "shadow.filter is gaussian"},
        {"rsm", {}, "", [](const Settings& s, const Scene&) { return s.method != Method::rsm; }, ""},
        {"indirect", {}, "", [](const Settings& s, const Scene&) { return s.method != Method::rsm; }, ""},
        {"isr", {}, "", [](const Settings& s, const Scene&) { return s.method != Method::isr; }, ""},
        {"isr", {"solid_angle", "ssao_term", "light_unit", "length_unit"}, "", [](const Settings& s, const Scene&) { return s.isr.variant == isr::Variant::corrected; }, "isr.variant is corrected"},
        {"probes", {}, "", [](const Settings& s, const Scene&) { return s.method != Method::probes; }, ""},
        {"lod", {}, "", [](const Settings& s, const Scene&) { return s.method != Method::probes; }, ""},
        {"radiosity", {}, "", [](const Settings& s, const Scene&) { return s.method != Method::radiosity; }, ""},
        {"zbuffer", {}, "", [](const Settings& s, const Scene&) { return s.method != Method::zbuffer; }, ""},
        {"reference", {}, "", [](const Settings& s, const Scene&) { return s.method != Method::reference && !s.truth; }, "no path is traced: neither method reference nor --truth"},
    };
    return all;
}

}  // namespace

std::string idle(const Settings& settings, const Scene& scene, const std::string& table, const std::string& key) {
    for (const Idle& of : idles()) {
        const bool speaks = of.table == table && key != of.but && (of.keys.empty() || std::count(of.keys.begin(), of.keys.end(), key) > 0);
        if (speaks && of.holds(settings, scene)) return of.reason.empty() ? "the method is " + method_name(settings.method) : of.reason;
    }
    return "";
}

}  // namespace plumb::frame
