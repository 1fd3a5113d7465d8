// Dumps in files: pictures, DDS, NumPy's arrays, large ones, and files that are not what they are said to be.
#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <cstring>

#include "dumps.h"
#include "io/image_file.h"
#include "io/npy.h"
#include "io/random_file.h"
#include "tests/png_bytes.h"

using namespace plumb;
using namespace plumb::io;

namespace {

// Through OpenImageIO.
void put_picture(const std::string& path, int width, int height, const std::vector<std::string>& channels,
                 const std::vector<OIIO::TypeDesc>& types, const std::string& pixels) {
    const auto output = OIIO::ImageOutput::create(path);
    REQUIRE(output);
    OIIO::ImageSpec spec(width, height, int(channels.size()), types[0]);
    spec.channelnames = channels;
    if (types.size() > 1) spec.channelformats = types;
    spec.attribute("oiio:ColorSpace", "Linear");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    REQUIRE(output->open(path, spec));
    REQUIRE(output->write_image(types.size() > 1 ? OIIO::TypeDesc::UNKNOWN : types[0], pixels.data()));
    REQUIRE(output->close());
}

// A DDS header (Microsoft, "DDS file layout"), of DX10 if `dxgi` is given.
std::string dds_header(int width, int height, std::uint32_t dxgi, std::uint32_t code = 0) {
    std::string s(dxgi ? 148 : 128, '\0');
    const auto put = [&](std::size_t at, std::uint32_t value) { std::memcpy(s.data() + at, &value, 4); };
    s.replace(0, 4, "DDS ");
    put(4, 124), put(8, 0x1007), put(12, std::uint32_t(height)), put(16, std::uint32_t(width)), put(76, 32),
        put(108, 0x1000);
    put(80, dxgi || code ? 4 : 0x41);
    if (dxgi) {
        s.replace(84, 4, "DX10");
        put(128, dxgi), put(132, 3), put(140, 1);
    } else if (code) {
        put(84, code);
    } else {
        put(88, 32), put(92, 0xff0000), put(96, 0xff00), put(100, 0xff), put(104, 0xff000000u);
    }
    return s;
}

}  // namespace

using OIIO::TypeDesc;

TEST_CASE("dump files: layers of an EXR, by the names of their channels", "[io][dump]") {
    const Folder folder;
    // Halves and floats side by side, in OpenEXR's order of names; two pixels.
    const std::vector<std::string> names = {"R", "G", "B", "A", "depth.V", "id.I", "normal.X", "normal.Y", "normal.Z"};
    std::vector<TypeDesc> types(4, TypeDesc::HALF);
    types.insert(types.end(), {TypeDesc::FLOAT, TypeDesc::UINT32, TypeDesc::FLOAT, TypeDesc::FLOAT, TypeDesc::FLOAT});
    std::string pixels;
    for (int i = 0; i < 2; ++i)
        pixels += bytes_of<std::uint16_t>({0x3c00, 0x4000, 0x4200, 0x4400}) + bytes_of<float>({7.5f}) +
                  bytes_of<std::uint32_t>({16777217u + std::uint32_t(i)}) + bytes_of<float>({0.25f, -0.5f, 0.1f});
    put_picture(folder / "a.exr", 2, 1, names, types, pixels);

    DumpSpec spec = picture(folder / "a.exr");
    const DumpedImage color = read_dump(spec);
    CHECK(color.array.shape == Shape{1, 2, 4});
    require_values(floats(color), {1, 2, 3, 4, 1, 2, 3, 4});
    CHECK(color.stored == Format::rgba16f);
    CHECK(color.channels == 15);
    spec.channels = "w";  // flux in another image's alpha
    require_values(floats(read_dump(spec)), {4, 0, 0, 1, 4, 0, 0, 1});
    spec.channels = "", spec.layer = "normal";
    const DumpedImage normal = read_dump(spec);
    require_values(floats(normal), {0.25f, -0.5f, 0.1f, 1, 0.25f, -0.5f, 0.1f, 1});
    CHECK(normal.stored == Format::rgba32f);
    CHECK(normal.channels == 7);
    spec.layer = "depth";
    require_values(floats(read_dump(spec)), {7.5f, 0, 0, 1, 7.5f, 0, 0, 1});
    spec.layer = "id";  // no float holds it
    CHECK(integers(read_dump(spec)) == std::vector<std::int32_t>{16777217, 16777218});
    spec.layer = "nromal";
    require_message(error_of([&] { read_dump(spec); }),
                    {"a.exr: has no layer \"nromal\"; the nearest known one is \"normal\"", "m.toml: line 7"});
    spec.layer = "depth", spec.channels = "y";
    require_message(error_of([&] { read_dump(spec); }), {"a.exr: channels: \"y\": the file has 1 channel"});
    spec.channels = "", spec.width = 3, spec.height = 1;
    require_message(error_of([&] { read_dump(spec); }), {"a.exr: size: is 2 x 1; expected 3 x 1"});
}

TEST_CASE("dump files: what this program writes as EXR comes back to the bit", "[io][dump]") {
    const Folder folder;
    const std::vector<float> values = {1, -0.0f, 1e-40f, 4, 5, 6, 7, std::numeric_limits<float>::infinity()};
    write_exr(folder / "a.exr", 2, 1, {{"position", {"X", "Y", "Z"}, values.data(), 4}});
    DumpSpec spec = picture(folder / "a.exr");
    spec.layer = "position";
    require_values(floats(read_dump(spec)), {1, -0.0f, 1e-40f, 1, 5, 6, 7, 1});
}

TEST_CASE("dump files: an EXR with too many channels asks for a layer", "[io][dump]") {
    const Folder folder;
    put_picture(folder / "a.exr", 1, 1, {"a", "b", "c", "d", "e"}, {TypeDesc::FLOAT}, bytes_of<float>({1, 2, 3, 4, 5}));
    require_message(error_of([&] { read_dump(picture(folder / "a.exr")); }), {"a.exr: layer \"\" has 5 channels"});
}

TEST_CASE("dump files: TIFF, PNG, HDR and PFM arrive with the values that were written", "[io][dump]") {
    const Folder folder;
    const std::vector<std::string> rgb = {"R", "G", "B"}, rgba = {"R", "G", "B", "A"};
    put_picture(folder / "f.tif", 1, 1, rgb, {TypeDesc::FLOAT}, bytes_of<float>({-1, 0.1f, 1e9f}));
    require_values(floats(read_dump(picture(folder / "f.tif"))), {-1, 0.1f, 1e9f, 1});
    put_picture(folder / "h.tiff", 1, 1, rgb, {TypeDesc::HALF}, bytes_of<std::uint16_t>({0x3c00, 0xc000, 0x0001}));
    require_values(floats(read_dump(picture(folder / "h.tiff"))), {1, -2, 0x1p-24f, 1});

    // 16 bits are divided once, in double.
    const std::string words = bytes_of<std::uint16_t>({1, 32769, 65535, 257});
    const std::vector<float> expected = {float(1 / 65535.0), float(32769 / 65535.0), 1, float(257 / 65535.0)};
    for (const char* name : {"w.tif", "w.png"}) {
        CAPTURE(name);
        put_picture(folder / name, 1, 1, rgba, {TypeDesc::UINT16}, words);
        const DumpedImage image = read_dump(picture(folder / name));
        require_values(floats(image), expected);
        CHECK(image.rounding.shape == Shape{1, 1, 4});
        CHECK(image.highest == 1);
        // Numbers that stand for no colour.
        DumpSpec ids = picture(folder / name);
        ids.encoding = "integer", ids.channels = "xy";
        CHECK(integers(read_dump(ids)) == std::vector<std::int32_t>{1, 32769});
    }
    put_picture(folder / "b.png", 1, 1, rgba, {TypeDesc::UINT8}, bytes_of<std::uint8_t>({0, 51, 255, 128}));
    const DumpedImage bytes = read_dump(picture(folder / "b.png"));
    require_values(floats(bytes), {0, 0.2f, 1, float(128 / 255.0)});  // stays encoded
    CHECK(bytes.stored == Format::rgba8);
    DumpSpec decoded = picture(folder / "b.png");
    decoded.encoding = "srgb";
    CHECK(floats(read_dump(decoded))[1] == Approx(0.033104767).epsilon(1e-6));  // ((0.2 + 0.055) / 1.055)^2.4
    CHECK(floats(read_dump(decoded))[3] == float(128 / 255.0));

    put_picture(folder / "a.hdr", 1, 1, rgb, {TypeDesc::FLOAT}, bytes_of<float>({0.5f, 1, 0.25f}));
    const DumpedImage hdr = read_dump(picture(folder / "a.hdr"));
    require_values(floats(hdr), {0.5f, 1, 0.25f, 1});
    CHECK(hdr.stored == Format::rgbe);

    // PFM's first row is the lowest.
    const std::string pfm = "Pf\n1 2\n-1.0\n" + bytes_of<float>({3, 4});
    DumpSpec grey = picture(folder.put("a.pfm", pfm));
    require_values(floats(read_dump(grey)), {4, 0, 0, 1, 3, 0, 0, 1});
    grey.flip_y = true;
    require_values(floats(read_dump(grey)), {3, 0, 0, 1, 4, 0, 0, 1});
}

TEST_CASE("dump files: DDS of every kind of header", "[io][dump]") {
    const Folder folder;
    const auto read = [&](const std::string& bytes) { return read_dump(picture(folder.put("a.dds", bytes))); };
    require_values(floats(read(dds_header(1, 2, 0) + "\x33\x66\xff\xff" + std::string("\0\0\0\0", 4))),
                   {1, 0.4f, 0.2f, 1, 0, 0, 0, 0});
    const std::string halves = bytes_of<std::uint16_t>({0x3c00, 0xc000, 0x4200, 0x4400});
    require_values(floats(read(dds_header(1, 1, 10) + halves)), {1, -2, 3, 4});
    require_values(floats(read(dds_header(1, 1, 0, 113) + halves)), {1, -2, 3, 4});
    CHECK(read(dds_header(1, 1, 10) + halves).stored == Format::rgba16f);
    require_values(floats(read(dds_header(1, 1, 40) + bytes_of<float>({0.5f}))), {0.5f, 0, 0, 1});
    CHECK(integers(read(dds_header(1, 1, 42) + bytes_of<std::uint32_t>({9}))) == std::vector<std::int32_t>{9});
    // D32 S8X24: the second word is no depth.
    const DumpedImage depth = read(dds_header(1, 1, 20) + bytes_of<float>({0.5f, 1e9f}));
    CHECK(depth.channels == 1);
    // Smaller pictures may follow the first.
    std::string mips = dds_header(2, 1, 41);
    mips[28] = 2;
    require_values(floats(read(mips + bytes_of<float>({1, 2, 1.5f}))), {1, 0, 0, 1, 2, 0, 0, 1});
    // Five bits of red go to OpenImageIO.
    std::string rgb565 = dds_header(1, 1, 0);
    const std::uint32_t masks[] = {16, 0xf800, 0x07e0, 0x001f, 0};
    std::memcpy(rgb565.data() + 88, masks, sizeof masks), rgb565[80] = 0x40;
    CHECK(floats(read(rgb565 + std::string("\x00\xf8", 2)))[0] == 1);

    require_message(error_of([&] { read(dds_header(1, 1, 71) + "12345678"); }),
                    {"a.dds: DXGI_FORMAT 71", "compressed", "m.toml: line 7"});
    require_message(error_of([&] { read(dds_header(1, 1, 9) + halves); }),
                    {"DXGI_FORMAT 9", "typeless", "offset = 148"});
    require_message(error_of([&] { read(dds_header(0, 1, 10)); }), {"0 x 1 pixels"});
    require_message(error_of([&] { read(dds_header(40000, 1, 10)); }), {"40000 x 1 pixels"});
    require_message(error_of([&] { read(dds_header(2, 1, 10) + halves); }),
                    {"a.dds: has 156 bytes", "end at byte 164"});
    require_message(error_of([&] { read(dds_header(1, 1, 10) + halves + "x"); }), {"a.dds: has 157 bytes"});
    std::string cube = dds_header(1, 1, 10);
    cube[136] = 4;
    require_message(error_of([&] { read(cube + halves); }), {"cube"});
    std::string volume = dds_header(1, 1, 0);
    volume[114] = 0x20;
    require_message(error_of([&] { read(volume + "1234"); }), {"volume"});
    std::string array = dds_header(1, 1, 10);
    array[140] = 2;
    require_message(error_of([&] { read(array + halves + halves); }), {"several pictures"});
}

TEST_CASE("dump files: arrays of NumPy, as buffers and as images", "[io][dump]") {
    const Folder folder;
    const auto put = [&](DType type, const Shape& shape, const std::string& data) {
        write_npy(folder / "a.npy", type, shape, data.data());
        return picture(folder / "a.npy");
    };
    const std::string six = bytes_of<float>({1, 2, 3, 4, 5, 6});
    // By itself it is a buffer, of its own shape.
    DumpSpec spec = put(DType::f32, {1, 2, 3}, six);
    CHECK(read_dump(spec).array.shape == Shape{1, 2, 3});
    require_values(floats(read_dump(spec)), {1, 2, 3, 4, 5, 6});
    CHECK(read_dump(spec).channels == 1);
    // With a size, channels or an encoding it is an image.
    spec.width = 2, spec.height = 1;
    require_values(floats(read_dump(spec)), {1, 2, 3, 1, 4, 5, 6, 1});
    CHECK(read_dump(spec).channels == 7);
    spec.width = 0, spec.height = 0, spec.channels = "z";
    require_values(floats(read_dump(spec)), {3, 0, 0, 1, 6, 0, 0, 1});
    spec = put(DType::f32, {2, 3}, six), spec.flip_y = true;
    require_values(floats(read_dump(spec)), {4, 0, 0, 1, 5, 0, 0, 1, 6, 0, 0, 1, 1, 0, 0, 1, 2, 0, 0, 1, 3, 0, 0, 1});
    spec.flip_y = false, spec.width = 2, spec.height = 3;
    require_message(error_of([&] { read_dump(spec); }), {"a.npy: size: is 3 x 2; expected 2 x 3"});

    require_values(floats(read_dump(put(DType::f64, {2}, bytes_of<double>({0.1, 1e300})))),
                   {0.1f, std::numeric_limits<float>::infinity()});
    const DumpedImage halves = read_dump(put(DType::f16, {2}, bytes_of<std::uint16_t>({0x3c00, 0xc000})));
    require_values(floats(halves), {1, -2});
    CHECK(halves.stored == Format::rgba16f);
    CHECK(integers(read_dump(put(DType::i32, {2}, bytes_of<std::int32_t>({-5, 6})))) ==
          std::vector<std::int32_t>{-5, 6});
    CHECK(integers(read_dump(put(DType::u32, {1}, bytes_of<std::uint32_t>({4294967295u})))) ==
          std::vector<std::int32_t>{-1});
    CHECK(integers(read_dump(put(DType::u8, {2}, "\x01\xff"))) == std::vector<std::int32_t>{1, 255});
    CHECK(integers(read_dump(put(DType::u16, {1}, "\xff\xff"))) == std::vector<std::int32_t>{65535});
    CHECK(read_dump(put(DType::f32, {}, six)).array.shape == Shape{});

    require_message(error_of([&] {
                        read_dump(put(DType::f32, {0, 4}, ""));
                    }),
                    {"a.npy: shape [0, 4]", "m.toml: line 7"});
    spec = put(DType::f32, {1, 1, 6}, six), spec.channels = "x";
    require_message(error_of([&] { read_dump(spec); }), {"a.npy: shape [1, 1, 6]: expected an image"});
    spec = put(DType::i32, {1, 3, 2}, six), spec.encoding = "octahedral";
    require_message(error_of([&] { read_dump(spec); }), {"a.npy: encoding: the file holds integers"});
    spec = put(DType::f32, {1, 6}, six), spec.encoding = "integer";
    require_message(error_of([&] { read_dump(spec); }), {"a.npy: encoding: the file does not hold integers"});
    spec = put(DType::f32, {1, 6}, six), spec.encoding = "octahedral";
    require_message(error_of([&] { read_dump(spec); }),
                    {"a.npy: encoding: octahedral takes 2 channels; the file has 1"});
}

TEST_CASE("dump files: a window far inside a file of 12 GB costs no memory", "[io][dump]") {
    const Folder folder;
    const std::int64_t size = std::int64_t(12) << 30, pitch = std::int64_t(1) << 30, offset = std::int64_t(5) << 30;
    const std::string path = folder.put("big.raw", "");
    std::error_code no_room;
    std::filesystem::resize_file(path, std::uintmax_t(size), no_room);  // holes, no blocks
    if (no_room) {
        WARN("the file system has no room for a file with holes: " << no_room.message());
        return;
    }
    {
        std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
        for (int y = 0; y < 4; ++y)
            file.seekp(offset + y * pitch).write(bytes_of({float(y + 1), float(10 * y)}).data(), 8);
    }
    DumpSpec spec = raw(path, "R32_SFLOAT", 2, 4);
    spec.offset = offset, spec.row_pitch = pitch, spec.trailing = true;
    require_values(floats(read_dump(spec)),
                   {1, 0, 0, 1, 0, 0, 0, 1, 2, 0, 0, 1, 10, 0, 0, 1, 3, 0, 0, 1, 20, 0, 0, 1, 4, 0, 0, 1, 30, 0, 0, 1});
    // Without the offset's four gigabytes: no 32 bits anywhere.
    spec.offset = 0;
    CHECK(floats(read_dump(spec))[0] == 0);
    // More than an image may have.
    const DumpSpec large = raw(path, "R8_UNORM", 32767, 32767);
    DumpSpec trailing = large;
    trailing.trailing = true;
    require_message(error_of([&] { read_dump(trailing); }), {"big.raw: size: 32767 x 32767 texels; the limit is 2^28"});
}

TEST_CASE("dump files: a file that is cut while it is read is an error", "[io][dump][robustness]") {
    const Folder folder;
    const std::string path = folder.put("a.raw", std::string(100, 'x'));
    const RandomFile file(path);
    CHECK(file.size() == 100);
    char bytes[10];
    file.read(90, 10, bytes);
    std::filesystem::resize_file(path, 95);
    require_message(error_of([&] { file.read(90, 10, bytes); }),
                    {"a.raw: byte 95: the file was cut while it was read"});
}

TEST_CASE("dump files: raw files that are not as they are described", "[io][dump][robustness]") {
    const Folder folder;
    const std::string path = folder.put("a.raw", std::string(64, '\0'));
    std::filesystem::create_directory(folder / "sub.raw");
    const std::int64_t max = std::numeric_limits<std::int64_t>::max();
    const auto with = [&](auto change) {
        DumpSpec spec = raw(path, "R32G32B32A32_SFLOAT", 2, 2);
        change(spec);
        return spec;
    };
    const std::vector<std::pair<DumpSpec, std::vector<std::string>>> cases = {
        {with([](DumpSpec& s) { s.height = 3; }),
         {"a.raw: has 64 bytes", "2 x 3 texels", "end at byte 96", "m.toml: line 7"}},
        {with([](DumpSpec& s) { s.width = 1; }), {"a.raw: has 64 bytes", "end at byte 32", "trailing = true"}},
        {with([](DumpSpec& s) { s.offset = 1; }), {"from byte 1", "end at byte 65"}},
        {with([](DumpSpec& s) { s.row_pitch = 33; }), {"33 bytes a row", "end at byte 65"}},
        {with([](DumpSpec& s) { s.row_pitch = 31; }), {"m.toml: line 7", "row_pitch", "take 32 bytes"}},
        {with([&](DumpSpec& s) { s.offset = max; }), {"more than 2^63 bytes"}},
        {with([&](DumpSpec& s) { s.row_pitch = max; }), {"more than 2^63 bytes"}},
        {with([&](DumpSpec& s) { s.row_pitch = max / 2, s.height = 4; }), {"more than 2^63 bytes"}},
        {with([](DumpSpec& s) { s.width = 0; }), {"m.toml: line 7", "width"}},
        {with([](DumpSpec& s) { s.height = -1; }), {"m.toml: line 7", "height"}},
        {with([](DumpSpec& s) { s.vk_format = "R32G32B32A33_SFLOAT"; }),
         {"m.toml: line 7", "vk_format", "R32G32B32A32_SFLOAT"}},
        {with([](DumpSpec& s) { s.vk_format = "VK_FORMAT_"; }), {"vk_format", "unknown format; known: R8_UNORM"}},
        {with([&](DumpSpec& s) { s.file = folder / "none.raw"; }),
         {"none.raw: cannot be read: No such file", "m.toml: line 7"}},
        {with([&](DumpSpec& s) { s.file = folder / "sub.raw"; }),
         {"sub.raw: cannot be read: it is not a regular file"}},
        {with([](DumpSpec& s) { s.file = "/dev/zero"; }), {"/dev/zero: cannot be read: it is not a regular file"}},
        {with([](DumpSpec& s) { s.file = std::string("a\0b", 3); }), {"NUL"}},
        {with([](DumpSpec& s) { s.file = ""; }), {"m.toml: line 7", "file"}},
        {with([&](DumpSpec& s) { s.file = folder.put("e.raw", ""); }), {"e.raw: has 0 bytes"}},
        {with([](DumpSpec& s) { s.channels = "q"; }), {"channels"}},
        {with([](DumpSpec& s) { s.encoding = "octahedrl"; }), {"encoding", "'octahedral'"}},
        {with([](DumpSpec& s) { s.vk_format = "R32_SFLOAT", s.encoding = "octahedral"; }), {"a.raw"}},
        {with([](DumpSpec& s) { s.encoding = "depth"; }), {"near_far"}},
        {with([](DumpSpec& s) {
             s.near_far = {1, 2};
         }),
         {"near_far"}},
        {with([](DumpSpec& s) { s.count = 3; }), {"count"}},
        {with([](DumpSpec& s) { s.count = 5, s.width = s.height = 0; }),
         {"a.raw: has 64 bytes", "5 x 1 texels", "end at byte 80"}},
        {with([](DumpSpec& s) { s.vk_format = ""; }), {"a.raw: is no .exr", "vk_format", "m.toml: line 7"}},
    };
    for (const auto& [spec, parts] : cases) {
        CAPTURE(parts[0]);
        const DumpSpec& wrong = spec;
        require_message(error_of([&] { read_dump(wrong); }), parts);
    }
    // Cut at every byte.
    for (std::size_t n = 0; n < 64; ++n) {
        const DumpSpec spec = raw(folder.put("cut.raw", std::string(n, '\0')), "R32G32B32A32_SFLOAT", 2, 2);
        require_message(error_of([&] { read_dump(spec); }),
                        {"cut.raw: has " + std::to_string(n) + " bytes", "end at byte 64"});
    }
}

TEST_CASE("dump files: pictures that are cut off or damaged give one line", "[io][dump][robustness]") {
    const Folder folder, scratch;
    const std::vector<std::string> rgb = {"R", "G", "B"};
    put_picture(scratch / "a.exr", 3, 2, rgb, {TypeDesc::HALF}, std::string(36, '\x3c'));
    put_picture(scratch / "a.tif", 3, 2, rgb, {TypeDesc::FLOAT}, bytes_of(std::vector<float>(18, 0.5f)));
    put_picture(scratch / "a.png", 3, 2, rgb, {TypeDesc::UINT16}, std::string(36, '\x3c'));
    put_picture(scratch / "a.hdr", 3, 2, rgb, {TypeDesc::FLOAT}, bytes_of(std::vector<float>(18, 0.5f)));
    scratch.put("a.pfm", "Pf\n3 2\n-1.0\n" + bytes_of(std::vector<float>(6, 0.5f)));
    scratch.put("a.dds", dds_header(3, 2, 10) + std::string(48, '\x3c'));
    scratch.put("b.dds", dds_header(3, 2, 0) + std::string(24, '\x3c'));
    write_npy(scratch / "a.npy", DType::f32, {2, 3}, std::vector<float>(6, 0.5f).data());
    for (const char* name : {"a.exr", "a.tif", "a.png", "a.hdr", "a.pfm", "a.dds", "b.dds", "a.npy"}) {
        CAPTURE(name);
        const std::string content = read_text(scratch / name);
        DumpSpec spec = picture(folder / name);
        spec.width = 3, spec.height = 2;
        folder.put(name, content);
        CHECK(read_dump(spec).array.shape == Shape{2, 3, 4});
        for (std::size_t n = 0; n < content.size(); ++n) {
            folder.put(name, content.substr(0, n));
            const std::string message = error_of([&] { read_dump(spec); });
            CAPTURE(n, content.size());
            require_message(message, {std::string(name) + ": ", "m.toml: line 7"});
        }
        load_damaged(folder, name, content, [&](const std::string&) { read_dump(spec); });
    }
}

TEST_CASE("dump files: malformed PNG are refused as pictures are", "[io][dump][robustness]") {
    const Folder folder;
    for (const png_bytes::BadPng& bad : png_bytes::bad_pngs()) {
        CAPTURE(bad.kind);
        require_message(error_of([&] { read_dump(picture(folder.put("a.png", bad.bytes))); }),
                        {"a.png: ", bad.message, "m.toml: line 7"});
    }
}

TEST_CASE("dump files: files of another kind, and headers that promise too much", "[io][dump][robustness]") {
    const Folder folder;
    std::filesystem::create_directory(folder / "sub.exr");
    const std::string npy_huge = [&] {
        const std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (4294967296, 4294967296), }\n";
        return std::string("\x93NUMPY\1\0", 8) + char(header.size()) + '\0' + header;
    }();
    const std::vector<std::tuple<std::string, std::string, std::vector<std::string>>> cases = {
        {"a.exr", "this is text", {"byte 0: does not begin as a .exr file does"}},
        {"a.exr", "", {"is empty"}},
        {"a.tif", "II*", {"a.tif"}},
        {"a.tif", "PK\3\4", {"does not begin as a .tif file does"}},
        {"a.png", "GIF89a", {"does not begin as a .png file does"}},
        {"a.hdr", "#?RADIANCE\n\n-Y 0 +X 5\n", {"a.hdr"}},
        {"a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100000 +X 100000\n", {"a.hdr"}},
        {"a.pfm", "PF\n100000 100000\n-1.0\n", {"a.pfm"}},
        {"a.pfm", "PF\n0 5\n-1.0\n", {"a.pfm"}},
        {"a.pfm", "PF\nx y\n-1.0\n", {"a.pfm"}},
        {"a.dds", "DDS ", {"ends after 4 bytes"}},
        {"a.dds", std::string(128, 'x'), {"does not begin as a .dds file does"}},
        {"a.dds", dds_header(32767, 32767, 2), {"has 148 bytes"}},
        {"a.dds", dds_header(1, 1, 10).substr(0, 130), {"ends after 130 bytes", "148"}},
        {"a.npy", "NUMPY", {"does not begin as a .npy file does"}},
        {"a.npy", npy_huge, {"a.npy: header"}},
        {"a.jpg", "\xff\xd8\xff", {"is no .exr"}},
        {"a.bin", "1234", {"is no .exr", "vk_format"}},
        {"noextension", "1234", {"is no .exr", "vk_format"}},
    };
    for (const auto& [name, bytes, parts] : cases) {
        CAPTURE(name);
        std::vector<std::string> all = parts;
        all.insert(all.end(), {folder / name, "m.toml: line 7"});
        const std::string path = folder.put(name, bytes);
        require_message(error_of([&] { read_dump(picture(path)); }), all);
    }
    require_message(error_of([&] { read_dump(picture(folder / "sub.exr")); }),
                    {"sub.exr", "not a regular file", "m.toml: line 7"});
    require_message(error_of([&] { read_dump(picture(folder / "none.npy")); }),
                    {"none.npy", "cannot be read", "m.toml: line 7"});
}
