// One exported stage that a test writes nothing to, or nonsense, and what plumb validate says of it.
#pragma once

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/program/exported.h"

namespace plumb::program {

using Catch::Matchers::Contains;

inline constexpr int width = 61, height = 43;
inline const std::string label = "compose", out_file = "/compose/out/radiance.bin", answer_file = "/compose/expected/radiance.bin";

// One stage, as `plumb export` leaves it: nothing is written yet.
inline std::string exported(const std::string& name, const Words& more = {}, const std::string& stage = "compose") {
    const std::string folder = fresh_folder(name);
    Words words = {"export", small_scene(folder), "--stage", stage, "-o", folder + "/dumps"};
    words.insert(words.end(), more.begin(), more.end());
    const Result r = run(words);
    INFO(r.out << r.err);
    REQUIRE(r.exit == 0);
    return folder + "/dumps";
}

inline Result validate(const std::string& folder, const Words& more = {}) {
    Words words = {"validate", folder + "/manifest.toml"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
}

// Exit code 1, and one line that says why: "disagree: compose: <reason>".
inline Json disagrees(const std::string& folder, const std::string& reason) {
    const Result text = validate(folder), json = validate(folder, {"--json"});
    INFO(text.out << text.err << json.err);
    CHECK(text.exit == 1);
    CHECK(json.exit == 1);
    CHECK(text.err.empty());
    CHECK_THAT(text.out, Contains("\ndisagree: " + label + ": ") && Contains(reason));
    CHECK_THAT(text.out, !Contains("\nagree"));
    const Json report = Json::parse(json.out), stage = report["stages"][0];
    CHECK(report["passed"] == false);
    CHECK(stage["passed"] == false);
    CHECK_THAT(stage["reason"].get<std::string>(), Contains(reason));
    return stage;
}

inline void check_all_unwritten(const Json& stage) {
    CHECK(stage["verdict"] == "wrong");
    CHECK(stage["unwritten"] == width * height);
    CHECK(stage["counts"]["wrong"] == width * height);
}

inline std::string floats(std::size_t count, float value) {
    std::string bytes;
    for (std::size_t i = 0; i < count; ++i) bytes.append(reinterpret_cast<const char*>(&value), 4);
    return bytes;
}

inline std::string agreeing(const Result& r) {
    INFO(r.out << r.err);
    CHECK(r.exit == 0);
    return r.out;
}

}  // namespace plumb::program
