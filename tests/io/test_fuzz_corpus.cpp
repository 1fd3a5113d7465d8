// The corpus of the fuzzers (tests/fuzz) through the readers: each file is read or refused, and where the sanitizers'
// allocator counts, within ten times its honest need.
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "../fuzz/watch.h"
#include "io/file.h"

namespace fs = std::filesystem;
using namespace plumb;

namespace {

// Memory that a thread of OpenEXR takes is not a file's.
struct OneThread {
    int threads = 0, exr_threads = 0;
    OneThread() {
        OIIO::getattribute("threads", threads);
        OIIO::getattribute("exr_threads", exr_threads);
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1);
    }
    ~OneThread() {
        OIIO::attribute("threads", threads);
        OIIO::attribute("exr_threads", exr_threads);
    }
};

}  // namespace

TEST_CASE("fuzz: every file of the corpus is read or refused, within its memory", "[io][robustness]") {
    const OneThread one_thread;
    for (const fuzz::Format& format : fuzz::formats()) {
        const fs::path folder = fs::path(PLUMB_SOURCE_DIR) / "tests/fuzz/corpus" / format.name;
        std::vector<fs::path> files(fs::directory_iterator(folder), fs::directory_iterator{});
        std::sort(files.begin(), files.end());
        INFO(format.name);
        CHECK(files.size() >= 5);
        for (const fs::path& file : files) {
            INFO(file.filename().string());
            const std::vector<unsigned char> bytes = io::read_bytes(file.string());
            fuzz::Watched watched;
            REQUIRE_NOTHROW(watched = fuzz::watch(format, bytes.data(), bytes.size()));
            INFO(watched.peak << " bytes at once, where " << watched.need << " are needed");
            CHECK(watched.within);
        }
    }
}
