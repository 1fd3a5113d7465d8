// What is said of a default beside its alternatives.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "tools/experiments/defaults.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

DefaultsRow row(const std::string& setting, double ms, double error, double spread = 0) {
    DefaultsRow r;
    r.scene = "s", r.group = "g", r.choice = setting == "default" ? "" : "c", r.setting = setting, r.size = {8, 8};
    r.ms = ms, r.error = error, r.spread = spread;
    return r;
}

using Is = DefaultVerdict::Is;
Is verdict(const std::vector<DefaultsRow>& rows) {
    const std::vector<DefaultVerdict> all = judge_defaults(rows);
    REQUIRE(all.size() == 1);
    return all[0].is;
}

}  // namespace

TEST_CASE("defaults: off the front is what errs more than a tenth above something as fast", "[tools][defaults]") {
    CHECK(verdict({row("default", 10, 1), row("a", 10, 1.2), row("b", 20, 0.1)}) == Is::on_front);
    CHECK(verdict({row("default", 10, 1), row("a", 10.19, 0.95)}) == Is::near_front);
    CHECK(verdict({row("default", 10, 1), row("a", 10.19, 0.9)}) == Is::off);
    CHECK(verdict({row("default", 10, 1), row("a", 10.21, 0.5)}) == Is::on_front);  // takes longer
    CHECK(verdict({row("default", 10, 1), row("a", 5, 0.95), row("b", 5, 0.8)}) == Is::off);
    // Two standard errors of the difference: hypot(0.06, 0.08) = 0.1.
    CHECK(verdict({row("default", 10, 1, 0.06), row("a", 5, 0.8001, 0.08)}) == Is::not_told_apart);
    CHECK(verdict({row("default", 10, 1, 0.06), row("a", 5, 0.7999, 0.08)}) == Is::off);
    // No number is never good.
    CHECK(verdict({row("default", 10, NAN), row("a", 20, 0.5)}) == Is::off);
    CHECK(verdict({row("default", 10, 1), row("a", 5, NAN)}) == Is::on_front);
    DefaultsRow refused = row("a", 0, 0);
    refused.refused = true;
    CHECK(verdict({row("default", 10, 1), refused}) == Is::on_front);
}

TEST_CASE("defaults: each choice is judged against its own group's default", "[tools][defaults]") {
    std::vector<DefaultsRow> rows = {row("default", 10, 1), row("a", 5, 0.5), row("b", 5, 0.4), row("default", 10, 0.3), row("a", 5, 0.5)};
    rows[2].choice = "d";
    rows[3].group = rows[4].group = "h";
    const std::vector<DefaultVerdict> all = judge_defaults(rows);
    REQUIRE(all.size() == 3);
    CHECK((all[0].is == Is::off && all[0].best->setting == "a" && all[0].choice == "c"));
    CHECK((all[1].is == Is::off && all[1].best->setting == "b" && all[1].choice == "d"));
    CHECK((all[2].is == Is::on_front && all[2].own->group == "h"));
}

TEST_CASE("defaults: every alternative is a setting that is known, and every choice has the default among others", "[tools][defaults]") {
    std::set<std::string> names;
    for (const ChoiceGroup& group : default_choices()) {
        CAPTURE(group.name);
        CHECK(names.insert(group.name).second);
        REQUIRE(!group.choices.empty());
        for (const DefaultChoice& choice : group.choices) {
            CAPTURE(choice.name);
            CHECK(choice.others.size() >= 2);
            for (const Alternative& other : choice.others) {
                SceneOptions words;
                words.method = group.method, words.sets = group.sets;
                words.sets.insert(words.sets.end(), other.sets.begin(), other.sets.end());
                CHECK_NOTHROW(settings_of(Scene(), words));
            }
        }
    }
}
