// EXR headers that ask for more than their file has: refused before OpenEXR takes memory for it.
#include <cstring>

#include "files.h"
#include "io/image_file.h"

using namespace plumb;
using namespace plumb::io;

namespace {

std::string little(std::int64_t value) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) bytes += char(value >> 8 * i & 255);
    return bytes;
}

std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
    return name + '\0' + type + '\0' + little(std::int64_t(value.size())) + value;
}

std::string box(std::int64_t x, std::int64_t y) { return little(0) + little(0) + little(x) + little(y); }

struct Header {
    std::int64_t width = 3, height = 2;
    int compression = 0;
    std::string more{};  // attributes
    std::int64_t version = 2;
    std::string tail = std::string(16, '\0') + "\x7f";  // a table of two blocks, and no block

    // One channel of halves.
    std::string bytes() const {
        const std::string channels = std::string("Y\0\1\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0\0", 19);
        return std::string("\x76\x2f\x31\x01", 4) + little(version) + attribute("channels", "chlist", channels) +
               attribute("compression", "compression", std::string(1, char(compression))) +
               attribute("dataWindow", "box2i", box(width - 1, height - 1)) +
               attribute("displayWindow", "box2i", box(width - 1, height - 1)) +
               attribute("lineOrder", "lineOrder", std::string(1, '\0')) +
               attribute("pixelAspectRatio", "float", std::string("\0\0\x80\x3f", 4)) +
               attribute("screenWindowCenter", "v2f", std::string(8, '\0')) +
               attribute("screenWindowWidth", "float", std::string("\0\0\x80\x3f", 4)) + more + '\0' + tail;
    }
};

}  // namespace

TEST_CASE("exr: a table of offsets that points before the file gives no pixel", "[io][robustness]") {
    const Folder folder;
    // Compression by ZIP: the table has one entry, of 64 bits.
    const Header header{.compression = 3, .tail = little(-1) + little(-1) + std::string(64, '\0')};
    const std::string path = folder.put("a.exr", header.bytes());
    require_message(error_of([&] { read_picture(path); }), {"a.exr: pixels: "});
}

TEST_CASE("exr: a header that asks for more than the file has is refused", "[io][robustness]") {
    const Folder folder;
    const auto message = [&](const Header& header) {
        const std::string path = folder.put("a.exr", header.bytes());
        return error_of([&] { read_picture(path); });
    };
    // A picture whose pixels are missing, and nothing else: what is refused below is refused for its header.
    require_message(message({}), {"a.exr: pixels: "});

    const std::string long_value = std::string("note\0string\0", 12);
    require_message(message({.more = long_value + little(0x70617261)}), {"attribute note has 1885434465 bytes; 18 are left"});
    require_message(message({.more = long_value + little(-1)}), {"attribute note has 4294967295 bytes"});
    require_message(message({.more = attribute("a", "v2f", "xyz")}), {"attribute a of type v2f has 3 bytes; expected 8"});
    require_message(message({.more = attribute("preview", "preview", little(30000) + little(30000) + "abcd")}), {"preview"});
    require_message(message({.more = attribute("a", "stringvector", little(0x7fffffff) + "ab")}), {"a list of texts is cut off"});
    require_message(message({.more = attribute("a", "chlist", "RGBA")}), {"a name has no end"});
    require_message(message({.more = attribute("chunkCount", "int", little(1 << 30))}), {"a table of 1073741824 blocks is cut off"});
    require_message(message({.width = 1, .height = 500'000}), {"a table of 500000 blocks is cut off; 17 bytes are left"});
    require_message(message({.width = 2'000'000'000, .height = 2'000'000'000}), {"declares", "cannot hold"});
    // 256 lines are packed at once, of a picture of one, too.
    require_message(message({.width = 500'000, .height = 1, .compression = 9}), {"declares 128000000 pixels of 2 bytes, which"});
    require_message(message({.width = 0}), {"0 x 2 pixels of 2 bytes: expected at least one"});
    require_message(message({.compression = 10}), {"compression 10 is not known"});

    const auto tiles = [&](std::int64_t side, int mode) {
        return attribute("tiles", "tiledesc", little(side) + little(side) + char(mode));
    };
    require_message(message({.width = 700, .height = 700, .more = tiles(1, 0), .version = 0x202}), {"a table of 490000 blocks is cut off"});
    require_message(message({.width = 64, .height = 64, .more = tiles(64, 1), .version = 0x202}), {"a table of 7 blocks is cut off"});
    require_message(message({.more = tiles(0, 0), .version = 0x202}), {"tiles of no pixel"});
    require_message(message({.more = tiles(50'000, 0), .version = 0x202}), {"declares 2500000000 pixels of 2 bytes, which"});

    require_message(message({.version = 0x802}), {"deep pictures are not read"});
    require_message(message({.version = 0x1002, .tail = "a"}), {"holds several pictures"});
    require_message(message({.version = 3}), {"version 3; expected 2"});
}
