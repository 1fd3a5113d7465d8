#include <fmt/format.h>
#include <OpenImageIO/imageio.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <limits>
#include <thread>

#include "files.h"
#include "io/image_file.h"
#include "tests/png_bytes.h"

using namespace plumb;
using namespace plumb::io;

namespace {

// Writes through OpenImageIO what io/ only reads.
template <class T>
std::string put_picture(const std::string& path, int width, int height, int channels, OIIO::TypeDesc type,
                        const std::vector<T>& values) {
    const auto output = OIIO::ImageOutput::create(path);
    REQUIRE(output);
    REQUIRE(output->open(path, OIIO::ImageSpec(width, height, channels, type)));
    REQUIRE(output->write_image(type, values.data()));
    REQUIRE(output->close());
    return path;
}

void put32(std::string& s, std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) s[at + i] = char(value >> 8 * i & 255);
}

// A 2 x 1 picture in uncompressed 32-bit DDS (Microsoft, "DDS file layout"): header of 128 bytes, then BGRA.
std::string dds() {
    std::string s(128, '\0');
    s.replace(0, 4, "DDS ");
    put32(s, 4, 124), put32(s, 8, 0x100f), put32(s, 12, 1), put32(s, 16, 2), put32(s, 20, 8);
    put32(s, 76, 32), put32(s, 80, 0x41), put32(s, 88, 32);
    put32(s, 92, 0xff0000), put32(s, 96, 0xff00), put32(s, 100, 0xff), put32(s, 104, 0xff000000u);
    put32(s, 108, 0x1000);
    return s + std::string("\x33\x66\xff\xff\x00\x00\x00\xff", 8);
}

// Two rows of two pixels; PFM's first row is the lowest.
std::string pfm() {
    const float values[] = {3, 4, 1, 2};
    return "Pf\n2 2\n-1.0\n" + std::string(reinterpret_cast<const char*>(values), sizeof values);
}

std::uint32_t bits(float x) {
    std::uint32_t b;
    std::memcpy(&b, &x, 4);
    return b;
}

// Layers of a 3 x 2 frame: RGB out of records of four floats, and a lone value.
struct Frame {
    std::vector<float> color, shadow;
    std::vector<Layer> layers;
    Frame() {
        for (int i = 0; i < 24; ++i) color.push_back(float(i) / 7);
        for (int i = 0; i < 6; ++i) shadow.push_back(float(i));
        color[0] = std::numeric_limits<float>::quiet_NaN();
        color[1] = std::numeric_limits<float>::infinity();
        color[2] = std::numeric_limits<float>::denorm_min();
        color[4] = -0.0f;
        layers = {{"color", {"R", "G", "B"}, color.data(), 4}, {"shadow.key", {"V"}, shadow.data(), 1}};
    }
};

}  // namespace

TEST_CASE("exr: every bit comes back, by layer", "[io]") {
    const Folder folder;
    const Frame frame;
    const std::string path = folder / "a.exr";
    write_exr(path, 3, 2, frame.layers);
    const FloatPicture picture = read_picture(path);
    CHECK(picture.width == 3);
    CHECK(picture.height == 2);
    CHECK(picture.channels == std::vector<std::string>{"R", "G", "B", "shadow.key.V"});
    CHECK(layer_names(picture) == std::vector<std::string>{"", "shadow.key"});
    const FloatPicture color = select_layer(picture, "", path), shadow = select_layer(picture, "shadow.key", path);
    CHECK(color.channels == std::vector<std::string>{"R", "G", "B"});
    CHECK(shadow.channels == std::vector<std::string>{"V"});
    REQUIRE(color.data.size() == 18);
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t c = 0; c < 3; ++c) CHECK(bits(color.data[3 * i + c]) == bits(frame.color[4 * i + c]));
        CHECK(bits(shadow.data[i]) == bits(frame.shadow[i]));
    }
    require_message(error_of([&] { select_layer(picture, "shadow.kye", path); }),
                    {"a.exr", "no layer \"shadow.kye\"; the nearest known one is \"shadow.key\""});
}

TEST_CASE("exr: a layer that is not the first color has its name in its channels", "[io]") {
    const Frame frame;
    const std::vector<Layer> layers = {frame.layers[1], frame.layers[0]};
    CHECK(channel_name(layers, 0, 0) == "shadow.key.V");
    CHECK(channel_name(layers, 1, 2) == "color.B");
}

TEST_CASE("pictures written more than a second apart are the same file", "[io][determinism]") {
    const Folder folder;
    const Frame frame;
    const std::uint8_t pixels[] = {1, 2, 3, 4, 5, 6};
    write_exr(folder / "a.exr", 3, 2, frame.layers);
    write_png(folder / "a.png", 2, 1, pixels);
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));
    write_exr(folder / "b.exr", 3, 2, frame.layers);
    write_png(folder / "b.png", 2, 1, pixels);
    CHECK(read_bytes(folder / "a.exr") == read_bytes(folder / "b.exr"));
    CHECK(read_bytes(folder / "a.png") == read_bytes(folder / "b.png"));
    // No year, and no name of what wrote it.
    for (const char* name : {"a.exr", "a.png"}) {
        const std::string text = read_text(folder / name);
        CHECK(text.find(":20") == std::string::npos);
        CHECK(text.find("OpenImageIO") == std::string::npos);
    }
}

TEST_CASE("png: bytes come back as n / 255", "[io]") {
    const Folder folder;
    std::vector<std::uint8_t> pixels(3 * 256);
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = std::uint8_t(i / 3);
    write_png(folder / "a.png", 256, 1, pixels.data());
    const FloatPicture picture = read_picture(folder / "a.png");
    CHECK(picture.channels == std::vector<std::string>{"R", "G", "B"});
    for (std::size_t i = 0; i < pixels.size(); ++i) CHECK(picture.data[i] == float(i / 3) / 255.0f);
}

TEST_CASE("pictures of each format arrive with the values that were written", "[io]") {
    const Folder folder;
    // Values that every format holds exactly.
    const std::vector<float> values = {0.5f, 1, 0.25f, 0, 0.75f, 1};
    for (const char* name : {"a.exr", "a.tif", "a.tiff", "a.hdr"}) {
        CAPTURE(name);
        const FloatPicture p = read_picture(put_picture(folder / name, 2, 1, 3, OIIO::TypeDesc::FLOAT, values));
        CHECK(p.data == values);
    }
    const std::vector<std::uint16_t> words = {0, 65535, 1, 2, 32768, 100};
    const FloatPicture p = read_picture(put_picture(folder / "b.png", 2, 1, 3, OIIO::TypeDesc::UINT16, words));
    CHECK(p.data[1] == 1.0f);
    CHECK(p.data[4] == 32768 / 65535.0f);
    const FloatPicture ids = read_picture(
        put_picture(folder / "c.exr", 2, 1, 1, OIIO::TypeDesc::UINT32, std::vector<std::uint32_t>{7, 16777216}));
    CHECK(ids.data == std::vector<float>{7, 16777216});

    const FloatPicture d = read_picture(folder.put("a.dds", dds()));
    CHECK(d.channels == std::vector<std::string>{"R", "G", "B", "A"});
    CHECK(d.data == std::vector<float>{1, 0x66 / 255.0f, 0x33 / 255.0f, 1, 0, 0, 0, 1});
    CHECK(read_picture(folder.put("a.pfm", pfm())).data == std::vector<float>{1, 2, 3, 4});
}

TEST_CASE("png: straight alpha stays straight", "[io]") {
    const Folder folder;
    const std::string path = folder / "a.png";
    const auto output = OIIO::ImageOutput::create(path);
    OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    REQUIRE(output->open(path, spec));
    const std::uint8_t pixel[] = {200, 100, 50, 0};
    REQUIRE(output->write_image(OIIO::TypeDesc::UINT8, pixel));
    REQUIRE(output->close());
    CHECK(read_texture(path).texels(0, 0) == (200u | 100u << 8 | 50u << 16));
}

TEST_CASE("texture: 1 x 1 and 65535 x 1, grey, and 16 bits", "[io]") {
    const Folder folder;
    using Bytes = std::vector<std::uint8_t>;
    CHECK(read_texture(put_picture(folder / "a.png", 1, 1, 1, OIIO::TypeDesc::UINT8, Bytes{7})).texels(0, 0) ==
          0xff070707u);
    const Texture wide =
        read_texture(put_picture(folder / "b.png", 65535, 1, 3, OIIO::TypeDesc::UINT8, Bytes(3 * 65535, 9)));
    CHECK(wide.texels.width == 65535);
    CHECK(wide.texels(65534, 0) == 0xff090909u);
    const Texture deep = read_texture(
        put_picture(folder / "c.png", 1, 1, 1, OIIO::TypeDesc::UINT16, std::vector<std::uint16_t>{128 * 257}));
    CHECK(deep.texels(0, 0) == 0xff808080u);
    CHECK(deep.srgb);
    const Texture linear =
        read_texture(put_picture(folder / "d.exr", 1, 1, 3, OIIO::TypeDesc::FLOAT, std::vector<float>{0, 1, 0.5f}));
    CHECK(!linear.srgb);
    CHECK(linear.texels(0, 0) == 0xff80ff00u);
}

TEST_CASE("texture: values outside 0 to 1, and wrong channels, are errors that name the pixel", "[io][robustness]") {
    const Folder folder;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const auto put = [&](std::vector<float> v) {
        return put_picture(folder / "a.exr", 2, 2, 3, OIIO::TypeDesc::FLOAT, v);
    };
    std::vector<float> v(12, 0.5f);
    v[10] = nan;
    require_message(error_of([&] { read_texture(put(v)); }),
                    {"a.exr: pixel 1,1: G = nan; a texture's values lie in 0 to 1"});
    CHECK(std::isnan(read_picture(folder / "a.exr").data[10]));  // a picture may hold it
    v[10] = 1.5f;
    require_message(error_of([&] { read_texture(put(v)); }), {"pixel 1,1: G = 1.5"});
    const std::string five =
        put_picture(folder / "b.tif", 1, 1, 5, OIIO::TypeDesc::UINT8, std::vector<std::uint8_t>(5));
    require_message(error_of([&] { read_texture(five); }), {"b.tif: header: 5 channels; expected 1 to 4"});
}

TEST_CASE("picture: malformed files are named with the cause", "[io][robustness]") {
    const Folder folder;
    const auto read = [&](const std::string& name, const std::string& content) {
        const std::string path = folder.put(name, content);
        return error_of([&] { read_picture(path); });
    };
    const Frame frame;
    write_exr(folder / "good.exr", 3, 2, frame.layers);
    const std::string exr = read_text(folder / "good.exr");

    require_message(error_of([&] { read_picture(folder / "none.exr"); }), {"none.exr: cannot be read: No such file"});
    require_message(read("a.exr", ""), {"a.exr: is empty; expected a picture"});
    require_message(read("a.txt", "x"), {"a.txt: not a picture by its name; expected one of .exr, .pfm"});
    require_message(read("a.exr", "hello"), {"a.exr: byte 0: does not begin as a .exr file does"});
    require_message(read("a.png", exr), {"a.png: byte 0: does not begin as a .png file does"});
    require_message(read("a.exr", exr.substr(0, 100)), {"a.exr: header: "});
    require_message(read("a.exr", exr.substr(0, exr.size() - 20)), {"a.exr: "});
    require_message(read("a.pfm", "Pf\n0 0\n-1.0\n"), {"a.pfm: header"});
    require_message(read("a.pfm", "Pf\n-3 2\n-1.0\n"), {"a.pfm: header"});
    require_message(read("a.pfm", "Pf\n40000 40000\n-1.0\nabcd"),
                    {"a.pfm: header: declares 40000 x 40000", "cannot hold"});
    require_message(read("a.pfm", "Pf\n2000000000 2\n-1.0\nabcd"),
                    {"a.pfm: header: 2000000000 x 2", "limits are 2^31 pixels"});
    require_message(read("a.pfm", pfm().substr(0, pfm().size() - 1)), {"a.pfm: pixels"});
    require_message(read("a.dds", dds().substr(0, 130)), {"a.dds: "});
    // Colours that alpha multiplies; OpenImageIO 2.4 divides by an alpha of 0.
    std::string multiplied = dds() + std::string(8, '\0');
    put32(multiplied, 80, 4), multiplied.replace(84, 4, "DXT2");
    require_message(read("a.dds", multiplied), {"a.dds: header: is packed as DXT2"});
    std::string huge = dds();
    put32(huge, 12, 1 << 24);
    require_message(read("a.dds", huge), {"a.dds: header: declares 2 x 16777216 pixels, which 136 bytes cannot hold"});
    std::string bmp = "BM" + std::string(24, '\0');
    put32(bmp, 14, 40), put32(bmp, 18, 1), put32(bmp, 22, 7 << 24);
    require_message(read("a.bmp", bmp), {"a.bmp: header: declares 1 x 117440512 pixels, which 26 bytes cannot hold"});

    const std::uint8_t pixel[] = {1, 2, 3};
    write_png(folder / "good.png", 1, 1, pixel);
    const std::string png = read_text(folder / "good.png");
    require_message(read("a.png", png.substr(0, 40)), {"a.png: byte 33: the picture is cut off here"});
    require_message(read("a.png", png.substr(0, 20) + "x" + png.substr(21)),
                    {"a.png: byte 8: the checksum of chunk IHDR is wrong"});

    // A JPEG without its end.
    put_picture(folder / "good.jpg", 16, 16, 3, OIIO::TypeDesc::UINT8, std::vector<std::uint8_t>(768, 99));
    const std::string jpg = read_text(folder / "good.jpg");
    require_message(read("a.jpg", jpg.substr(0, jpg.size() - 3)), {"a.jpg: "});
}

TEST_CASE("png: what decoding finds amiss is named", "[io][robustness]") {
    const Folder folder;
    for (const auto& [kind, bytes, message] : png_bytes::bad_pngs()) {
        INFO(kind);
        const std::string path = folder.put("a.png", bytes);
        require_message(error_of([&] { read_picture(path); }), {"a.png: PNG: ", message});
    }
}

TEST_CASE("png: palettes, transparency, passes and further chunks are read", "[io]") {
    using namespace png_bytes;
    const Folder folder;
    const auto texel = [&](const std::string& chunks, int x, int y) {
        return read_texture(folder.put("a.png", png(chunks))).texels(x, y);
    };
    // Two indices of 4 bits a row: 1 0, 0 1. The colours are (1, 2, 3), and (4, 5, 6) with alpha 7.
    const std::string palette = chunk("PLTE", "\1\2\3\4\5\6"), rows = data(std::string("\0\x10\0\1", 4));
    const std::string head = header(2, 2, 4, 3), alpha = chunk("tRNS", "\xff\7");
    CHECK(texel(head + palette + rows, 0, 0) == 0xff060504u);
    CHECK(texel(head + palette + rows, 0, 1) == 0xff030201u);
    CHECK(texel(head + palette + alpha + rows, 0, 0) == 0x07060504u);
    CHECK(texel(head + palette + alpha + rows, 1, 0) == 0xff030201u);
    // Of Adam7's passes (ISO 15948, 8.2) a 2 x 2 picture has three: pixel 0,0; pixel 1,0; row 1.
    const std::string passes = data(std::string("\0\1\0\2\0\3\4", 7));
    for (int i = 0; i < 4; ++i)
        CHECK(texel(header(2, 2, 8, 0, 1) + passes, i % 2, i / 2) == 0xff000000u + 0x10101u * unsigned(i + 1));
    // What libpng only warns of is passed over.
    CHECK(texel(head + chunk("gAMA", std::string(4, '\0')) + chunk("iCCP", "x") + palette + rows, 1, 1) == 0xff060504u);
}

TEST_CASE("picture: what cannot be written is one line, and nothing is left", "[io][robustness]") {
    const Folder folder;
    const Frame frame;
    const std::uint8_t pixel[] = {1, 2, 3};
    require_message(error_of([&] { write_exr(folder / "none/a.exr", 3, 2, frame.layers); }),
                    {"none/a.exr: cannot be written: No such"});
    require_message(error_of([&] { write_exr(folder / "a.exr", 0, 2, frame.layers); }),
                    {"a.exr: cannot be written: 0 x 2"});
    require_message(error_of([&] { write_exr(folder / "a.exr", 3, 2, {}); }),
                    {"a.exr: cannot be written: 3 x 2 pixels of 0"});
    require_message(error_of([&] { write_exr(folder / "a.exr", 1 << 20, 1 << 20, frame.layers); }), {"limits"});
    require_message(error_of([&] {
                        write_exr(folder / "a.exr", 3, 2, {frame.layers[1], frame.layers[1]});
                    }),
                    {"channel \"shadow.key.V\" is named twice"});
    require_message(error_of([&] { write_png(folder / "a.png", 0, 1, pixel); }), {"a.png: cannot be written"});
    CHECK(folder.files() == 0);

    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before;
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{100, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    const std::string message = error_of([&] { write_exr(folder / "a.exr", 3, 2, frame.layers); });
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, SIG_DFL);
    require_message(message, {"a.exr: cannot be written: File too large"});
    CHECK(folder.files() == 0);
}

TEST_CASE("picture: cut off or changed at any byte, it loads or is refused", "[io][robustness]") {
    const Folder folder;
    const Frame frame;
    const std::uint8_t pixels[] = {1, 2, 3, 4, 5, 6};
    write_exr(folder / "a.exr", 3, 2, frame.layers);
    write_png(folder / "a.png", 2, 1, pixels);
    const std::vector<float> values = {0.5f, 1, 0.25f, 0, 0.75f, 1};
    put_picture(folder / "a.hdr", 2, 1, 3, OIIO::TypeDesc::FLOAT, values);
    put_picture(folder / "a.tif", 2, 1, 3, OIIO::TypeDesc::FLOAT, values);
    folder.put("a.pfm", pfm());
    folder.put("a.dds", dds());
    for (const char* name : {"a.exr", "a.png", "a.hdr", "a.tif", "a.pfm", "a.dds"}) {
        CAPTURE(name);
        const std::string content = read_text(folder / name);
        load_damaged(folder, name, content, [](const std::string& path) { read_picture(path); });
        // What was cut off by more than a mark at the end is not taken for a picture.
        folder.put(name, content.substr(0, content.size() / 2));
        CHECK(error_of([&] { read_picture(folder / name); }) != "");
    }
}
