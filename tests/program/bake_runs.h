// Runs of `plumb bake` that take little time.
#pragma once

#include <catch2/catch.hpp>

#include "tests/program/program.h"

namespace plumb::program {

inline const Words few = {"--set", "probes.lightmap_size=96", "--set", "probes.receiver_rays=32", "--set", "probes.relight_rays=32",
                          "--set", "probes.count=5"};

inline Words baked(const std::string& scene, const std::string& file, const Words& more = {}) {
    Words all = {"bake", scene, "-o", file};
    all.insert(all.end(), few.begin(), few.end());
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

// Several blocks of receivers.
inline std::string scene_in(const std::string& folder) {
    const Result made = run({"make-scene", "box", "-o", folder + "/box"});
    REQUIRE(made.exit == 0);
    return folder + "/box/box.toml";
}

inline void succeed(const Words& words) {
    const Result r = run(words);
    CAPTURE(r.err, r.out);
    REQUIRE(r.exit == 0);
    REQUIRE(r.err.empty());
}

}  // namespace plumb::program
