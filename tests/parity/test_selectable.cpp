// Many changes of a twin in one module: valid, and each does what it does alone.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "gi/parity/stages.h"
#include "tests/parity/devices.h"
#include "tests/parity/twin_data.h"
#include "tools/mutants/edit.h"
#include "tools/mutants/selectable.h"
#include "tools/vulkan/runner.h"
#include "tools/vulkan/twins.h"

namespace {

using namespace plumb;
using namespace plumb::mutants;

bool is_valid(const std::vector<std::uint32_t>& words) {
    const std::filesystem::path folder = std::filesystem::path(PLUMB_BINARY_DIR) / "test_selectable";
    std::filesystem::create_directories(folder);
    const std::string file = (folder / "module.spv").string();
    std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(words.data()), std::streamsize(4 * words.size()));
    return std::system((std::string(PLUMB_SPIRV_VAL) + " --target-env vulkan1.1 " + file).c_str()) == 0;
}

TEST_CASE("selectable: many changes in one module are what each is alone, and none is the twin", "[mutants]") {
    const StageData data = test::direct_case({24, 16}, "selectable");
    const StageBinding& binding = parity::find_binding(data.stage, "test");
    const vulkan::Twin twin = vulkan::find_twin(binding.twin);
    const SpirvModule module = parse_spirv(twin.spirv);
    const SpirvIndex index(module);
    std::vector<Site> sites;
    std::vector<PlacedChange> changes;
    std::set<std::size_t> taken;
    for (const Site& site : find_sites(module, index)) {
        const bool read = site.change == Change::input_dropped || site.change == Change::input_scaled;
        if (read || !is_selectable(module, index, site.at) || !taken.insert(site.at).second) continue;
        sites.push_back(site);
        changes.push_back({site.at, [&module, site](Editor& e) { edit(e, module, site); }});
    }
    REQUIRE(sites.size() > 20);
    const std::vector<std::uint32_t> all = words_of(guarded(selectable(module, index, changes), 1 << 20));
    REQUIRE(is_valid(all));

    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    vulkan::RunTwin options;
    options.selects = true;
    vulkan::PreparedTwin many(*device, binding, data, options), alone(*device, binding, data);
    many.use(all);
    many.select(0, {});
    many.submit(), alone.submit();
    const Bundle as_it_is = alone.read().outputs;
    CHECK(many.read().outputs.arrays[0].bytes == as_it_is.arrays[0].bytes);
    int others = 0;
    for (std::size_t i = 0; i < sites.size(); i += 3) {
        INFO(sites[i].place.function << " " << change_name(sites[i].change) << " " << sites[i].part);
        alone.use(words_of(guarded(changed(module, index, sites[i]), 1 << 20)));
        many.select(std::uint32_t(i + 1), {});
        many.submit(), alone.submit();
        const Bundle one = alone.read().outputs;
        CHECK(many.read().outputs.arrays[0].bytes == one.arrays[0].bytes);
        others += !(one.arrays[0].bytes == as_it_is.arrays[0].bytes);
    }
    CHECK(others > 5);

    // In the groups of some pixels alone: elsewhere nothing is written.
    const std::vector<glm::ivec2> some = {{9, 3}};
    many.select(0, some);
    many.submit();
    const Bundle part = many.read().outputs;
    const auto *p = reinterpret_cast<const float*>(part.arrays[0].bytes.data()),
               *q = reinterpret_cast<const float*>(as_it_is.arrays[0].bytes.data());
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 24; ++x)
            for (int c = 0; c < 4; ++c) {
                const bool inside = x >= 8 && x < 16 && y < 8;
                CHECK(p[4 * (24 * y + x) + c] == (inside ? q[4 * (24 * y + x) + c] : 0));
            }
}

}  // namespace
