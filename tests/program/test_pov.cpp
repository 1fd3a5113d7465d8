// plumb pov.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "io/image_file.h"
#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;
using Catch::Matchers::StartsWith;

namespace {

// The one line of a refusal, which leaves nothing behind.
std::string refused(const Words& words, const std::string& folder) {
    const Words before = files_in(folder);
    const Result r = run(words);
    INFO(r.out << r.err);
    CHECK(r.exit == 2);
    CHECK(r.out.empty());
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK(files_in(folder) == before);
    return r.err;
}

}  // namespace

TEST_CASE("pov: a script, and the command that renders it", "[program]") {
    const std::string folder = fresh_folder("pov"), scene = small_scene(folder);
    const Result r = run({"pov", scene, "-o", folder + "/a b/small.pov", "--size", "20x15", "--preset", "direct", "--json"});
    INFO(r.out << r.err);
    REQUIRE(r.exit == 0);
    CHECK(r.err.empty());
    const Json json = Json::parse(r.out);
    CHECK(keys(json) == Words{"script", "picture", "command", "notes"});
    CHECK(json["script"] == folder + "/a b/small.pov");
    CHECK(json["picture"] == folder + "/a b/small.exr");
    CHECK(json["command"].size() == 9);
    const std::string text = read(folder + "/a b/small.pov");
    CHECK_THAT(text, StartsWith("#version 3.7;") && Contains("spotlight") && Contains("parallel") && !Contains("radiosity {"));
    // "lamp" is off.
    CHECK_THAT(text, Contains("// light key") && Contains("// light sun") && !Contains("// light lamp"));

    const Result words = run({"pov", scene, "-o", folder + "/b.pov", "--preset", "published"});
    REQUIRE(words.exit == 0);
    const std::string line = "povray +I" + folder + "/b.pov +O" + folder + "/b.exr +FE +W61 +H43 -A -D +WT1\n";
    CHECK_THAT(words.out, Contains(line) && Contains("wrote " + folder + "/b.pov") && Contains("not physical"));
    CHECK_THAT(read(folder + "/b.pov"), Contains("brightness 2.4"));
    REQUIRE(run({"pov", scene, "-o", folder + "/c.pov", "--bounces", "3", "--samples", "99"}).exit == 0);
    CHECK_THAT(read(folder + "/c.pov"), Contains("recursion_limit 3") && Contains("count 99"));

    if (std::system("command -v povray > /dev/null 2>&1") != 0) {
        std::cout << "SKIPPED: no povray here (Debian's package povray; tools/install-deps)\n";
        return;
    }
    // As printed, by a shell.
    const Result direct = run({"pov", scene, "-o", folder + "/a b/small.pov", "--size", "20x15", "--preset", "direct"});
    REQUIRE(direct.exit == 0);
    const std::size_t at = direct.out.find("povray +I");
    const std::size_t quoted = direct.out.find("povray '+I");
    const std::string command = direct.out.substr(std::min(at, quoted));
    INFO(command);
    REQUIRE(std::system((command.substr(0, command.find('\n')) + " > /dev/null 2>&1").c_str()) == 0);
    const plumb::compare::Picture picture = plumb::io::read_picture(folder + "/a b/small.exr");
    CHECK((picture.width == 20 && picture.height == 15));
    double sum = 0;
    for (const float value : picture.data) sum += value;
    CHECK(sum > 0);
}

// Direct light of the Cornell box, ours and POV-Ray's, pixel by pixel: shadows of maps and of rays differ along edges.
TEST_CASE("pov: POV-Ray's direct light is ours", "[program][povray]") {
    if (std::system("command -v povray > /dev/null 2>&1") != 0) {
        std::cout << "SKIPPED: no povray here (Debian's package povray; tools/install-deps)\n";
        return;
    }
    const std::string folder = fresh_folder("pov_direct"), scene = small_scene(folder);
    std::string text = read(scene);
    for (const char* size : {"rsm_size = 48", "rsm_size = 32"}) text.replace(text.find(size), 13, "rsm_size = 2048");
    write(scene, text);
    render(scene, folder + "/ours", {"--method", "direct"});
    REQUIRE(run({"pov", scene, "-o", folder + "/p.pov", "--preset", "direct"}).exit == 0);
    const std::string command =
        "povray +I" + folder + "/p.pov +O" + folder + "/p.exr +FE +W61 +H43 -A -D +WT1 > /dev/null 2>&1";
    REQUIRE(std::system(command.c_str()) == 0);
    const plumb::compare::Picture theirs = plumb::io::read_picture(folder + "/p.exr");
    const plumb::compare::Picture all = plumb::io::read_picture(folder + "/ours/small.exr");
    std::size_t same = 0, pixels = 0;
    REQUIRE((all.width == theirs.width && all.height == theirs.height));
    for (int i = 0; i < all.width * all.height; ++i) {
        bool close = true;
        for (int c = 0; c < 3; ++c) {
            const double a = all.data[std::size_t(i) * all.channels.size() + std::size_t(c)];
            const double b = theirs.data[std::size_t(i) * theirs.channels.size() + std::size_t(c)];
            close = close && std::abs(a - b) <= 0.002 * std::max(std::abs(a), std::abs(b)) + 1e-5;
        }
        same += close, ++pixels;
    }
    INFO(same << " of " << pixels);
    CHECK(same > pixels * 9 / 10);
}

TEST_CASE("pov: what cannot be is refused, and nothing is written", "[program]") {
    const std::string folder = fresh_folder("pov_refused"), scene = small_scene(folder);
    const std::string out = folder + "/x.pov";
    CHECK_THAT(refused({"pov", scene, "-o", out, "--preset", "nice"}, folder), Contains("--preset nice: expected published"));
    for (const char* size : {"12", "0x5", "5x0", "5x5x5", "-1x5", "70000x5", "axb"})
        CHECK_THAT(refused({"pov", scene, "-o", out, "--size", size}, folder), Contains("--size") && Contains(size));
    CHECK_THAT(refused({"pov", scene, "-o", out, "--bounces", "21"}, folder), Contains("--bounces"));
    CHECK_THAT(refused({"pov", scene, "-o", out, "--samples", "nan"}, folder), Contains("--samples"));
    CHECK_THAT(refused({"pov", folder + "/no.toml", "-o", out}, folder), Contains("no.toml"));
    CHECK_THAT(refused({"pov", scene, "-o", scene + "/x.pov"}, folder), Contains(scene));
    write(folder + "/ends.toml", read(scene).replace(read(scene).find("[[light]]"), 9, "[[light]]\nradius = 2"));
    write(folder + "/bad.toml", read(scene).replace(read(scene).find("[[light]]"), 9, "[[light]]\nradius = -2"));
    CHECK_THAT(refused({"pov", folder + "/bad.toml", "-o", out}, folder), Contains("radius"));
    // A light that ends at its radius is shown, and said to be a sum of fadings; without shadows where that is asked for.
    const Result ends = run({"pov", folder + "/ends.toml", "-o", out, "--shadowless"});
    INFO(ends.out << ends.err);
    REQUIRE(ends.exit == 0);
    CHECK_THAT(ends.out, Contains("end at a radius"));
    CHECK_THAT(read(out), Contains("fade_power 13.796") && Contains("  shadowless"));
}
