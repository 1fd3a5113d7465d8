#include "gi/frame/settings.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/nearest_known.h"

namespace plumb::frame {

namespace {

// One word out of a list, as an enumeration counts it.
template <class E>
E parse_choice(const char* key, const std::vector<std::string>& choices, const std::string& name,
               const std::string& place) {
    E value{};
    Field field{key, as_int(value), "", "", 0, 0, choices};
    set_field(field, name, place);
    return value;
}

}  // namespace

const std::vector<MethodInfo>& methods() {
    static const std::vector<MethodInfo> all = {
        {Method::direct, "direct", {"truth.direct"}},
        {Method::rsm, "rsm", {"truth.direct", "truth.indirect"}},
        {Method::isr, "isr", {"truth.direct", "truth.indirect"}},
        {Method::probes, "probes", {}},
        {Method::radiosity, "radiosity", {}},
        {Method::zbuffer, "zbuffer", {"truth.direct"}},
        {Method::reference, "reference", {}},
    };
    return all;
}

std::vector<std::string> method_tables() {
    return {"rsm", "isr", "indirect", "reuse", "ao", "reflect", "shadow", "direct", "compose", "tonemap", "reference", "probes", "lod", "radiosity", "zbuffer", "layout"};
}

std::vector<Field> table_fields(Settings& s, const std::string& table, const std::string& place) {
    if (table == "rsm") return rsm::fields(s.rsm);
    if (table == "isr") return isr::fields(s.isr);
    if (table == "indirect") return filter::fields(s.indirect);
    if (table == "reuse") return screen::fields(s.reuse);
    if (table == "ao") return screen::fields(s.ao);
    if (table == "reflect") return screen::fields(s.reflect);
    if (table == "shadow") return direct::fields(s.shadow);
    if (table == "direct") return direct::fields(s.direct);
    if (table == "compose") return compose::fields(s.compose);
    if (table == "tonemap") return compose::fields(s.tonemap);
    if (table == "reference") return reference::fields(s.reference);
    if (table == "probes") {
        std::vector<Field> all = probes::fields(s.probes);
        for (Field& field : probes::fields(s.probe_run)) all.push_back(field);
        return all;
    }
    if (table == "lod") return probes::fields(s.lod);
    if (table == "radiosity") return radiosity::fields(s.radiosity);
    if (table == "zbuffer") return zbuffer::fields(s.zbuffer);
    if (table == "layout") return raster::fields(s.layout);
    throw InputError(fmt::format("{}: unknown table [{}]{}", place, table, nearest_known(table, method_tables(), "[]")));
}

Method parse_method(const std::string& name, const std::string& place) {
    std::vector<std::string> names;
    for (const MethodInfo& info : methods()) names.push_back(info.name);
    return parse_choice<Method>("method", names, name, place);
}

std::string method_name(Method method) { return methods().at(std::size_t(method)).name; }

raster::Layout parse_layout(const std::string& name, const std::string& place) {
    return raster::parse_layout(name, place);
}

bool reads_density(const Settings& s) {
    return s.direct.variant == direct::DirectVariant::published || compose::reads_density(s.compose);
}

Settings settings_of(const Scene& scene) {
    Settings s;
    s.seed = scene.seed;
    s.method = parse_method(scene.method, scene.name + ": [render]");
    s.layout = parse_layout(scene.layout, scene.name + ": [render]");
    for (const Setting& setting : scene.settings) {
        std::vector<Field> fields = table_fields(s, setting.table, setting.place);
        set_field(find_field(fields, setting.key, setting.place), setting.value, setting.place);
        if (setting.table == "rsm" && setting.key == "pattern") s.rsm.own = setting.rows;
        if (setting.table == "layout" && s.layout.name != "custom") raster::validate(s.layout, setting.place);
    }
    raster::validate(s.layout, scene.name);
    return s;
}

}  // namespace plumb::frame
