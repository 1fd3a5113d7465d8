// Presets: what a document rendered with, whole.
#include <catch2/catch.hpp>
#include <set>

#include "core/error.h"
#include "gi/frame/presets.h"
#include "gi/frame/settings.h"

using namespace plumb;
using namespace plumb::frame;

namespace {

// As the tools apply it: [render], then table by table.
Settings applied(const Preset& preset) {
    Settings settings;
    for (const Setting& s : preset.settings) {
        const std::string place = preset.name + ": " + s.table + "." + s.key;
        CAPTURE(place);
        if (s.table == "render") {
            const std::string& word = std::get<std::string>(s.value);
            if (s.key == "method") settings.method = parse_method(word, place);
            if (s.key == "layout") settings.layout = parse_layout(word, place);
            continue;
        }
        std::vector<Field> fields = table_fields(settings, s.table, place);
        set_field(find_field(fields, s.key, place), s.value, place);
    }
    return settings;
}

}  // namespace

TEST_CASE("presets: every setting is known, within its range, and stands once but where printed", "[frame][preset]") {
    for (const Preset& preset : presets()) {
        CAPTURE(preset.name);
        CHECK(find_preset(preset.name, "here").settings.size() == preset.settings.size());
        REQUIRE(preset.settings.size() > 20);
        CHECK(preset.settings[0].key == "method");
        CHECK(preset.settings[1].key == "layout");
        const Settings s = applied(preset);
        rsm::GatherParams rsm = s.rsm;
        isr::IsrParams isr = s.isr;
        direct::ShadowParams shadow = s.shadow;
        CHECK_NOTHROW(validate_fields("rsm", rsm::fields(rsm)));
        CHECK_NOTHROW(isr::validate(isr));
        CHECK_NOTHROW(validate_fields("shadow", direct::fields(shadow)));
        std::set<std::string> keys;
        std::size_t again = 0;
        for (const Setting& setting : preset.settings) again += !keys.insert(setting.table + "." + setting.key).second;
        CHECK(again == (preset.name == "vrsm_printed" ? 3u : preset.name == "isr_printed" ? 4u : 0u));
    }
    CHECK_THROWS_WITH(find_preset("vrms", "--preset vrms"), "--preset vrms: unknown preset; the nearest known one is 'vrsm'");
}

TEST_CASE("presets: VRSM's numbers, and ISR's", "[frame][preset][VRSM 4][ISR 5.3.1]") {
    const Settings vrsm = applied(find_preset("vrsm", "")), printed = applied(find_preset("vrsm_printed", ""));
    CHECK(vrsm.method == Method::rsm);
    CHECK(vrsm.layout.name == "vrsm");
    CHECK((vrsm.rsm.directions == 15 && vrsm.rsm.steps == 10 && vrsm.rsm.slots == 5 && vrsm.indirect.kernel == 17));
    CHECK(vrsm.rsm.gather == rsm::Gather::paths);
    CHECK((vrsm.rsm.variant == rsm::Variant::corrected && printed.rsm.variant == rsm::Variant::published));
    CHECK(printed.rsm.slots == 5);
    const Settings isr = applied(find_preset("isr", "")), as_printed = applied(find_preset("isr_printed", ""));
    CHECK(isr::sample_count(isr.isr.rings) == 80);
    CHECK((isr.isr.k_ssao == 0 && as_printed.isr.k_ssao == 0.5f && as_printed.isr.k_isr == 0.5f));
    CHECK(as_printed.isr.variant == isr::Variant::published);
    CHECK(as_printed.shadow.mode == direct::ShadowMode::esm);
}
