// Each small stage of this folder through everything that works for stages: its kernel, export and validate as the program
// runs them, explain, stability, its twin on lavapipe, and generic mutants of it.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "core/hash.h"
#include "gi/lend.h"
#include "gi/parity/stages.h"
#include "gi/parity/verdict.h"
#include "gi/stability/stability.h"
#include "io/filling.h"
#include "io/manifest.h"
#include "tests/parity/devices.h"
#include "tests/proof/stages.h"
#include "tools/mutants/edit.h"
#include "tools/mutants/generic.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/export_files.h"
#include "tools/vulkan/runner.h"
#include "tools/vulkan/shader.h"

namespace {

using namespace plumb;
namespace fs = std::filesystem;

float noise(int i, int seed) { return float(pcg(i + 7919 * seed) & 0xffff) / 65536.0f; }

// More receivers than fill the groups of 8.
StageData list_data() {
    const int n = 1003, senders = 257, links = 9;
    StageData d = begin_data<proof::ListKernel>({n, 1}, proof::ListView::Uniforms{n, 1, senders, links, 0.75f, {}});
    std::vector<float> positions, radiosity;
    std::vector<std::int32_t> named;
    for (int i = 0; i < n; ++i) positions.push_back(4 * noise(i, 1) - 2);
    for (int i = 0; i < n * links; ++i) named.push_back(pcg(i) & 0xff);
    for (int i = 0; i < 4 * senders; ++i) radiosity.push_back(noise(i, 2) + 0.1f);
    add(d.inputs, "positions", {n}, positions.data());
    add(d.inputs, "links", {n, links}, named.data());
    add(d.inputs, "radiosity", {senders, 4}, radiosity.data());
    return d;
}

Image4 noise_image(glm::ivec2 size, int seed) {
    Image4 image(size.x, size.y);
    for (std::size_t i = 0; i < image.size(); ++i)
        for (int c = 0; c < 4; ++c) image.texels[i][c] = c == 3 ? 1.0f : noise(int(i), seed + c) + 0.05f;
    return image;
}

StageData pair_data() {
    const glm::ivec2 size(37, 23);
    StageData d = begin_data<proof::PairKernel>(size, proof::PairView::Uniforms{size.x, size.y, {}});
    add(d.inputs, "vectors", noise_image(size, 3));
    return d;
}

StageData step_data() {
    const glm::ivec2 size(37, 23);
    StageData d = begin_data<proof::StepKernel>(size, proof::StepView::Uniforms{size.x, size.y, 0.6f, 0});
    add(d.inputs, "source", noise_image(size, 10)), add(d.inputs, "before", noise_image(size, 20));
    return d;
}

std::vector<StageData> all_data() {
    std::vector<StageData> all = {list_data(), pair_data(), step_data()};
    for (StageData& d : all) d.label = d.id = d.stage;
    return all;
}

const StageBinding& binding_of(const StageData& data) { return parity::find_binding(data.stage, "test"); }

Bundle run_here(const StageData& data) {
    Bundle outputs;
    binding_of(data).bind(data)->run({}, {}, outputs);
    return outputs;
}

std::vector<std::uint32_t> spirv_of(const StageData& data) {
    std::string name = binding_of(data).twin;
    std::replace(name.begin(), name.end(), '/', '.');
    return vulkan::load_spirv(std::string(PLUMB_SPIRV_DIR) + "/" + name + ".spv");
}

parity::StageVerdict judged(const StageData& data, const Bundle& outputs) {
    std::vector<parity::Dumped> dumped;
    for (const Array& array : outputs.arrays) dumped.push_back({array.name, array});
    return parity::judge(binding_of(data), data, dumped, {});
}

float* values(Array& array) { return reinterpret_cast<float*>(array.bytes.data()); }

// Writes the dispatch as `plumb export` does, with what `fill` makes of the outputs in out/.
fs::path exported(const StageData& data, const std::string& name, const Bundle& out) {
    const fs::path folder = fs::path(PLUMB_BINARY_DIR) / "proof_exports" / (data.stage + "." + name);
    fs::remove_all(folder);
    cli::Outputs outputs(folder.string());
    cli::ExportFiles files(outputs, folder.string(), io::filling_word(0x0123456789abcdef));
    io::Manifest manifest;
    manifest.file = folder / "manifest.toml";
    manifest.profile = "ideal";
    manifest.exported.id = "0123456789abcdef";
    manifest.stages.push_back(cli::export_stage(binding_of(data), data, "", run_here(data), {out}, files));
    manifest.exported.files = files.hashes();
    const std::string text = io::manifest_text(manifest);
    files.write("manifest.toml", text.data(), text.size());
    outputs.commit();
    return manifest.file;
}

// The last place where it stands.
void replace_in(const fs::path& file, const std::string& old, const std::string& with) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    std::string all = text.str();
    const std::size_t at = all.rfind(old);
    REQUIRE(at != std::string::npos);
    std::ofstream(file) << all.replace(at, old.size(), with);
}

int run_plumb(std::vector<std::string> words) {
    words.insert(words.begin(), "plumb");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    return cli::run_program(int(words.size()), argv.data());
}

}  // namespace

TEST_CASE("proof: the closed forms of the small stages", "[proof]") {
    // A receiver far from all senders gets their sum over distance squared; weights of 1 at distance 0.
    StageData list = list_data();
    const Bundle gathered = run_here(list);
    const auto* g = reinterpret_cast<const float*>(gathered.arrays.at(0).bytes.data());
    const float* x = floats(list, "positions");
    const float* b = floats(list, "radiosity");
    const std::int32_t* links = ints(list, "links");
    for (const int i : {0, 500, 1002}) {
        double sum = 0;
        for (int k = 0; k < 9; ++k) {
            const float* sender = b + 4 * links[9 * i + k];
            sum += 0.75 / (1 + std::pow(double(x[i]) - sender[3], 2)) * sender[0];
        }
        CHECK(g[4 * i] == Approx(sum).epsilon(1e-6));
    }
    const Bundle pair = run_here(pair_data());
    REQUIRE(pair.arrays.size() == 2);
    CHECK(pair.arrays[0].shape == Shape{23, 37, 4});
    CHECK(pair.arrays[1].shape == Shape{23, 37});
}

TEST_CASE("proof: the program lists the small stages and refuses data that does not fit", "[proof]") {
    CHECK(run_plumb({"stages"}) == 0);
    CHECK(run_plumb({"stages", "--json"}) == 0);
    StageData two_rows = list_data();
    two_rows.size.y = 2, two_rows.label = two_rows.stage;
    CHECK_THROWS_AS(binding_of(two_rows).bind(two_rows), InputError);
}

TEST_CASE("proof: export and validate", "[proof]") {
    for (const StageData& data : all_data()) {
        INFO(data.stage);
        const Bundle ours = run_here(data);
        CHECK(run_plumb({"validate", exported(data, "right", ours).string()}) == 0);
        // One value of the last output is off by a thousandth.
        Bundle off = ours;
        values(off.arrays.back())[off.arrays.back().bytes.size() / 8] *= 1.001f;
        CHECK(run_plumb({"validate", exported(data, "wrong", off).string()}) == 1);
        // An image is no list, and a list has as many elements as the stage has items.
        const bool list = data.stage == "proof.list";
        const fs::path counted = exported(data, "counted", ours);
        replace_in(counted, list ? "count = 1003" : "width = 37\nheight = 23\n", list ? "count = 1002" : "count = 851\n");
        CHECK(run_plumb({"validate", counted.string()}) == 2);
        // Nothing is written.
        CHECK(run_plumb({"validate", exported(data, "nothing", {}).string()}) == 1);
    }
}

TEST_CASE("proof: explain ends in what the stage writes", "[proof]") {
    const char* const last[] = {"irradiance", "length", "next"};
    const char* const output[] = {"gathered", "length", "after"};
    int i = 0;
    for (const StageData& data : all_data()) {
        INFO(data.stage);
        const glm::ivec2 item(data.size.x / 2, data.size.y / 2);
        const std::vector<TapValue> taps = explain(binding_of(data), data, item);
        const Bundle ours = run_here(data);
        const Array& array = at(ours, output[i]);
        const std::size_t channels = array.bytes.size() / 4 / (std::size_t(data.size.x) * std::size_t(data.size.y));
        const auto* written = reinterpret_cast<const float*>(array.bytes.data()) +
                              channels * (std::size_t(item.y) * std::size_t(data.size.x) + std::size_t(item.x));
        REQUIRE(taps.back().name == last[i++]);
        for (std::size_t c = 0; c < taps.back().value.size(); ++c) CHECK(taps.back().value[c] == written[c]);
    }
}

TEST_CASE("proof: stability cells", "[proof]") {
    for (const StageData& data : all_data()) {
        const stability::Cell cell = stability::evaluate(binding_of(data), data, {});
        INFO(data.stage << ": " << cell.reason);
        CHECK(cell.ok);
        CHECK(cell.pixels == 64);
        CHECK(cell.used > 0);
        CHECK(cell.used < 16);
    }
}

TEST_CASE("proof: twins on a device give the kernels' bits, and a wrong value is seen", "[proof][vulkan]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    for (const StageData& data : all_data()) {
        INFO(data.stage);
        const std::vector<std::uint32_t> spirv = spirv_of(data);
        vulkan::RunTwin how;
        how.spirv = spirv;
        Bundle theirs = vulkan::run_twin(*device, binding_of(data), data, how).outputs;
        const Bundle ours = run_here(data);
        REQUIRE(theirs.arrays.size() == ours.arrays.size());
        for (std::size_t i = 0; i < ours.arrays.size(); ++i) {
            CHECK(theirs.arrays[i].shape == ours.arrays[i].shape);
            CHECK(theirs.arrays[i].bytes == ours.arrays[i].bytes);
        }
        const parity::StageVerdict verdict = judged(data, theirs);
        CHECK(verdict.passed);
        CHECK(verdict.decided);
        CHECK(verdict.nonzero > verdict.pixels / 2);
        values(theirs.arrays.back())[theirs.arrays.back().bytes.size() / 8] *= 1.001f;
        CHECK_FALSE(judged(data, theirs).passed);
    }
}

// Every change that the generator makes of the twin runs on the device.
TEST_CASE("proof: generic mutants of the twins are found", "[proof][vulkan][mutants]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    for (const StageData& data : all_data()) {
        const StageBinding& binding = binding_of(data);
        const auto shader = mutants::read_shader(binding, binding.twin, spirv_of(data), PLUMB_SOURCE_DIR);
        int found = 0, sites = 0;
        std::string survived;
        const std::vector<std::uint32_t> plain = spirv_of(data);
        vulkan::RunTwin how;
        how.spirv = plain;
        vulkan::PreparedTwin twin(*device, binding, data, how);
        for (const mutants::Site& site : shader->sites) {
            const auto mutant = words_of(mutants::guarded(mutants::changed(shader->module, *shader->index, site), 4096));
            twin.use(mutant);
            twin.submit();
            const bool wrong = !judged(data, twin.read().outputs).passed;
            ++sites, found += wrong;
            if (!wrong) survived += fmt::format("{} {} {} (part {})\n", data.stage, site.place.function, change_name(site.change), site.part);
        }
        INFO(data.stage << ": " << found << " of " << sites << " found; survived:\n" << survived);
        CHECK(sites > 20);
        CHECK(found >= 0.8 * sites);
    }
}
