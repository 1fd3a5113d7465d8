// What a frame is rendered with: the parameters of every stage, by the names of scene files and `plumb stages`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/scene.h"
#include "gi/compose/compose_params.h"
#include "gi/direct/direct_params.h"
#include "gi/filter/filter_params.h"
#include "gi/isr/isr_params.h"
#include "gi/probes/bake_params.h"
#include "gi/probes/lod.h"
#include "gi/probes/run_params.h"
#include "gi/radiosity/radiosity_params.h"
#include "gi/reference/reference.h"
#include "gi/rsm/gather.h"
#include "gi/screen/ao_params.h"
#include "gi/screen/reflect_params.h"
#include "gi/screen/reuse_params.h"
#include "gi/zbuffer/zbuffer_params.h"
#include "raster/layout.h"

namespace plumb::probes {
struct Bake;
}

namespace plumb::frame {

// reference: the picture itself is path traced.
enum class Method : int { direct, rsm, isr, probes, radiosity, zbuffer, reference };

// What everything that goes through all methods knows of one: its parameters are those of the table of its name.
struct MethodInfo {
    Method method;
    std::string name;                    // in scene files: [render] method
    std::vector<std::string> transport;  // the traced layers (truth.h) of irradiance that add up to what it means to
                                         // compute; empty: full global illumination
};
// As the enumeration counts them.
const std::vector<MethodInfo>& methods();

struct Settings {
    Method method = Method::rsm;
    raster::Layout layout = raster::Layout::fp32;
    rsm::GatherParams rsm;
    zbuffer::ZbufferParams zbuffer;
    isr::IsrParams isr;
    filter::FilterParams indirect;    // of the method rsm
    screen::AoParams ao;
    screen::ReuseParams reuse;        // of the method rsm
    screen::ReflectParams reflect;
    direct::ShadowParams shadow;
    direct::DirectParams direct;
    compose::ComposeParams compose;
    compose::TonemapParams tonemap;
    reference::PathParams reference;  // of the method reference and of the truth
    probes::BakeParams probes;        // of `plumb bake`, and of the method probes where it has no bake
    probes::RunParams probe_run;      // of the method probes
    probes::LodParams lod;            // of the method probes
    radiosity::RadiosityParams radiosity;  // of the method radiosity
    std::shared_ptr<const probes::Bake> bake;  // that the method probes reads; planning needs none
    std::uint32_t seed = 1;
    bool truth = false;   // also trace what the method approximates
    bool pruning = true;  // false: every stage runs, needed or not; the picture is the same
};

// The tables of a scene file that hold parameters: "rsm", "isr", "indirect", "reuse", "ao", "reflect", "shadow", "direct", "compose", "tonemap", "reference",
// "probes", "lod", "radiosity", "zbuffer", "layout" (of a custom layout).
std::vector<std::string> method_tables();

// The parameters of one table; throws InputError at `place` for a table that does not exist.
std::vector<Field> table_fields(Settings& settings, const std::string& table, const std::string& place);

// [render] method, layout; throws InputError at `place`.
Method parse_method(const std::string& name, const std::string& place);
std::string method_name(Method method);
raster::Layout parse_layout(const std::string& name, const std::string& place);

// Whether the picture depends on the shadow density (gi/direct), and not on light alone.
bool reads_density(const Settings& settings);

// Whether gathered light is joined with that of frames before (nodes_reuse.cpp).
bool reuses_light(const Settings& settings);

// Whether ambient occlusion darkens indirect light (nodes_ao.cpp).
bool occludes(const Settings& settings);
// Whether mirrors show what the views see (nodes_reflect.cpp).
bool reflects(const Settings& settings);

// Defaults, then what the scene file sets, in its order.
Settings settings_of(const Scene& scene);

}  // namespace plumb::frame
