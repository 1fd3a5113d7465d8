// Nothing passes by absence: every way in which a renderer writes nothing, or what it wrote before, and what it gets.
#include <cmath>
#include <limits>

#include "tests/program/absence.h"

using namespace plumb::program;

namespace fs = std::filesystem;

TEST_CASE("absence: no file touched", "[program][absence]") {
    const std::string folder = exported("absence_untouched");
    check_all_unwritten(disagrees(folder, "nothing was written: "));
    CHECK_THAT(validate(folder).out, Contains("out/radiance.bin still holds what the export filled it with") &&
                                         Contains("not written"));
    // The right answer over it, and all is well.
    write_expected(folder);
    CHECK_THAT(agreeing(validate(folder)), Contains("agree: equal, to the bit"));
}

TEST_CASE("absence: no file touched, of every stage of a frame", "[program][absence]") {
    const std::string folder = exported("absence_frame", {}, "all");
    const Result r = validate(folder, {"--json"});
    CHECK(r.exit == 1);
    const Json report = Json::parse(r.out);
    REQUIRE(report["stages"].size() == 10);
    for (const Json& stage : report["stages"]) {
        INFO(stage.dump(2));
        CHECK(stage["passed"] == false);
        CHECK(stage["unwritten"] == stage["pixels"]);
        CHECK_THAT(stage["reason"].get<std::string>(), Contains("nothing was written"));
    }
}

TEST_CASE("absence: one output of several", "[program][absence]") {
    const std::string folder = exported("absence_one_of", {}, "gbuffer"), file = folder + "/gbuffer/out/albedo.bin";
    const std::string filling = read(file);
    CHECK_THAT(validate(folder).out, Contains("nothing was written: ") && Contains(" (6 of 6 outputs)"));
    write_expected(folder);
    CHECK(validate(folder).exit == 0);
    write(file, filling);
    const Result r = validate(folder);
    CHECK(r.exit == 1);
    CHECK_THAT(r.out, Contains("out/albedo.bin still holds what the export filled it with (1 of 6 outputs)"));
}

TEST_CASE("absence: a manifest that is guessed takes no answer for an output", "[program][absence]") {
    const std::string folder = exported("absence_init");
    fs::remove(folder + "/manifest.toml");
    REQUIRE(run({"validate", "--init", folder}).exit == 0);
    CHECK_THAT(read(folder + "/manifest.toml"), !Contains("expected/") && Contains("out/radiance.bin"));
    CHECK(disagrees(folder, "2623 of 2623 pixels are wrong; all that was written is NaN")["unwritten"] == 0);
    write_expected(folder);
    CHECK_THAT(agreeing(validate(folder)), Contains("agree: equal, to the bit"));
}

TEST_CASE("absence: file deleted, empty file", "[program][absence]") {
    const std::string folder = exported("absence_deleted");
    write(folder + out_file, "");
    check_all_unwritten(disagrees(folder, "out/radiance.bin is empty"));
    fs::remove(folder + out_file);
    check_all_unwritten(disagrees(folder, "out/radiance.bin is missing"));
    // Of what no export has filled that is bad input, as before.
    const std::string text = read(folder + "/manifest.toml");
    const std::size_t at = text.find("filling = "), end = text.find('\n', at) + 1;
    write(folder + "/manifest.toml", text.substr(0, at) + text.substr(end));
    CHECK(validate(folder).exit == 2);
}

TEST_CASE("absence: half the file", "[program][absence]") {
    const std::string folder = exported("absence_half"), answer = read(folder + answer_file), filling = read(folder + out_file);
    constexpr std::size_t rows = 20, bytes = rows * width * 16;
    constexpr int missing = (height - int(rows)) * width;
    SECTION("in place") { write(folder + out_file, answer.substr(0, bytes) + filling.substr(bytes)); }
    SECTION("cut off") { write(folder + out_file, answer.substr(0, bytes)); }
    const Json stage = disagrees(folder, std::to_string(missing) + " of 2623 pixels were never written, in rows 20 to 42");
    CHECK(stage["unwritten"] == missing);
    CHECK(stage["counts"]["equal"] == int(rows) * width);
    CHECK(stage["counts"]["wrong"] == missing);
}

TEST_CASE("absence: some pixels, and one channel", "[program][absence]") {
    const std::string folder = exported("absence_some"), filling = read(folder + out_file);
    std::string bytes = read(folder + answer_file);
    bytes.replace(16 * (7 * width + 30), 16, filling.substr(0, 16));
    // A texel of which some channels are written was written, and is wrong.
    bytes.replace(16 * (9 * width + 30), 4, filling.substr(0, 4));
    write(folder + out_file, bytes);
    const Json stage = disagrees(folder, "1 of 2623 pixels were never written, in row 7; 1 more is wrong");
    CHECK(stage["unwritten"] == 1);
    CHECK(stage["counts"]["wrong"] == 2);
}

TEST_CASE("absence: zeros, NaN", "[program][absence]") {
    const std::string folder = exported("absence_zeros");
    write(folder + out_file, floats(4 * width * height, 0));
    const Json zeros = disagrees(folder, "pixels are wrong; all that was written is 0");
    // What is black is equal, and does not make it any better.
    CHECK(zeros["equal"] > 0);
    CHECK(zeros["nonzero"]["equal"] == 0);
    CHECK(zeros["nonzero"]["wrong"] == 1);
    CHECK(zeros["unwritten"] == 0);
    for (const float nan : {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::quiet_NaN()}) {
        write(folder + out_file, floats(4 * width * height, nan));
        CHECK(disagrees(folder, "2623 of 2623 pixels are wrong; all that was written is NaN")["unwritten"] == 0);
    }
}

TEST_CASE("absence: an output of another format", "[program][absence]") {
    // Her manifest says halves: an untouched file is twice as large, and says so in neither case.
    const std::string folder = exported("absence_format"), text = read(folder + "/manifest.toml");
    const std::size_t out = text.find("[stage.output.radiance]");
    write(folder + "/manifest.toml", text.substr(0, out) + replaced(text.substr(out), "R32G32B32A32", "R16G16B16A16"));
    check_all_unwritten(disagrees(folder, "still holds what the export filled it with"));
}

TEST_CASE("absence: last run's output", "[program][absence]") {
    const std::string folder = exported("absence_last"), scene = folder + "/../small.toml";
    write_expected(folder);
    CHECK(validate(folder).exit == 0);
    SECTION("of the same export, after --refill") {
        CHECK_THAT(agreeing(run({"validate", "--refill", folder + "/manifest.toml"})), Contains("filled 1 output anew"));
        check_all_unwritten(disagrees(folder, "nothing was written"));
        // By no means a smaller file.
        CHECK(fs::file_size(folder + out_file) == width * height * 16);
    }
    SECTION("of an earlier export into the same folder") {
        REQUIRE(run({"export", scene, "--stage", "compose", "-o", folder}).exit == 0);
        check_all_unwritten(disagrees(folder, "nothing was written"));
    }
    SECTION("of an earlier export of another scene, copied over it") {
        const std::string old = read(folder + out_file);
        write(scene, replaced(read(scene), "position = [0, 1.97, 0]", "position = [0.2, 1.8, 0.1]"));
        REQUIRE(run({"export", scene, "--stage", "compose", "-o", folder}).exit == 0);
        write(folder + out_file, old);
        CHECK(disagrees(folder, "pixels are wrong")["unwritten"] == 0);
    }
    SECTION("by its time, which decides nothing") {
        CHECK_THAT(validate(folder).out, !Contains("is older"));
        fs::last_write_time(folder + out_file, fs::last_write_time(folder + answer_file) - std::chrono::hours(1));
        CHECK_THAT(agreeing(validate(folder)), Contains("out/radiance.bin is older than its export"));
    }
}

TEST_CASE("absence: other export's output", "[program][absence]") {
    const std::string folder = exported("absence_other"), other = exported("absence_other_b", {"--set", "tonemap.exposure=2"});
    SECTION("its filling") {
        CHECK(read(folder + out_file) != read(other + out_file));
        fs::copy_file(other + out_file, folder + out_file, fs::copy_options::overwrite_existing);
        check_all_unwritten(disagrees(folder, "out/radiance.bin holds what another export filled it with"));
    }
    SECTION("its inputs") {
        write_expected(folder);
        // As much as another export changes, and the answer to it.
        const std::string file = folder + "/compose/in/direct.bin";
        set_word(file, 4 * (20 * width + 30), word<float>(read(file), 4 * (20 * width + 30)) * 1.5f);
        const Json stage = disagrees(folder, "not what was exported: ");
        CHECK_THAT(stage["stale"].get<std::string>(), Contains("in/direct.bin has changed since"));
        CHECK_THAT(validate(folder).out, Contains("stale"));
        // Where that is meant, it is said.
        const std::string text = read(folder + "/manifest.toml");
        const std::size_t at = text.find("\"compose/in/direct.bin\" = "), end = text.find('\n', at) + 1;
        write(folder + "/manifest.toml", text.substr(0, at) + text.substr(end));
        CHECK_THAT(disagrees(folder, "1 of 2623 pixels are wrong")["stale"].get<std::string>(), Catch::Matchers::Equals(""));
    }
    SECTION("its block") {
        write_expected(folder);
        const std::string block = read(folder + "/compose/block.bin");
        write(folder + "/compose/block.bin", std::string(block.size(), '\0'));
        CHECK_THAT(disagrees(folder, "block.bin has changed since")["verdict"].get<std::string>(), Catch::Matchers::Equals("equal"));
    }
    SECTION("the answer, written over: it decides nothing, and is named") {
        write_expected(folder);
        write(folder + answer_file, "");
        CHECK_THAT(agreeing(validate(folder)), Contains("expected/radiance.bin has changed since the export"));
    }
}

TEST_CASE("absence: expected black", "[program][absence]") {
    const std::string folder = fresh_folder("absence_black"), scene = small_scene(folder), to = folder + "/dumps";
    SECTION("a uniform of 0: whatever writes black agrees") {
        REQUIRE(run({"export", scene, "--stage", "tonemap", "--set", "tonemap.exposure=0", "-o", to}).exit == 0);
    }
    SECTION("a camera that looks away: whatever clears its targets agrees") {
        write(scene, replaced(read(scene), "look_at = [0, 0.995, 0]", "look_at = [0, 0.995, 8]"));
        REQUIRE(run({"export", scene, "--stage", "gbuffer", "--no-pruning", "-o", to}).exit == 0);
    }
    SECTION("the same with reversed z, where depth is cleared to 0") {
        write(scene, "reversed_z = true\n" + replaced(read(scene), "look_at = [0, 0.995, 0]", "look_at = [0, 0.995, 8]"));
        REQUIRE(run({"export", scene, "--stage", "gbuffer", "--no-pruning", "-o", to}).exit == 0);
    }
    write_expected(to);
    const Result r = validate(to, {"--junit", folder + "/j.xml", "--html", folder + "/r.html"});
    INFO(r.out << r.err);
    CHECK(r.exit == 1);
    CHECK_THAT(r.out, Contains("all that is expected is 0, at each of its 2623 pixels: nothing to judge") &&
                          Contains("\ndisagree: nothing to judge: all that is expected is 0\n"));
    CHECK_THAT(read(folder + "/j.xml"), Contains("failures=\"1\"") && Contains("2623 pixels: equal 100 %") &&
                                            Contains("; 0 not 0</system-out>"));
    CHECK_THAT(read(folder + "/r.html"), Contains(">nothing to judge<") && Contains("Failed: nothing to judge"));
    const Json report = Json::parse(validate(to, {"--json"}).out), stage = report["stages"][0];
    CHECK(report["verdict"] == "nothing_to_judge");
    CHECK(report["passed"] == false);
    CHECK(stage["verdict"] == "nothing_to_judge");
    CHECK(stage["passed"] == false);
    CHECK(stage["nonzero"]["pixels"] == 0);
    CHECK(stage["judged"] == width * height);
    // Light where none is expected is wrong, black or not.
    for (const std::string& name : files_in(to))
        if (name.find("out/") != std::string::npos) set_word(to + "/" + name, 4 * 30, 5.0f);
    CHECK(Json::parse(validate(to, {"--json"}).out)["stages"][0]["verdict"] == "wrong");
    // And what was never written was not, black or not.
    REQUIRE(run({"validate", "--refill", to + "/manifest.toml"}).exit == 0);
    CHECK(Json::parse(validate(to, {"--json"}).out)["stages"][0]["unwritten"] == width * height);
}

TEST_CASE("absence: a black stage beside others, which decide", "[program][absence]") {
    const std::string folder = exported("absence_beside", {"--set", "tonemap.exposure=0"}, "all");
    write_expected(folder);
    const Words files = {"--junit", folder + "/j.xml"};
    CHECK_THAT(agreeing(validate(folder, files)),
               Contains("agree: equal, to the bit; nothing to judge in 1 of 10 stages") && Contains("note: tonemap: all that"));
    CHECK_THAT(read(folder + "/j.xml"), Contains("failures=\"0\"") && Contains("skipped=\"1\""));
    const Json stage = stage_of(Json::parse(validate(folder, {"--json"}).out), "compose");
    CHECK(stage["nonzero"]["pixels"] > 0);
    CHECK(stage["nonzero"]["pixels"] < stage["pixels"]);
    CHECK(stage["nonzero"]["counts"]["equal"] == stage["nonzero"]["pixels"]);
    CHECK_THAT(validate(folder).out, Contains("where not 0"));
}
