// The generator of generic mutants, on a shader of its own: which sites it finds, that each mutant is valid, and that all
// of it is the same in every run.
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "core/error.h"
#include "tools/mutants/generic.h"
#include "tools/mutants/survivors.h"
#include "tools/vulkan/shader.h"

namespace {

using namespace plumb;
using namespace plumb::mutants;

std::vector<std::uint32_t> kinds_spirv() { return vulkan::load_spirv(PLUMB_MUTANT_KINDS); }

std::unique_ptr<const TwinShader> kinds_of(const StageBinding& stage) {
    return read_shader(stage, "kinds.comp", kinds_spirv(), PLUMB_SOURCE_DIR);
}

using Counts = std::map<Change, int>;

Counts counts_of(const TwinShader& shader, const std::string& function) {
    Counts counts;
    for (const Site& site : shader.sites)
        if (site.place.function == function) ++counts[site.change];
    return counts;
}

// What spirv-val says of it: empty if it is valid.
std::string complaint(const std::vector<std::uint32_t>& words, const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / "mutant.spv", log = folder / "log";
    std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(words.data()), std::streamsize(4 * words.size()));
    const std::string command =
        std::string(PLUMB_SPIRV_VAL) + " --target-env vulkan1.1 " + file.string() + " > " + log.string() + " 2>&1";
    if (std::system(command.c_str()) == 0) return "";
    std::ifstream in(log);
    std::string line;
    std::getline(in, line);
    return "invalid: " + line;
}

TEST_CASE("generic mutants: every change has its sites", "[mutants]") {
    const StageBinding stage;
    const auto shader = kinds_of(stage);
    using C = Change;
    const std::map<std::string, Counts> expected{
        {"sum_of", {{C::plus_minus, 1}, {C::term_dropped, 2}}},
        {"difference_of", {{C::plus_minus, 1}, {C::term_dropped, 2}}},
        {"product_of", {{C::times_divide, 1}, {C::factor_dropped, 2}}},
        {"square_of", {{C::times_divide, 1}, {C::factor_dropped, 1}}},  // a a as a, whichever goes
        {"quotient_of", {{C::times_divide, 1}, {C::factor_dropped, 1}}},
        {"unit_of", {{C::times_divide, 1}, {C::normalize_dropped, 1}, {C::function_dropped, 1}}},
        {"larger_of", {{C::min_max, 1}}},
        {"saturated", {{C::min_max, 2}, {C::limit_dropped, 2}, {C::saturate_dropped, 1}, {C::constant_scaled, 1}}},
        {"not_negative", {{C::min_max, 1}, {C::limit_dropped, 1}}},
        {"size_of", {{C::function_dropped, 1}}},
        {"doubled", {{C::times_divide, 1}, {C::factor_dropped, 2}, {C::constant_scaled, 1}}},
        {"next_of", {{C::plus_minus, 1}, {C::term_dropped, 2}, {C::constant_plus_one, 1}}},
        {"is_less", {{C::comparison_turned, 1}, {C::boundary_moved, 1}}},
        {"is_smaller", {{C::comparison_turned, 1}}},  // of two floats either way is legal at a tie
        {"is_positive", {{C::comparison_turned, 1}, {C::boundary_moved, 1}}},
        {"is_same", {{C::comparison_turned, 1}}},
        {"are_both", {{C::condition_dropped, 2}}},
        {"turned", {{C::components_swapped, 1}}},
        {"second_of", {{C::components_swapped, 1}}},
        {"element", {{C::neighbour_read, 1}, {C::input_dropped, 1}, {C::input_scaled, 1}}},
        {"texel_at", {{C::neighbour_read, 2}, {C::input_dropped, 1}, {C::input_scaled, 1}}},
        {"gain_of", {{C::input_dropped, 1}, {C::input_scaled, 1}}},
        {"summed", {{C::comparison_turned, 1}, {C::loop_bound, 2}, {C::plus_minus, 1}, {C::term_dropped, 2},
                    {C::constant_plus_one, 1}, {C::input_dropped, 1}, {C::input_scaled, 1}}},
        {"either", {{C::components_swapped, 1}, {C::comparison_turned, 3}, {C::boundary_moved, 1}, {C::condition_dropped, 2}}},
    };
    for (const auto& [function, counts] : expected) {
        INFO(function);
        const Counts found = counts_of(*shader, function);
        for (int c = 0; c < changes; ++c) {
            INFO(change_name(Change(c)));
            CHECK((found.count(Change(c)) ? found.at(Change(c)) : 0) == (counts.count(Change(c)) ? counts.at(Change(c)) : 0));
        }
    }
    std::set<Change> met;
    for (const Site& site : shader->sites) met.insert(site.change);
    CHECK(met.size() == std::size_t(changes));
}

TEST_CASE("generic mutants: a site knows its function, line and text", "[mutants]") {
    const StageBinding stage;
    const auto shader = kinds_of(stage);
    int found = 0;
    for (const Site& site : shader->sites) {
        if (site.place.function != "unit_of" || site.change != Change::normalize_dropped) continue;
        ++found;
        CHECK(site.place.file == "tests/parity/mutants/generic/kinds.comp");
        CHECK(site.place.line == 15);
        CHECK(site.place.text == "float unit_of(float a, float b) { return a / sqrt(b); }");
    }
    CHECK(found == 1);
}

// Expected: spirv-val takes each mutant, guarded as it runs, and both marks of it; none is the original.
TEST_CASE("generic mutants: every mutant is valid", "[mutants]") {
    const StageBinding stage;
    const auto shader = kinds_of(stage);
    const std::filesystem::path folder = std::filesystem::path(PLUMB_BINARY_DIR) / "test_generic_mutants";
    std::filesystem::create_directories(folder);
    const std::vector<std::uint32_t> original = words_of(shader->module);
    REQUIRE(complaint(original, folder) == "");
    CHECK(complaint(words_of(guarded(shader->module, 64)), folder) == "");
    for (const Site& site : shader->sites) {
        INFO(site.place.function << " " << change_name(site.change) << " " << site.part);
        const SpirvModule mutant = changed(shader->module, *shader->index, site);
        CHECK(words_of(mutant) != original);
        CHECK(complaint(words_of(guarded(mutant, 64)), folder) == "");
        for (const Mark mark : {Mark::reached, Mark::differed})
            CHECK(complaint(words_of(guarded(marked(shader->module, *shader->index, site, mark), 64)), folder) == "");
    }
    // Such a check that cannot fail would show nothing: a sum without an operand.
    std::vector<std::uint32_t> broken = original;
    broken.pop_back();
    CHECK(complaint(broken, folder) != "");
}

// The one instruction that a change turns into another, and which.
TEST_CASE("generic mutants: changes are what they are called", "[mutants]") {
    const StageBinding stage;
    const auto shader = kinds_of(stage);
    const auto opcode_of = [&](const std::string& function, Change change, std::uint32_t part) {
        for (const Site& site : shader->sites)
            if (site.place.function == function && site.change == change && site.part == part) {
                const SpirvModule m = changed(shader->module, *shader->index, site);
                const std::uint32_t id = shader->module.code[site.at].words[1];
                for (const Instruction& i : m.code)
                    if (has_result(i.opcode) && i.words[1] == id) return i.opcode;
            }
        return 0u;
    };
    CHECK(opcode_of("sum_of", Change::plus_minus, 0) == op_f_sub);
    CHECK(opcode_of("difference_of", Change::plus_minus, 0) == op_f_add);
    CHECK(opcode_of("difference_of", Change::term_dropped, 0) == op_f_negate);  // a - b without a
    CHECK(opcode_of("difference_of", Change::term_dropped, 1) == op_copy_object);
    CHECK(opcode_of("product_of", Change::times_divide, 0) == op_f_div);
    CHECK(opcode_of("is_less", Change::comparison_turned, 0) == op_s_greater_equal);
    CHECK(opcode_of("is_less", Change::boundary_moved, 0) == op_s_less_equal);
    CHECK(opcode_of("element", Change::input_dropped, 0) == op_copy_object);
    CHECK(opcode_of("element", Change::input_scaled, 0) == op_f_mul);
}

TEST_CASE("generic mutants: what two twins include is mutated once, with both", "[mutants]") {
    StageBinding first, second;
    first.info.name = "first", second.info.name = "second";
    std::vector<std::unique_ptr<const TwinShader>> shaders;
    shaders.push_back(kinds_of(first)), shaders.push_back(kinds_of(second));
    const std::size_t sites = shaders[0]->sites.size();
    const GenericMutants all = share(std::move(shaders));
    REQUIRE(all.mutants.size() == sites);
    for (const GenericMutant& m : all.mutants) {
        REQUIRE(m.homes.size() == 2);
        CHECK(all.stage(m) == "first");
        CHECK(m.homes[0].site == m.homes[1].site);
    }
}

TEST_CASE("generic mutants: a sample is its seed's, and the same in every run", "[mutants]") {
    StageBinding stage;
    stage.info.name = "kinds";
    const auto keys = [&](std::uint64_t seed) {
        std::vector<std::unique_ptr<const TwinShader>> shaders;
        shaders.push_back(kinds_of(stage));
        const GenericMutants all = share(std::move(shaders));
        std::vector<std::uint64_t> out;
        for (const GenericMutant& m : sample(all, 10, seed)) out.push_back(m.key);
        return out;
    };
    CHECK(keys(1).size() == 10);
    CHECK(keys(1) == keys(1));
    CHECK(keys(1) != keys(2));

    // No two mutants have one key, or a sample could not tell them apart.
    std::vector<std::unique_ptr<const TwinShader>> shaders;
    shaders.push_back(kinds_of(stage));
    const GenericMutants all = share(std::move(shaders));
    std::set<std::uint64_t> met;
    for (const GenericMutant& m : all.mutants) met.insert(m.key);
    CHECK(met.size() == all.mutants.size());
}

TEST_CASE("generic mutants: the list of survivors is keyed by function and text", "[mutants]") {
    const std::string path = std::string(PLUMB_BINARY_DIR) + "/survivors.toml";
    const auto read = [&](const std::string& text) {
        std::ofstream(path) << text;
        return read_survivors(path);
    };
    const std::string entry = "[[survivor]]\nfile = \"a.comp\"\nfunction = \"f\"\ntext = \"x + y\"\n"
                              "change = \"plus_minus term_dropped\"\nsort = \"equivalent\"\nreason = \"y is 0\"\n";
    const std::vector<Survivor> list = read(entry);
    REQUIRE(list.size() == 1);
    Site site{Change::term_dropped, 12, 1, {"f", "a.comp", 99, "x + y"}};
    CHECK(list[0].matches(site));
    site.place.line = 1;
    CHECK(list[0].matches(site));
    site.place.text = "x - y";
    CHECK_FALSE(list[0].matches(site));
    site.place.text = "x + y", site.change = Change::factor_dropped;
    CHECK_FALSE(list[0].matches(site));

    CHECK(read(entry.substr(0, 13) + entry.substr(entry.find("function")))[0].matches({Change::plus_minus, 0, 0, {"f", "b.comp", 3, "x + y"}}));
    CHECK_THROWS_AS(read("[[survivor]]\nfile = \"a.comp\"\n"), InputError);
    std::string typo = entry;
    typo.replace(typo.find("plus_minus"), 10, "plus_minis");
    CHECK_THROWS_WITH(read(typo), Catch::Contains("plus_minus"));
}

}  // namespace
