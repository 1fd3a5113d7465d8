// Nothing passes by absence: what was written and means nothing, inputs that hold nothing, and pixels that are left out.
#include <fmt/format.h>

#include <limits>

#include "tests/program/absence.h"

using namespace plumb::program;

namespace fs = std::filesystem;

namespace {

// The one stage of an export with its right answer, and its manifest.
struct Answered {
    std::string folder, manifest;

    Answered(const std::string& name, const std::string& stage, const Words& more = {})
        : folder(exported(name, more, stage)), manifest(read(folder + "/manifest.toml")) {
        write_expected(folder);
    }
    Json judged(int exit) const {
        const Result r = validate(folder, {"--json"});
        INFO(r.out << r.err);
        REQUIRE(r.exit == exit);
        return Json::parse(r.out)["stages"][0];
    }
    // Files of one's own are none of the export's.
    void unlisted(const std::string& lines = "") const {
        const std::size_t at = manifest.find("[export]"), end = manifest.find("\n[[stage]]");
        write(folder + "/manifest.toml", manifest.substr(0, at) + manifest.substr(end) + lines);
    }
};

const std::string shadow_in = "/shadow.key/in/", shadow_out = "/shadow.key/out/visibility.bin";
Words of_key() { return {"--light", "key"}; }
constexpr std::size_t pixels = std::size_t(width) * height;

// A byte a pixel: 1 where a surface is.
std::string stencil_of(const std::string& normals, bool inverted = false) {
    std::string bytes;
    for (std::size_t i = 0; i < pixels; ++i) bytes += char((word<float>(normals, 4 * i + 3) > 0) != inverted);
    return bytes;
}
const std::string coverage = "[stage.coverage]\nfile = \"stencil.raw\"\nvk_format = \"R8_UINT\"\n";

}  // namespace

TEST_CASE("absence: another pass's output, an input, one colour, and a file of the wrong size", "[program][absence]") {
    const std::string folder = exported("absence_nonsense");
    auto wrong = [&](const std::string& bytes) {
        write(folder + out_file, bytes);
        const Json stage = disagrees(folder, "pixels are wrong");
        CHECK(stage["nonzero"]["wrong"] > 0.9);
    };
    for (const char* input : {"direct", "albedo", "normal", "indirect"}) {
        INFO(input);
        wrong(read(folder + "/compose/in/" + input + ".bin"));
    }
    wrong(floats(4 * pixels, 0.25f));
    wrong(floats(4 * pixels, 1));
    wrong(floats(4 * pixels, std::numeric_limits<float>::infinity()));
    // Of another size: it ends early, or goes on, which the manifest has no word for.
    write(folder + out_file, read(folder + answer_file).substr(0, 16 * 30 * 20));
    CHECK(disagrees(folder, "2023 of 2623 pixels were never written")["unwritten"] == 2023);
    write(folder + out_file, read(folder + answer_file) + read(folder + answer_file));
    const Result longer = validate(folder);
    INFO(longer.out << longer.err);
    CHECK(longer.exit == 2);
    CHECK_THAT(longer.err, Contains("out/radiance.bin") && Contains("trailing"));
    // Turned by a pixel: the answer, and yet none.
    const std::string answer = read(folder + answer_file);
    wrong(answer.substr(16) + answer.substr(0, 16));
}

TEST_CASE("absence: the expected file itself", "[program][absence]") {
    const std::string folder = exported("absence_expected");
    SECTION("a hard link") {
        fs::remove(folder + out_file);
        fs::create_hard_link(folder + answer_file, folder + out_file);
    }
    SECTION("a symbolic link") {
        fs::remove(folder + out_file);
        fs::create_symlink(fs::absolute(folder + answer_file), folder + out_file);
    }
    SECTION("named in the manifest") {
        const std::string text = read(folder + "/manifest.toml");
        write(folder + "/manifest.toml", replaced(text, "file = \"compose/out/radiance.bin\"", "file = \"compose/expected/radiance.bin\""));
    }
    const Json stage = disagrees(folder, "is the expected output itself: nothing of a renderer's was judged");
    CHECK(stage["verdict"] == "equal");
    CHECK(stage["stale"] != "");
}

TEST_CASE("absence: where nothing is seen pixels are left out, and what is written there is not judged", "[program][absence]") {
    const Answered a("absence_left_out", "shadow", of_key());
    const std::string normals = read(a.folder + shadow_in + "normal.bin"), right = read(a.folder + shadow_out);
    const std::string stencil = stencil_of(normals);
    const auto nothing = std::count(stencil.begin(), stencil.end(), '\0');
    REQUIRE(nothing > 100);
    write(a.folder + "/stencil.raw", stencil);
    // A renderer that clears to 0 there, or to NaN, or discards.
    for (const float cleared : {0.0f, std::numeric_limits<float>::quiet_NaN()}) {
        std::string out = right;
        for (std::size_t i = 0; i < pixels; ++i)
            if (!stencil[i]) std::memcpy(&out[4 * i], &cleared, 4);
        write(a.folder + shadow_out, out);
        a.unlisted();
        CHECK(a.judged(1)["counts"]["wrong"] == nothing);
        a.unlisted(coverage);
        const Json stage = a.judged(0);
        CHECK(stage["counts"]["wrong"] == 0);
        CHECK(stage["left_out"] == nothing);
        CHECK(stage["pixels"] == int(pixels) - nothing);
        CHECK(stage["notes"].back() == fmt::format("coverage: nothing is seen at {} of 2623 pixels, which are left out", nothing));
        CHECK_THAT(validate(a.folder).out, Contains("which are left out"));
    }
    // Where something is seen nothing is forgiven.
    const std::size_t seen = stencil.find(char(1));
    set_word(a.folder + shadow_out, seen, word<float>(right, seen) + 0.5f);
    CHECK(a.judged(1)["counts"]["wrong"] == 1);
}

TEST_CASE("absence: every pixel left out, or those that matter", "[program][absence]") {
    const Answered a("absence_all_left_out", "shadow", of_key());
    a.unlisted(coverage);
    write(a.folder + "/stencil.raw", std::string(pixels, '\0'));
    const Json all = a.judged(1);
    CHECK(all["verdict"] == "nothing_to_judge");
    CHECK(all["passed"] == false);
    CHECK(all["left_out"] == int(pixels));
    CHECK_THAT(validate(a.folder).out, Contains("nothing is seen at any of its 2623 pixels, and all are left out") &&
                                           Contains("disagree: no pixel was judged"));
    // The wrong way around the sky alone is judged, where light is expected and nothing is read.
    write(a.folder + "/stencil.raw", stencil_of(read(a.folder + shadow_in + "normal.bin"), true));
    const Json inverted = a.judged(1);
    CHECK(inverted["verdict"] == "nothing_to_judge");
    CHECK(inverted["nonzero"]["pixels"] == 0);
    CHECK_THAT(inverted["reason"].get<std::string>(), Contains("all that is read is 0"));
    CHECK_THAT(validate(a.folder).out, Contains("disagree: nothing to judge: all that is read is 0"));
}

TEST_CASE("absence: inputs of nothing, to which an answer that is no 0 is right", "[program][absence]") {
    const Answered a("absence_no_inputs", "shadow", of_key());
    a.unlisted();
    for (const char* input : {"position.bin", "normal.bin"}) write(a.folder + shadow_in + input, floats(4 * pixels, 0));
    // Lit everywhere: what a renderer clears to agrees, and is no evidence.
    write(a.folder + shadow_out, floats(pixels, 1));
    const Json stage = a.judged(1);
    CHECK(stage["counts"]["equal"] == int(pixels));
    CHECK(stage["verdict"] == "nothing_to_judge");
    CHECK(stage["passed"] == false);
    // Dark everywhere is wrong.
    write(a.folder + shadow_out, floats(pixels, 0));
    CHECK(a.judged(1)["counts"]["wrong"] == int(pixels));
}

TEST_CASE("absence: a stage that draws says itself what is seen", "[program][absence]") {
    const Answered a("absence_drawn", "gbuffer");
    const std::string normals = read(a.folder + "/gbuffer/out/normal.bin");
    // A triangle that is missing in its outputs and in the coverage made of them.
    std::string stencil = stencil_of(normals);
    const std::size_t seen = stencil.find(char(1), pixels / 2);
    stencil[seen] = 0;
    write(a.folder + "/stencil.raw", stencil);
    for (std::size_t c = 0; c < 4; ++c) set_word(a.folder + "/gbuffer/out/albedo.bin", 4 * seen + c, 0.0f);
    a.unlisted(coverage);
    const Json stage = a.judged(1);
    CHECK(stage["counts"]["wrong"] == 1);
    CHECK(stage["left_out"] == 0);
}
