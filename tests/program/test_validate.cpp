// plumb validate: errors planted in what `plumb export` wrote.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>

#include "core/formats.h"
#include "io/npy.h"
#include "tests/program/exported.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

constexpr int width = 61, height = 43;

// A copy of an export, to change.
std::string dumps(const std::string& name) {
    static const std::string exported = export_all("validate_exported");
    const std::string folder = fresh_folder(name);
    fs::copy(exported, folder, fs::copy_options::recursive);
    return folder;
}

Result validate(const std::string& folder, const Words& more = {}) {
    Words words = {"validate", folder + "/manifest.toml"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
}

Json report(const std::string& folder, int exit, const Words& more = {}) {
    Words words = more;
    words.push_back("--json");
    const Result r = validate(folder, words);
    INFO(r.out << r.err);
    REQUIRE(r.exit == exit);
    return Json::parse(r.out);
}

std::size_t texel(int x, int y) { return 4 * (std::size_t(y) * width + std::size_t(x)); }

// Exit code 2, one line.
std::string refused(const Result& r) {
    INFO(r.out << r.err);
    CHECK(r.exit == 2);
    CHECK(r.out.empty());
    REQUIRE(r.err.find("plumb: ") == 0);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    return r.err;
}

// A manifest of one of the exported stages, changed.
std::string refused_manifest(const std::string& folder, const std::string& text) {
    write(folder + "/manifest.toml", text);
    return refused(validate(folder));
}

}  // namespace

TEST_CASE("validate: one pixel off by a thousandth is found, and explained", "[program]") {
    const std::string folder = dumps("validate_pixel"), file = folder + "/rsm.disc.key/out/irradiance.bin";
    const float value = word<float>(read(file), texel(20, 30) + 1);
    REQUIRE(value > 0);
    set_word(file, texel(20, 30) + 1, value * 1.001f);

    const Json all = report(folder, 1), stage = stage_of(all, "rsm.disc (key)");
    CHECK(all["verdict"] == "wrong");
    CHECK(all["first_failed"] == "rsm.disc (key)");
    CHECK(keys(stage["worst"]) == Words{"pixel", "verdict", "output", "channel", "expected", "got", "bound", "excess"});
    CHECK(stage["worst"]["pixel"] == Json({20, 30}));
    CHECK(stage["worst"]["channel"] == 1);
    CHECK(stage["worst"]["got"] == value * 1.001f);
    CHECK(std::abs(double(stage["worst"]["expected"]) - value) <= 1e-6 * value);
    CHECK(double(stage["worst"]["bound"]) < 1e-4 * value);
    CHECK(stage["counts"]["wrong"] == 1);
    CHECK(stage["counts"]["equal"] == width * height - 1);
    CHECK(stage["wrong"] == Approx(1.0 / (width * height)));
    // The explanation ends with what our kernel makes of it.
    const Json last = stage["explain"]["values"].back();
    CHECK(last["name"] == "irradiance");
    CHECK(last["value"][1] == value);
    for (const Json& other : all["stages"])
        if (other["name"] != "rsm.disc (key)") CHECK(other["verdict"] == "equal");

    const Result text = validate(folder);
    CHECK(text.exit == 1);
    CHECK_THAT(text.out, Contains("The first stage that fails: rsm.disc (key)") && Contains("20,30") &&
                             Contains("disagree: rsm.disc (key): 1 of 2623 pixels are wrong") &&
                                 Contains("VRSM (3.2)"));
}

TEST_CASE("validate: the neighbouring float is within the bound", "[program]") {
    const std::string folder = dumps("validate_ulp"), file = folder + "/compose/out/radiance.bin";
    const float value = word<float>(read(file), texel(30, 20));
    REQUIRE(value > 0);
    set_word(file, texel(30, 20), std::nextafter(value, 2 * value));
    const Json stage = stage_of(report(folder, 0), "compose");
    CHECK(stage["verdict"] == "within_bound");
    CHECK(stage["counts"]["within_bound"] == 1);
    CHECK_THAT(validate(folder).out, Contains("agree: nothing is wrong"));
}

TEST_CASE("validate: NaN on either side is wrong", "[program]") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    SECTION("written") {
        const std::string folder = dumps("validate_nan");
        set_word(folder + "/tonemap/out/display.bin", texel(60, 42), nan);
        const Json stage = stage_of(report(folder, 1), "tonemap");
        CHECK(stage["worst"]["pixel"] == Json({60, 42}));
        CHECK(stage["worst"]["got"].is_null());
    }
    SECTION("read: our result is none either") {
        const std::string folder = dumps("validate_nan_in");
        set_word(folder + "/compose/in/direct.bin", texel(30, 20), nan);
        CHECK(stage_of(report(folder, 1), "compose")["counts"]["wrong"] == 1);
    }
}

TEST_CASE("validate: swapped channels, flipped and shifted pictures are wrong", "[program]") {
    const std::string folder = dumps("validate_swapped"), manifest = folder + "/manifest.toml";
    const std::string whole = only_stage(read(manifest), "compose"), file = "file = \"compose/out/radiance.bin\"\n";
    for (const char* line : {"channels = \"zyx\"\n", "flip_y = true\n"}) {
        INFO(line);
        write(manifest, replaced(whole, file, file + line));
        const Json stage = stage_of(report(folder, 1), "compose");
        CHECK(stage["verdict"] == "wrong");
        CHECK(stage["wrong"] > 0.2);
    }
    // One channel that is right is enough to agree.
    write(manifest, replaced(whole, file, file + "channels = \"_y\"\n"));
    CHECK(stage_of(report(folder, 0), "compose")["verdict"] == "equal");
    const std::string bytes = read(folder + "/compose/out/radiance.bin");
    write(folder + "/compose/out/radiance.bin", bytes.substr(16) + bytes.substr(0, 16));
    write(manifest, whole);
    CHECK(stage_of(report(folder, 1), "compose")["wrong"] > 0.2);
}

TEST_CASE("validate: a layout of one's own is described in the manifest", "[program]") {
    const std::string folder = dumps("validate_layout"), manifest = folder + "/manifest.toml";
    const std::string whole = only_stage(read(manifest), "compose");
    const std::string bytes = read(folder + "/gbuffer/out/normal.bin");

    SECTION("normals without a fourth channel, the lowest row first, rows padded") {
        std::string rows;
        for (int y = height - 1; y >= 0; --y) {
            for (int x = 0; x < width; ++x) rows += bytes.substr(4 * texel(x, y), 12);
            rows += std::string(20, '?');
        }
        write(folder + "/mine.raw", rows);
        const std::size_t at = whole.find("[stage.input.normal]"), end = whole.find('[', at + 1);
        write(manifest, whole.substr(0, at) +
                            "[stage.input.normal]\nfile = \"mine.raw\"\nvk_format = \"R32G32B32_SFLOAT\"\n"
                        "width = 61\nheight = 43\nrow_pitch = 752\nflip_y = true\n" + whole.substr(end));
        const Json stage = stage_of(report(folder, 0), "compose");
        CHECK(stage["verdict"] == "equal");
        CHECK_THAT(stage["notes"][0], Contains("normal") && Contains("not 0"));
    }
    SECTION("an output rounded to halves") {
        const std::string radiance = read(folder + "/compose/out/radiance.bin");
        std::string halves;
        for (std::size_t i = 0; i < radiance.size() / 4; ++i) {
            const Half half = float_to_half(word<float>(radiance, i));
            halves.append(reinterpret_cast<const char*>(&half), 2);
        }
        write(folder + "/compose/out/radiance.bin", halves);
        const std::size_t out = whole.find("[stage.output.radiance]");
        const std::string stored = whole.substr(0, out) + replaced(whole.substr(out), "R32G32B32A32", "R16G16B16A16");
        write(manifest, stored);
        CHECK(stage_of(report(folder, 0), "compose")["verdict"] == "equal");
        // The same numbers claimed to be exact are not.
        write(folder + "/compose/out/radiance.bin", [&] {
            std::string floats;
            for (std::size_t i = 0; i < radiance.size() / 4; ++i) {
                const float f = half_to_float(word<Half>(halves, i));
                floats.append(reinterpret_cast<const char*>(&f), 4);
            }
            return floats;
        }());
        write(manifest, whole);
        CHECK(stage_of(report(folder, 1), "compose")["verdict"] == "wrong");
    }
    SECTION("visibility as a file a light") {
        const std::string direct = only_stage(read(manifest), "direct");
        const std::string layers = read(folder + "/direct/in/visibility.bin");
        const std::size_t bytes_a_layer = std::size_t(width) * height * 4;
        REQUIRE(layers.size() == 3 * bytes_a_layer);
        const std::size_t at = direct.find("[stage.input.visibility]"), end = direct.find('[', at + 1);
        std::string inputs;
        for (int l : {0, 1, 2}) {
            const std::string name = "layer" + std::to_string(l);
            write(folder + "/" + name, layers.substr(std::size_t(l) * bytes_a_layer, bytes_a_layer));
            inputs += "[stage.input.\"visibility." + std::to_string(l) + "\"]\nfile = \"" + name +
                      "\"\nvk_format = \"R32_SFLOAT\"\nwidth = 61\nheight = 43\n";
            write(manifest, direct.substr(0, at) + inputs + direct.substr(end));
            if (l < 2) CHECK(validate(folder).exit == 2);
        }
        CHECK(stage_of(report(folder, 0), "direct")["verdict"] == "equal");
        write(manifest, direct.substr(0, at) + replaced(inputs, "visibility.1", "visibility.3") + direct.substr(end));
        CHECK_THAT(refused(validate(folder)), Contains("3 of 4 layers"));
    }
}

TEST_CASE("validate: a sample pattern of one's own", "[program]") {
    const std::string folder = fresh_folder("validate_pattern"), scene = small_scene(folder);
    REQUIRE(run({"export", scene, "--stage", "rsm.disc", "--light", "key", "--set", "rsm.rotations=1", "-o", folder})
                .exit == 0);
    write_expected(folder);
    const std::string manifest = read(folder + "/manifest.toml");
    const std::string offsets = read(folder + "/rsm.disc.key/in/offsets.bin");
    const std::string weights = read(folder + "/rsm.disc.key/in/weights.bin");
    const std::int64_t n = std::int64_t(weights.size() / 4);
    REQUIRE(n == 37);
    std::vector<float> rows;
    for (std::size_t k = 0; k < std::size_t(n); ++k) {
        rows.push_back(float(word<std::int16_t>(offsets, 2 * k)));
        rows.push_back(float(word<std::int16_t>(offsets, 2 * k + 1)));
        rows.push_back(word<float>(weights, k));
    }
    io::write_npy(folder + "/mine.npy", DType::f32, {n, 3}, rows.data());

    // Without the table, and without what follows from the pattern.
    std::string mine = manifest;
    for (const char* input : {"offsets", "weights"}) {
        const std::size_t at = mine.find(std::string("[stage.input.") + input + "]");
        mine.erase(at, mine.find('[', at + 1) - at);
    }
    for (const char* uniform : {"\nsamples = ", "\nrotations = ", "\nreach = "}) {
        const std::size_t at = mine.find(uniform);
        mine.erase(at, mine.find('\n', at + 1) - at);
    }
    mine += "[stage.input.pattern]\nfile = \"mine.npy\"\n";
    write(folder + "/manifest.toml", mine);
    CHECK(report(folder, 0)["verdict"] == "equal");

    // One sample elsewhere is another picture.
    rows[0] += 3;
    io::write_npy(folder + "/mine.npy", DType::f32, {n, 3}, rows.data());
    CHECK(report(folder, 1)["verdict"] == "wrong");
    rows[0] += 0.5f;
    io::write_npy(folder + "/mine.npy", DType::f32, {n, 3}, rows.data());
    CHECK_THAT(refused(validate(folder)), Contains("row 0") && Contains("whole texels"));
    io::write_npy(folder + "/mine.npy", DType::f32, {1, n * 3}, rows.data());
    CHECK_THAT(refused(validate(folder)), Contains("[N, 2]"));
    io::write_npy(folder + "/mine.npy", DType::f32, {n, 2}, rows.data());
    CHECK_THAT(refused(validate(folder)), Contains("weights"));
}

TEST_CASE("validate: a scene gives uniforms, patterns and geometry", "[program]") {
    const std::string folder = fresh_folder("validate_scene"), scene = small_scene(folder);
    REQUIRE(run({"export", scene, "--stage", "all", "-o", folder}).exit == 0);
    write_expected(folder);
    std::string exported = read(folder + "/manifest.toml");
    // The images alone: an input or an output with the lines that belong to it.
    auto images = [&](const std::string& label) {
        const std::string stage = only_stage(exported, label);
        std::string text;
        for (std::size_t at = stage.find("[stage.input."), end; at != stage.npos; at = end) {
            end = stage.find("\n[", at);
            end += end != stage.npos;
            const std::string part = stage.substr(at, end == stage.npos ? end : end - at);
            if (part.find("count = ") == part.npos) text += part;
        }
        return text;
    };
    auto with = [&](const std::string& lines, const std::string& label) {
        write(folder + "/manifest.toml", "scene = \"small.toml\"\n[[stage]]\n" + lines + images(label));
    };
    with("stage = \"rsm.disc\"\nlight = \"sun\"\n", "rsm.disc (sun)");
    CHECK(report(folder, 0)["verdict"] == "equal");
    with("stage = \"direct\"\n", "direct");
    CHECK(report(folder, 0)["verdict"] == "equal");
    with("stage = \"gbuffer\"\n", "gbuffer");
    CHECK(report(folder, 0)["verdict"] == "equal");
    with("stage = \"rsm\"\nlight = \"key\"\n", "rsm (key)");
    CHECK(report(folder, 0)["verdict"] == "equal");
    with("stage = \"shadow\"\nlight = \"key\"\n", "shadow (key)");
    CHECK(report(folder, 0)["verdict"] == "equal");

    // Other parameters than those that the picture was made with.
    with("stage = \"rsm.disc\"\nlight = \"sun\"\nparams = { samples = 36 }\n", "rsm.disc (sun)");
    CHECK(report(folder, 1)["verdict"] == "wrong");
    with("stage = \"tonemap\"\nparams = { exposure = 2 }\n", "tonemap");
    CHECK(report(folder, 1)["verdict"] == "wrong");
    // Another member of the block.
    with("stage = \"rsm.disc\"\nlight = \"sun\"\nuniforms = { scale = 1 }\n", "rsm.disc (sun)");
    CHECK(report(folder, 1)["verdict"] == "wrong");

    with("stage = \"rsm.disc\"\nlight = \"sum\"\n", "rsm.disc (sun)");
    CHECK_THAT(refused(validate(folder)), Contains("sum") && Contains("sun"));
    with("stage = \"rsm.disc\"\n", "rsm.disc (sun)");
    CHECK_THAT(refused(validate(folder)),
               Contains("light") && Contains("rsm.disc (key)") && Contains("rsm.disc (sun)"));
    with("stage = \"rsm.disc\"\nlight = \"sun\"\nparams = { sample = 36 }\n", "rsm.disc (sun)");
    CHECK_THAT(refused(validate(folder)), Contains("sample") && Contains("\"samples\""));
    with("stage = \"rsm.disc\"\nlight = \"sun\"\nparams = { samples = 0 }\n", "rsm.disc (sun)");
    CHECK_THAT(refused(validate(folder)), Contains("samples = 0"));
    with("stage = \"rsm.disc\"\nlight = \"sun\"\nsize = [62, 43]\n", "rsm.disc (sun)");
    CHECK(validate(folder).exit == 2);
    write(folder + "/manifest.toml", "scene = \"none.toml\"\n" + exported);
    CHECK_THAT(refused(validate(folder)), Contains("none.toml"));

    // A stage that runs more than once.
    REQUIRE(run({"export", scene, "--method", "isr", "--stage", "isr.blur", "-o", folder}).exit == 0);
    write_expected(folder);
    exported = read(folder + "/manifest.toml");
    with("stage = \"isr.blur\"\nform = \"vertical\"\n", "isr.blur (vertical)");
    CHECK(report(folder, 0)["verdict"] == "equal");
    with("stage = \"isr.blur\"\nform = \"horizontal\"\n", "isr.blur (vertical)");
    CHECK(report(folder, 1)["verdict"] == "wrong");
    with("stage = \"isr.blur\"\nform = \"diagonal\"\n", "isr.blur (vertical)");
    CHECK_THAT(refused(validate(folder)), Contains("form diagonal"));
    with("stage = \"isr.blur\"\n", "isr.blur (vertical)");
    CHECK_THAT(refused(validate(folder)), Contains("form") && Contains("isr.blur (horizontal)"));
}

TEST_CASE("validate: manifests and dumps that are at fault", "[program]") {
    const std::string folder = dumps("validate_bad"), manifest = read(folder + "/manifest.toml");
    const std::string one = only_stage(manifest, "rsm.disc (key)");

    CHECK_THAT(refused_manifest(folder, replaced(one, "stage = \"rsm.disc\"", "stage = \"rsm.disk\"")),
               Contains("manifest.toml") && Contains("rsm.disk") && Contains("rsm.disc"));
    CHECK_THAT(refused_manifest(folder, replaced(one, "least_distance2", "least_distance")),
               Contains("least_distance2"));
    CHECK_THAT(refused_manifest(folder, replaced(one, "[stage.input.normal]", "[stage.input.normals]")),
               Contains("normals") && Contains("\"normal\""));
    CHECK_THAT(refused_manifest(folder, replaced(one, "[stage.output.irradiance]", "[stage.output.iradiance]")),
               Contains("iradiance") && Contains("irradiance"));
    const std::string with_params = "[stage.params]\nradius = 1\n[stage.uniforms]";
    CHECK_THAT(refused_manifest(folder, replaced(one, "[stage.uniforms]", with_params)),
               Contains("radius") && Contains("scene"));
    CHECK_THAT(refused_manifest(folder, replaced(one, "\nscale = ", "\n# ")), Contains("missing: scale"));
    CHECK_THAT(refused_manifest(folder, one.substr(0, one.find("[stage.output"))), Contains("output"));
    CHECK_THAT(refused_manifest(folder, ""), Contains("manifest.toml"));
    CHECK_THAT(refused_manifest(folder, "profile = \"ideel\"\n" + one.substr(one.find("[[stage]]"))),
               Contains("ideal"));

    // Several inputs that nothing gives are named together.
    std::string without = one;
    for (const char* input : {"rsm_flux", "weights"}) {
        const std::size_t at = without.find(std::string("[stage.input.") + input + "]");
        without.erase(at, without.find('[', at + 1) - at);
    }
    CHECK_THAT(refused_manifest(folder, without), Contains("missing: input.rsm_flux, input.weights"));

    // Files.
    write(folder + "/manifest.toml", one);
    const std::string file = folder + "/rsm.disc.key/in/rsm_flux.bin", bytes = read(file);
    write(file, bytes.substr(0, bytes.size() - 1));
    CHECK_THAT(refused(validate(folder)), Contains("rsm_flux.bin"));
    write(file, bytes + "1");
    CHECK_THAT(refused(validate(folder)), Contains("rsm_flux.bin"));
    fs::remove(file);
    CHECK_THAT(refused(validate(folder)), Contains("rsm_flux.bin"));
    write(file, bytes.substr(0, 47 * 47 * 16));
    const std::size_t flux = one.find("rsm_flux.bin");
    write(folder + "/manifest.toml",
          one.substr(0, flux) +
              replaced(replaced(one.substr(flux), "width = 48", "width = 47"), "height = 48", "height = 47"));
    CHECK_THAT(refused(validate(folder)), Contains("rsm_flux"));
    write(file, bytes);
    const std::size_t position = one.find("[stage.input.position]");
    write(folder + "/manifest.toml",
          one.substr(0, position) + replaced(one.substr(position), "height = 43", "height = 42"));
    CHECK(validate(folder).exit == 2);

    // Indices that lead out of a buffer are not followed.
    write(folder + "/manifest.toml", only_stage(manifest, "gbuffer"));
    const std::string triangles = folder + "/gbuffer/in/triangles.bin";
    set_word(triangles, 4, std::int32_t(1 << 30));
    CHECK_THAT(refused(validate(folder)), Contains("triangles"));
    CHECK_THAT(refused(run({"validate", folder})), Contains("validate_bad"));
    CHECK_THAT(refused(run({"validate"})), Contains("MANIFEST"));
    CHECK_THAT(refused(run({"validate", folder + "/manifest.toml", "--max-ambiguous", "2"})),
               Contains("--max-ambiguous"));
    CHECK_THAT(refused(run({"validate", folder + "/manifest.toml", "--profile", "lavapipe"})), Contains("--profile"));
}

TEST_CASE("validate: reports as files", "[program]") {
    const std::string folder = dumps("validate_files"), out = fresh_folder("validate_files_out");
    const std::string text = read(folder + "/manifest.toml"), compose = only_stage(text, "compose");
    const std::string named = replaced(compose, "label = \"compose\"", "label = \"<script>alert('&\\\"')</script>\"");
    write(folder + "/manifest.toml", "device = \"<b>\"\n" + named +
                                         only_stage(text, "tonemap").substr(text.find("[[stage]]")));
    set_word(folder + "/compose/out/radiance.bin", texel(7, 8), 5.0f);

    const Result r =
        validate(folder, {"--junit", out + "/junit.xml", "--html", out + "/report.html", "-o", out + "/pictures"});
    INFO(r.err);
    REQUIRE(r.exit == 1);
    CHECK(files_in(out) == Words{"junit.xml", "pictures/compose.error.png", "pictures/compose.verdict.png",
                                 "pictures/tonemap.verdict.png", "report.html"});
    const std::string junit = read(out + "/junit.xml"), html = read(out + "/report.html");
    CHECK_THAT(junit, Contains("tests=\"2\" failures=\"1\"") && Contains("name=\"tonemap\"") &&
                          Contains("pixel 7,8: wrong") &&
                          Contains("name=\"&lt;script&gt;alert(&#39;&amp;&quot;&#39;)&lt;/script&gt;\""));
    CHECK_THAT(html, !Contains("<script>alert") && Contains("data:image/png;base64,") && Contains("&lt;b&gt;") &&
                         Contains("L = (rho (E_direct + E_indirect) + M) / pi"));
    for (const char* network : {"http:", "https:", "src=\"//"}) CHECK_THAT(html, !Contains(network));

    // The red pixel is where the picture is wrong.
    const std::string png = read(out + "/pictures/compose.verdict.png");
    CHECK(png.substr(1, 3) == "PNG");

    // Where nothing can be written nothing is.
    write(out + "/file", "");
    CHECK(validate(folder, {"-o", out + "/file"}).exit == 2);
    CHECK(validate(folder, {"--html", out + "/none/report.html"}).exit == 2);
    CHECK(validate(folder, {"--junit", out + "/pictures"}).exit == 2);
}

TEST_CASE("validate: packed normals have no zero, and the manifest says where nothing is seen", "[program]") {
    // What decodes to (0, 0, 1), and (-1, -1, -1) where it is biased, is stored where there is no surface.
    const std::string folder = dumps("validate_coverage"), manifest = folder + "/manifest.toml";
    const std::string normals = read(folder + "/gbuffer/out/normal.bin");
    std::string packed, stencil;
    std::vector<bool> hit;
    for (std::size_t i = 0; i < std::size_t(width * height); ++i) {
        hit.push_back(word<float>(normals, 4 * i + 3) > 0);
        for (std::size_t c = 0; c < 3; ++c) {
            const float code = hit[i] ? 0.5f * word<float>(normals, 4 * i + c) + 0.5f : 0.0f;
            packed.append(reinterpret_cast<const char*>(&code), 4);
        }
        stencil += char(hit[i] ? 3 : 2);
    }
    const auto nothing = std::count(hit.begin(), hit.end(), false);
    REQUIRE(nothing > 0);
    write(folder + "/packed.raw", packed);
    write(folder + "/stencil.raw", stencil);
    const std::string normal = "file = \"packed.raw\"\nvk_format = \"R32G32B32_SFLOAT\"\nencoding = \"biased\"\n";
    const std::string coverage = "[stage.coverage]\nfile = \"stencil.raw\"\nvk_format = \"R8_UINT\"\nabove = 2\n";

    SECTION("an input") {
        const std::string whole = only_stage(read(manifest), "compose");
        const std::size_t at = whole.find("[stage.input.normal]"), end = whole.find('[', at + 1);
        // Light where there is no surface, but for the mask.
        const std::string lit = replaced(whole.substr(0, at) + "[stage.input.normal]\n" + normal + whole.substr(end),
                                         "environment = [0, 0, 0, 0]", "environment = [1, 1, 1, 0]");
        std::string radiance = read(folder + "/compose/out/radiance.bin");
        const float one = 1;
        for (std::size_t i = 0; i < hit.size(); ++i)
            for (std::size_t c = 0; c < 3 && !hit[i]; ++c) std::memcpy(&radiance[16 * i + 4 * c], &one, 4);
        write(folder + "/compose/out/radiance.bin", radiance);
        write(manifest, lit);
        CHECK(stage_of(report(folder, 1), "compose")["counts"]["wrong"] >= nothing);
        write(manifest, lit + coverage);
        const Json stage = stage_of(report(folder, 0), "compose");
        CHECK(stage["counts"]["wrong"] == 0);
        CHECK_THAT(stage["notes"].back(), Contains(std::to_string(nothing) + " of 2623 pixels"));
        CHECK_THAT(validate(folder).out, Contains("coverage: nothing is seen at"));
    }
    SECTION("an output") {
        const std::string whole = only_stage(read(manifest), "gbuffer");
        const std::size_t at = whole.find("[stage.output.normal]"), end = whole.find('[', at + 1);
        const std::string mine = whole.substr(0, at) + "[stage.output.normal]\n" + normal + whole.substr(end);
        write(manifest, mine);
        CHECK(stage_of(report(folder, 1), "gbuffer")["counts"]["wrong"] == nothing);
        write(manifest, mine + coverage);
        CHECK(stage_of(report(folder, 0), "gbuffer")["counts"]["wrong"] == 0);
        // Outputs that are dumped as they are stay: a stray albedo is seen.
        const auto first = std::size_t(std::find(hit.begin(), hit.end(), false) - hit.begin());
        set_word(folder + "/gbuffer/out/albedo.bin", 4 * first, 1.0f);
        CHECK(stage_of(report(folder, 1), "gbuffer")["counts"]["wrong"] == 1);
    }
    SECTION("of another size") {
        const std::string whole = only_stage(read(manifest), "compose");
        write(folder + "/stencil.raw", stencil.substr(61));
        CHECK_THAT(refused_manifest(folder, whole + coverage + "width = 61\nheight = 42\n"),
                   Contains("coverage: is 61 x 42") && Contains("61 x 43"));
    }
}

TEST_CASE("validate: a depth buffer of 16 bits, and one that was made linear", "[program]") {
    const std::string folder = dumps("validate_depth"), manifest = folder + "/manifest.toml";
    const std::string whole = only_stage(read(manifest), "gbuffer");
    const std::string bytes = read(folder + "/gbuffer/out/depth.bin");
    std::string codes;
    for (std::size_t i = 0; i < bytes.size() / 4; ++i) {
        const auto code = std::uint16_t(std::lround(65535.0 * word<float>(bytes, i)));
        codes.append(reinterpret_cast<const char*>(&code), 2);
    }
    write(folder + "/depth16.raw", codes);
    const std::size_t at = whole.find("[stage.output.depth]"), end = whole.find('[', at + 1);
    auto with = [&](const std::string& lines) {
        return whole.substr(0, at) + "[stage.output.depth]\n" + lines + whole.substr(end);
    };
    const std::string sixteen = with("file = \"depth16.raw\"\nvk_format = \"D16_UNORM\"\n");
    write(manifest, sixteen);
    CHECK(stage_of(report(folder, 0), "gbuffer")["counts"]["wrong"] == 0);
    // Ten codes farther off, at one pixel of the floor.
    const std::size_t pixel = 40 * width + 30;
    set_word<std::uint16_t>(folder + "/depth16.raw", pixel, std::uint16_t(word<std::uint16_t>(codes, pixel) - 10));
    const Json stage = stage_of(report(folder, 1), "gbuffer");
    CHECK(stage["counts"]["wrong"] == 1);
    CHECK(stage["worst"]["output"] == "depth");

    const std::string file = "file = \"gbuffer/out/depth.bin\"\nvk_format = \"D32_SFLOAT\"\n";
    CHECK_THAT(refused_manifest(folder, with(file + "encoding = \"reversed_depth\"\nnear_far = [0.1, 100]\n")),
               Contains("output.depth") && Contains("linear depth") && Contains("reversed_z"));
}

TEST_CASE("validate: what was not judged is not called equal", "[program]") {
    // The shadow pass of a face writes the points in its pyramid alone: below a light at the ceiling, none of +y.
    const std::string folder = fresh_folder("validate_none"), scene = small_scene(folder);
    write(scene, replaced(read(scene),
                          "type = \"spot\"\nposition = [0, 1.97, 0]\ndirection = [0, -1, 0]\ncone_deg = [55, 60]",
                          "type = \"point\"\nposition = [0, 1.999, 0]"));
    REQUIRE(run({"export", scene, "--stage", "shadow", "--light", "key", "--face", "py", "-o", folder}).exit == 0);
    const std::string alone = read(folder + "/manifest.toml");
    const Json all = report(folder, 1);
    CHECK(all["passed"] == false);
    CHECK(all["reason"] == "no pixel was judged");
    CHECK(all["stages"][0]["judged"] == 0);
    CHECK(all["stages"][0]["verdict"] == "nothing_to_judge");
    CHECK_THAT(validate(folder).out, Contains("nothing to judge") && Contains("disagree: no pixel was judged"));
    const Words files = {"--junit", folder + "/j.xml", "--html", folder + "/r.html"};
    CHECK(validate(folder, files).exit == 1);
    CHECK_THAT(read(folder + "/j.xml"),
               Contains("failures=\"1\"") && Contains("<failure message=\"no pixel was judged\""));
    CHECK_THAT(read(folder + "/r.html"), Contains(">nothing to judge<") && Contains("no pixel was judged"));

    // Beside a stage that was judged it is skipped.
    REQUIRE(run({"export", scene, "--stage", "gbuffer", "-o", folder + "/g"}).exit == 0);
    write_expected(folder + "/g");
    std::string both = read(folder + "/g/manifest.toml");
    both = both.substr(both.find("[[stage]]"));
    for (std::size_t at = 0; (at = both.find("file = \"", at)) != both.npos; at += 10) both.insert(at + 8, "g/");
    write(folder + "/manifest.toml", alone + both);
    CHECK(report(folder, 0, files)["stages"][1]["judged"] == width * height);
    CHECK_THAT(read(folder + "/j.xml"), Contains("failures=\"0\"") && Contains("skipped=\"1\""));
}

TEST_CASE("validate: contradictions and what is not finite are named", "[program]") {
    const std::string folder = dumps("validate_notes"), whole = read(folder + "/manifest.toml");
    const std::string compose = only_stage(whole, "compose"), tonemap = only_stage(whole, "tonemap");
    CHECK_THAT(refused_manifest(folder, replaced(compose, "\nwidth = 61\n", "\nwidth = 60\n")), Contains("width = 60"));
    CHECK_THAT(refused_manifest(folder, replaced(tonemap, "exposure = 1", "exposure = 1e300")),
               Contains("exposure") && Contains("too large for a float"));
    auto with = [&](const std::string& line) {
        return replaced(tonemap, "[stage.uniforms]", "[stage.params]\n" + line + "\n[stage.uniforms]");
    };
    CHECK_THAT(refused_manifest(folder, with("exposur = 2")), Contains("\"exposure\""));
    CHECK_THAT(refused_manifest(folder, with("exposure = -2")), Contains("exposure = -2") && !Contains("no scene"));
    CHECK_THAT(refused_manifest(folder, with("exposure = 2")), Contains("no scene"));
    for (const char* option : {"--profile", "--html", "--junit", "-o"})
        CHECK_THAT(refused(run({"validate", folder + "/manifest.toml", option, ""})), Contains("expected a value"));

    write(folder + "/manifest.toml", replaced(compose, "label = \"compose\"", "light = \"key\""));
    CHECK_THAT(report(folder, 0)["stages"][0]["notes"][0], Contains("\"key\" is no more than a name"));

    write(folder + "/manifest.toml", compose);
    CHECK(report(folder, 0)["stages"][0]["notes"].empty());
    set_word(folder + "/compose/in/direct.bin", texel(30, 20), std::numeric_limits<float>::infinity());
    set_word(folder + "/compose/in/direct.bin", texel(31, 20), std::numeric_limits<float>::quiet_NaN());
    CHECK(report(folder, 1)["stages"][0]["notes"] == Json({"input direct: 2 values are not finite"}));
}

TEST_CASE("validate: ideal with a coarser grid of subpixels", "[program]") {
    // SwiftShader snaps vertices to sixteenths of a pixel (its VkPhysicalDeviceLimits::subPixelPrecisionBits is 4).
    const std::string folder = export_all("validate_subpixels", {"--profile", "swiftshader"});
    const std::string gbuffer = only_stage(read(folder + "/manifest.toml"), "gbuffer");
    write(folder + "/manifest.toml", replaced(gbuffer, "profile = \"swiftshader\"", "profile = \"ideal\""));
    CHECK(report(folder, 1)["stages"][0]["wrong"] > 0.1);
    write(folder + "/manifest.toml",
          replaced(gbuffer, "profile = \"swiftshader\"", "profile = \"ideal\"\nsubpixel_bits = 4"));
    const Json all = report(folder, 0);
    CHECK(all["subpixel_bits"] == 4);
    CHECK(all["stages"][0]["wrong"] == 0);
    CHECK_THAT(validate(folder).out, Contains("ideal with 4 subpixel bits"));
    // A device that is known states its own.
    const Json known = report(folder, 0, {"--profile", "swiftshader"});
    CHECK(known["subpixel_bits"].is_null());
    CHECK(known["verdict"] == "equal");
}

TEST_CASE("validate: a manifest to start from", "[program]") {
    const std::string folder = dumps("validate_init"), manifest = folder + "/manifest.toml";
    CHECK_THAT(refused(run({"validate", "--init", folder})), Contains("is there already"));

    // An exported folder says enough about itself.
    fs::remove(manifest);
    const Result r = run({"validate", "--init", folder});
    INFO(r.out << r.err);
    REQUIRE(r.exit == 0);
    const Json all = report(folder, 0);
    CHECK(all["verdict"] == "equal");
    CHECK(all["stages"].size() == 10);
    CHECK(refused(run({"validate", "--init", folder})).find("manifest.toml") != std::string::npos);

    // Files of one pass, named as people name them.
    const std::string mine = fresh_folder("validate_init_mine");
    const std::vector<std::pair<std::string, std::string>> names = {
        {"gbuffer/out/position.bin", "WorldPos.raw"}, {"gbuffer/out/normal.bin", "gNormals.raw"},
        {"rsm.key/out/position.bin", "RSM_Position.raw"}, {"rsm.disc.key/in/rsm_normal.bin", "RSM_Normal.raw"},
        {"rsm.disc.key/in/rsm_flux.bin", "RsmFlux.raw"}, {"rsm.disc.key/in/offsets.bin", "offsets.bin"},
        {"rsm.disc.key/in/weights.bin", "weights.bin"}, {"rsm.disc.key/out/irradiance.bin", "Irradiance.raw"},
        {"rsm.disc.key/block.bin", "uniforms.bin"}};
    for (const auto& [from, to] : names) fs::copy(folder + "/" + from, mine + "/" + to);
    write(mine + "/notes.png", "");
    const Result guessed = run({"validate", "--init", mine, "--json"});
    INFO(guessed.out << guessed.err);
    REQUIRE(guessed.exit == 0);
    CHECK(Json::parse(guessed.out)["unused"] == Json({"notes.png"}));
    CHECK(Json::parse(guessed.out)["missing"].empty());
    CHECK(report(mine, 0)["verdict"] == "equal");
    CHECK_THAT(read(mine + "/manifest.toml"), Contains("# not used: notes.png"));

    CHECK(run({"validate", "--init", fresh_folder("validate_init_empty")}).exit == 2);
    CHECK(run({"validate", "--init", mine + "/none"}).exit == 2);

    // Raw files alone do not say how large they are.
    const std::string raw = fresh_folder("validate_init_raw");
    write(raw + "/irradiance.raw", std::string(96 * 54 * 8, 'x'));
    CHECK_THAT(refused(run({"validate", "--init", raw})),
               Contains("irradiance.raw: as output.irradiance of rsm.disc it has 41472 bytes: of which size?"));
}
