// Dumps: texels of every format, channels and encodings, and how far a store may have moved them.
#include <array>
#include <cstring>
#include <functional>

#include "core/camera.h"
#include "core/hash.h"
#include "dumps.h"
#include "io/texel_format.h"

using namespace plumb;
using namespace plumb::io;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// One texel.
std::vector<float> texel(const Folder& folder, const std::string& format, const std::string& bytes) {
    return floats(read_dump(raw(folder.put("t.raw", bytes), format, 1, 1)));
}
std::vector<std::int32_t> whole(const Folder& folder, const std::string& format, const std::string& bytes) {
    return integers(read_dump(raw(folder.put("t.raw", bytes), format, 1, 1)));
}

// Numbers of (-1, 1), by count.
double random_number(std::int32_t i) { return double(pcg(i)) / 2147483648.0; }

glm::dvec3 random_unit(std::int32_t i) {
    for (;; i += 1000003) {
        const glm::dvec3 v(random_number(3 * i), random_number(3 * i + 1), random_number(3 * i + 2));
        const double square = v.x * v.x + v.y * v.y + v.z * v.z;
        if (square > 0.01 && square <= 1) return v / std::sqrt(square);
    }
}

Half half(double x) { return float_to_half(float(x)); }
std::int16_t snorm16(double x) { return std::int16_t(std::rint(std::min(std::max(x, -1.0), 1.0) * 32767)); }
std::uint16_t unorm16(double x) { return std::uint16_t(std::rint(std::min(std::max(x, 0.0), 1.0) * 65535)); }
std::int8_t snorm8(double x) { return std::int8_t(std::rint(std::min(std::max(x, -1.0), 1.0) * 127)); }
std::uint8_t unorm8(double x) { return std::uint8_t(std::rint(std::min(std::max(x, 0.0), 1.0) * 255)); }

}  // namespace

TEST_CASE("dump: texels of floats, unorm and snorm", "[io][dump]") {
    const Folder folder;
    // Halves by IEEE 754: 3c00 = 1, c000 = -2, 3555 = 0.333251953125, 0001 = 2^-24.
    CHECK(texel(folder, "R32G32B32A32_SFLOAT", bytes_of<float>({1, -2, 0.1f, 1e-40f})) ==
          std::vector<float>{1, -2, 0.1f, 1e-40f});
    CHECK(texel(folder, "R32G32B32_SFLOAT", bytes_of<float>({1, 2, 3})) == std::vector<float>{1, 2, 3, 1});
    CHECK(texel(folder, "R32G32_SFLOAT", bytes_of<float>({1, 2})) == std::vector<float>{1, 2, 0, 1});
    CHECK(texel(folder, "R32_SFLOAT", bytes_of<float>({7})) == std::vector<float>{7, 0, 0, 1});
    const std::string halves = bytes_of<std::uint16_t>({0x3c00, 0xc000, 0x3555, 0x0001});
    CHECK(texel(folder, "R16G16B16A16_SFLOAT", halves) == std::vector<float>{1, -2, 0.333251953125f, 0x1p-24f});
    CHECK(texel(folder, "R16G16_SFLOAT", halves.substr(0, 4)) == std::vector<float>{1, -2, 0, 1});
    CHECK(texel(folder, "R16_SFLOAT", halves.substr(4, 2)) == std::vector<float>{0.333251953125f, 0, 0, 1});
    // Vulkan 1.3, 3.9.1: unorm is c / (2^b - 1), snorm max(c / (2^(b-1) - 1), -1).
    const std::string codes = bytes_of<std::uint8_t>({0, 51, 255, 128});
    const std::vector<float> rgba = {0, 0.2f, 1, float(128 / 255.0)};
    CHECK(texel(folder, "R8G8B8A8_UNORM", codes) == rgba);
    CHECK(texel(folder, "B8G8R8A8_UNORM", codes) == std::vector<float>{1, 0.2f, 0, rgba[3]});
    CHECK(texel(folder, "R8G8B8_UNORM", codes.substr(0, 3)) == std::vector<float>{0, 0.2f, 1, 1});
    CHECK(texel(folder, "R8G8_UNORM", codes.substr(1, 2)) == std::vector<float>{0.2f, 1, 0, 1});
    CHECK(texel(folder, "R8_UNORM", codes.substr(2, 1)) == std::vector<float>{1, 0, 0, 1});
    CHECK(texel(folder, "R8G8B8A8_SNORM", bytes_of<std::int8_t>({-128, -127, 0, 127})) ==
          std::vector<float>{-1, -1, 0, 1});
    CHECK(texel(folder, "R8G8_SNORM", bytes_of<std::int8_t>({-64, 1})) ==
          std::vector<float>{float(-64 / 127.0), float(1 / 127.0), 0, 1});
    CHECK(texel(folder, "R8_SNORM", bytes_of<std::int8_t>({64})) == std::vector<float>{float(64 / 127.0), 0, 0, 1});
    const std::string words = bytes_of<std::uint16_t>({0, 65535, 32768, 1});
    CHECK(texel(folder, "R16G16B16A16_UNORM", words) ==
          std::vector<float>{0, 1, float(32768 / 65535.0), float(1 / 65535.0)});
    CHECK(texel(folder, "R16G16_UNORM", words.substr(4)) ==
          std::vector<float>{float(32768 / 65535.0), float(1 / 65535.0), 0, 1});
    CHECK(texel(folder, "R16_UNORM", words.substr(6)) == std::vector<float>{float(1 / 65535.0), 0, 0, 1});
    CHECK(texel(folder, "D16_UNORM", words.substr(6)) == std::vector<float>{float(1 / 65535.0), 0, 0, 1});
    CHECK(texel(folder, "R16G16B16A16_SNORM", words) ==
          std::vector<float>{0, float(-1 / 32767.0), -1, float(1 / 32767.0)});
    CHECK(texel(folder, "R16G16_SNORM", words.substr(2, 4)) == std::vector<float>{float(-1 / 32767.0), -1, 0, 1});
    CHECK(texel(folder, "R16_SNORM", bytes_of<std::int16_t>({32767})) == std::vector<float>{1, 0, 0, 1});
}

TEST_CASE("dump: sRGB formats are decoded as a shader reads them", "[io][dump]") {
    const Folder folder;
    // IEC 61966-2-1: 0.5 encoded is 0.21404114048223255 linear; 10 / 255 lies on the straight part.
    const auto v = texel(folder, "VK_FORMAT_R8G8B8A8_SRGB", bytes_of<std::uint8_t>({0, 10, 255, 51}));
    CHECK(v == std::vector<float>{0, float(10 / 255.0 / 12.92), 1, 0.2f});
    const auto grey = texel(folder, "B8G8R8A8_SRGB", bytes_of<std::uint8_t>({128, 127, 10, 255}));
    CHECK(grey[0] == float(10 / 255.0 / 12.92));
    CHECK(grey[2] > 0.2140411f);
    CHECK(grey[1] < 0.2140411f);
    CHECK(grey[2] - grey[1] < 0.0088f);
}

TEST_CASE("dump: packed formats have their bits where Vulkan has them", "[io][dump]") {
    const Folder folder;
    // A in the upper bits, red (or blue) in the lowest.
    const std::uint32_t packed = 1u << 30 | 1023u << 20 | 341u << 10 | 0;
    CHECK(texel(folder, "A2B10G10R10_UNORM_PACK32", bytes_of({packed})) ==
          std::vector<float>{0, float(341 / 1023.0), 1, float(1 / 3.0)});
    CHECK(texel(folder, "A2R10G10B10_UNORM_PACK32", bytes_of({packed})) ==
          std::vector<float>{1, float(341 / 1023.0), 0, float(1 / 3.0)});
    // Unsigned floats of bias 15: 0x3c0 is 1 in 11 bits, 0x1e0 in 10; 0x400 is 2.
    CHECK(texel(folder, "B10G11R11_UFLOAT_PACK32", bytes_of({0x1e0u << 22 | 0x400u << 11 | 0x3c0u})) ==
          std::vector<float>{1, 2, 1, 1});
    // m 2^(e - 24): exponent 24 counts ones.
    CHECK(texel(folder, "E5B9G9R9_UFLOAT_PACK32", bytes_of({24u << 27 | 511u << 18 | 256u << 9 | 3u})) ==
          std::vector<float>{3, 256, 511, 1});
    CHECK(texel(folder, "E5B9G9R9_UFLOAT_PACK32", bytes_of({31u << 27 | 511u})) == std::vector<float>{65408, 0, 0, 1});
    // Depth: 24 bits below, whatever lies above.
    CHECK(texel(folder, "D24_UNORM_S8_UINT", bytes_of({0xab800000u})) ==
          std::vector<float>{float(0x800000 / 16777215.0), 0, 0, 1});
    CHECK(texel(folder, "X8_D24_UNORM_PACK32", bytes_of({0x00ffffffu})) == std::vector<float>{1, 0, 0, 1});
    CHECK(texel(folder, "D32_SFLOAT", bytes_of<float>({0.25f})) == std::vector<float>{0.25f, 0, 0, 1});
    CHECK(texel(folder, "D32_SFLOAT_S8_UINT", bytes_of<float>({0.25f})) == std::vector<float>{0.25f, 0, 0, 1});
}

TEST_CASE("dump: integer formats give integers of as many components", "[io][dump]") {
    const Folder folder;
    CHECK(whole(folder, "R32G32B32A32_SINT", bytes_of({1, -2, 3, -2147483647 - 1})) ==
          std::vector<std::int32_t>{1, -2, 3, -2147483647 - 1});
    CHECK(whole(folder, "R32G32B32A32_UINT", bytes_of({1u, 2u, 3u, 4294967295u})) ==
          std::vector<std::int32_t>{1, 2, 3, -1});
    CHECK(whole(folder, "R32G32_SINT", bytes_of({5, -6})) == std::vector<std::int32_t>{5, -6});
    CHECK(whole(folder, "R32G32_UINT", bytes_of({5u, 2147483648u})) == std::vector<std::int32_t>{5, -2147483647 - 1});
    CHECK(whole(folder, "R32_SINT", bytes_of({-7})) == std::vector<std::int32_t>{-7});
    CHECK(whole(folder, "R32_UINT", bytes_of({16777217u})) == std::vector<std::int32_t>{16777217});  // no float
    const std::string shorts = bytes_of<std::uint16_t>({1, 65535, 2, 32768});
    CHECK(whole(folder, "R16G16B16A16_SINT", shorts) == std::vector<std::int32_t>{1, -1, 2, -32768});
    CHECK(whole(folder, "R16G16B16A16_UINT", shorts) == std::vector<std::int32_t>{1, 65535, 2, 32768});
    CHECK(whole(folder, "R16G16_SINT", shorts.substr(4)) == std::vector<std::int32_t>{2, -32768});
    CHECK(whole(folder, "R16G16_UINT", shorts.substr(4)) == std::vector<std::int32_t>{2, 32768});
    CHECK(whole(folder, "R16_SINT", shorts.substr(2, 2)) == std::vector<std::int32_t>{-1});
    CHECK(whole(folder, "R16_UINT", shorts.substr(2, 2)) == std::vector<std::int32_t>{65535});
    CHECK(whole(folder, "R8G8B8A8_SINT", "\xff\x01\x02\x80") == std::vector<std::int32_t>{-1, 1, 2, -128});
    CHECK(whole(folder, "R8G8B8A8_UINT", "\xff\x01\x02\x80") == std::vector<std::int32_t>{255, 1, 2, 128});
    CHECK(whole(folder, "R8G8_UINT", "\xff\x01") == std::vector<std::int32_t>{255, 1});
    CHECK(whole(folder, "R8_UINT", "\xff") == std::vector<std::int32_t>{255});

    const DumpedImage image = read_dump(raw(folder.put("t.raw", bytes_of({1, 2, 3, 4, 5, 6})), "R32G32_SINT", 3, 1));
    CHECK(image.array.shape == Shape{1, 3, 2});
    CHECK(image.channels == 3);
    CHECK(image.rounding.bytes.empty());
    DumpSpec second = raw(folder / "t.raw", "R32G32_SINT", 3, 1);
    second.channels = "y";
    CHECK(integers(read_dump(second)) == std::vector<std::int32_t>{2, 4, 6});
}

TEST_CASE("dump: every format of the list decodes, with the prefix of Vulkan too", "[io][dump]") {
    const Folder folder;
    for (const TexelFormat& format : texel_formats()) {
        CAPTURE(format.name);
        const std::string path = folder.put("z.raw", std::string(std::size_t(6 * format.bytes), '\0'));
        for (const std::string prefix : {"", "VK_FORMAT_"}) {
            const DumpedImage image = read_dump(raw(path, prefix + format.name, 3, 2));
            CHECK(image.channels == (1u << format.channels) - 1);
            const Shape shape = {2, 3, is_integer(format.kind) ? format.channels : 4};
            CHECK(image.array.shape == shape);
            // Zero bytes are zeros in every format; what is missing is 0, 0, 0, 1.
            if (is_integer(format.kind))
                CHECK(integers(image) == std::vector<std::int32_t>(std::size_t(6 * format.channels), 0));
            else
                CHECK(floats(image)[3] == (format.channels == 4 ? 0 : 1));
        }
    }
    // Formats of core/formats.h agree with its decoders, on all kinds of bytes.
    for (const FormatInfo& f : formats()) {
        const bool is_code = f.format == Format::rgbe || f.format == Format::normal8 ||
                             f.format == Format::octahedral8 || f.format == Format::octahedral16;
        if (is_code) continue;
        CAPTURE(f.name);
        for (std::int32_t i = 0; i < 300; ++i) {
            unsigned char bytes[16];
            for (int b = 0; b < 16; ++b) bytes[b] = static_cast<unsigned char>(pcg(16 * i + b));
            const glm::vec4 expected = decode(f.format, bytes);
            const auto got =
                texel(folder, f.vulkan_name, std::string(reinterpret_cast<char*>(bytes), std::size_t(f.bytes)));
            for (int c = 0; c < (f.format == Format::d24s8 ? 1 : 4); ++c) {
                CAPTURE(c, i);
                REQUIRE((got[std::size_t(c)] == expected[c] ||
                         (std::isnan(expected[c]) && std::isnan(got[std::size_t(c)]))));
            }
        }
    }
}

TEST_CASE("dump: NaN and infinity pass", "[io][dump]") {
    const Folder folder;
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    const auto v = texel(folder, "R32G32B32A32_SFLOAT", bytes_of({nan, inf, -inf, 1.0f}));
    CHECK(std::isnan(v[0]));
    CHECK(v[1] == inf);
    CHECK(v[2] == -inf);
    const auto h = texel(folder, "R16G16_SFLOAT", bytes_of<std::uint16_t>({0x7c00, 0x7e01}));
    CHECK(h[0] == inf);
    CHECK(std::isnan(h[1]));
}

TEST_CASE("dump: rows have their pitch, the first its offset", "[io][dump]") {
    const Folder folder;
    // Two rows of three texels: 5 bytes of something else, rows of 12 bytes in 20.
    const std::string pad(8, '\x77');
    const std::string rows = std::string(5, '\x77') + bytes_of<float>({1, 2, 3}) + pad + bytes_of<float>({4, 5, 6});
    for (const std::string& end : {std::string(), pad}) {  // the last row may lack its padding
        DumpSpec spec = raw(folder.put("p.raw", rows + end), "R32_SFLOAT", 3, 2);
        spec.row_pitch = 20, spec.offset = 5;
        require_values(floats(read_dump(spec)),
                       {1, 0, 0, 1, 2, 0, 0, 1, 3, 0, 0, 1, 4, 0, 0, 1, 5, 0, 0, 1, 6, 0, 0, 1});
        spec.flip_y = true;
        require_values(floats(read_dump(spec)),
                       {4, 0, 0, 1, 5, 0, 0, 1, 6, 0, 0, 1, 1, 0, 0, 1, 2, 0, 0, 1, 3, 0, 0, 1});
    }
    // A pitch that is no multiple of a texel.
    DumpSpec odd = raw(folder.put("o.raw", bytes_of<float>({1}) + "?" + bytes_of<float>({2})), "R32_SFLOAT", 1, 2);
    odd.row_pitch = 5;
    require_values(floats(read_dump(odd)), {1, 0, 0, 1, 2, 0, 0, 1});
    // What follows has to be said.
    DumpSpec longer = raw(folder.put("l.raw", bytes_of<float>({1, 2, 3})), "R32_SFLOAT", 2, 1);
    require_message(error_of([&] { read_dump(longer); }),
                    {"l.raw: has 12 bytes", "end at byte 8", "trailing = true", "m.toml: line 7"});
    longer.trailing = true;
    require_values(floats(read_dump(longer)), {1, 0, 0, 1, 2, 0, 0, 1});
}

TEST_CASE("dump: a buffer has a count and its own number of components", "[io][dump]") {
    const Folder folder;
    DumpSpec spec = picture(folder.put("b.raw", bytes_of<float>({1, 2, 3, 4, 5, 6})));
    spec.vk_format = "R32G32_SFLOAT", spec.count = 3;
    const DumpedImage two = read_dump(spec);
    CHECK(two.array.shape == Shape{3, 2});
    require_values(floats(two), {1, 2, 3, 4, 5, 6});
    spec.channels = "y";
    CHECK(read_dump(spec).array.shape == Shape{3, 1});
    spec.channels = "", spec.encoding = "octahedral";
    CHECK(read_dump(spec).array.shape == Shape{3, 3});
    // Longer than what is decoded at a time.
    std::vector<float> many(200001);
    for (std::size_t i = 0; i < many.size(); ++i) many[i] = float(i);
    DumpSpec one = picture(folder.put("n.raw", bytes_of(many)));
    one.vk_format = "R32_SFLOAT", one.count = int(many.size());
    require_values(floats(read_dump(one)), many);
}

TEST_CASE("dump: channels are picked, repeated, set and left out", "[io][dump]") {
    const Folder folder;
    DumpSpec spec = raw(folder.put("c.raw", bytes_of<float>({10, 20, 30, 40})), "R32G32B32A32_SFLOAT", 1, 1);
    const std::vector<std::tuple<std::string, std::vector<float>, unsigned>> cases = {
        {"", {10, 20, 30, 40}, 15}, {"xyz", {10, 20, 30, 1}, 7},    {"rgb", {10, 20, 30, 1}, 7},
        {"w", {40, 0, 0, 1}, 1},    {"a", {40, 0, 0, 1}, 1},        {"bgr", {30, 20, 10, 1}, 7},
        {"xy0", {10, 20, 0, 1}, 7}, {"xyz1", {10, 20, 30, 1}, 15},  {"xy_w", {10, 20, 0, 40}, 11},
        {"_y", {0, 20, 0, 1}, 2},   {"xxxx", {10, 10, 10, 10}, 15}, {"wzyx", {40, 30, 20, 10}, 15},
    };
    for (const auto& [channels, values, mask] : cases) {
        CAPTURE(channels);
        spec.channels = channels;
        const DumpedImage image = read_dump(spec);
        require_values(floats(image), values);
        CHECK(image.channels == mask);
    }
}

TEST_CASE("dump: biased components are 2 c - 1, the fourth as it is, constants too", "[io][dump]") {
    const Folder folder;
    DumpSpec spec = raw(folder.put("c.raw", bytes_of<float>({0, 0.5f, 1, 0.25f})), "R32G32B32A32_SFLOAT", 1, 1);
    spec.encoding = "biased";
    require_values(floats(read_dump(spec)), {-1, 0, 1, 0.25f});
    spec.channels = "zx0";
    require_values(floats(read_dump(spec)), {1, -1, 0, 1});
    // ISR (22), of which core/formats.h has the codes.
    DumpSpec packed = raw(folder.put("n.raw", bytes_of<std::uint8_t>({0, 128, 255, 0})), "R8G8B8A8_UNORM", 1, 1);
    packed.encoding = "biased", packed.channels = "xyz";
    const DumpedImage image = read_dump(packed);
    const glm::vec3 expected = decode_normal8({0, 128, 255});
    CHECK(image.stored == Format::normal8);
    for (int c = 0; c < 3; ++c) CHECK(floats(image)[std::size_t(c)] == Approx(expected[c]).margin(1e-7));
}

TEST_CASE("dump: srgb decodes colours and leaves alpha", "[io][dump]") {
    const Folder folder;
    DumpSpec spec = raw(folder.put("c.raw", bytes_of<std::uint8_t>({0, 128, 255, 128})), "R8G8B8A8_UNORM", 1, 1);
    spec.encoding = "srgb";
    const auto v = floats(read_dump(spec));
    CHECK(v == texel(folder, "R8G8B8A8_SRGB", bytes_of<std::uint8_t>({0, 128, 255, 128})));
    // 128 / 255 is 0.21586050011389926 linear: ((0.50196 + 0.055) / 1.055)^2.4.
    CHECK(v[1] == Approx(0.21586050011389926).epsilon(1e-7));
}

TEST_CASE("dump: octahedral normals come back as core/formats.h packs them", "[io][dump]") {
    const Folder folder;
    std::vector<std::int16_t> snorms;
    std::vector<std::uint16_t> unorms;
    std::vector<float> floats_in;
    std::vector<glm::vec3> normals;
    for (std::int32_t i = 0; i < 1000; ++i) {
        normals.push_back(glm::vec3(random_unit(i)));
        const glm::vec2 p = octahedral_from_unit(normals.back());
        for (int c = 0; c < 2; ++c) {
            snorms.push_back(snorm16(p[c]));
            unorms.push_back(unorm16(p[c] * 0.5 + 0.5));
            floats_in.push_back(p[c]);
        }
    }
    const auto require_normals = [&](DumpSpec spec, const std::string& encoding, float margin) {
        CAPTURE(encoding, spec.vk_format);
        spec.encoding = encoding;
        const DumpedImage image = read_dump(spec);
        CHECK(image.channels == 7);
        const auto v = floats(image);
        for (std::size_t i = 0; i < normals.size(); ++i)
            for (int c = 0; c < 3; ++c) REQUIRE(std::fabs(v[4 * i + std::size_t(c)] - normals[i][c]) <= margin);
        CHECK(v[3] == 0);
        return image;
    };
    const DumpedImage image =
        require_normals(raw(folder.put("s.raw", bytes_of(snorms)), "R16G16_SNORM", 100, 10), "octahedral", 1e-4f);
    require_normals(raw(folder.put("u.raw", bytes_of(unorms)), "R16G16_UNORM", 100, 10), "octahedral_unorm", 1e-4f);
    require_normals(raw(folder.put("f.raw", bytes_of(floats_in)), "R32G32_SFLOAT", 100, 10), "octahedral", 1e-6f);
    // The same as our own decoder, to the rounding of float.
    CHECK(image.stored == Format::octahedral16);
    CHECK(image.rounding.bytes.empty());
    const auto v = floats(image);
    for (std::size_t i = 0; i < 1000; ++i) {
        const glm::vec4 expected = decode(Format::octahedral16, snorms.data() + 2 * i);
        for (int c = 0; c < 3; ++c) REQUIRE(v[4 * i + std::size_t(c)] == Approx(expected[c]).margin(2e-7));
    }
    // Packed into the last two channels of another image.
    DumpSpec packed = raw(folder.put("w.raw", bytes_of<std::int16_t>({9, 9, 0, -32767})), "R16G16B16A16_SNORM", 1, 1);
    packed.encoding = "octahedral", packed.channels = "zw";
    require_values(floats(read_dump(packed)), {0, -1, 0, 0});
}

TEST_CASE("dump: hemi_xy reconstructs z", "[io][dump]") {
    const Folder folder;
    DumpSpec spec = raw(folder.put("h.raw", bytes_of<float>({0.6f, 0, 0, 0, 0, -1, 1, 1})), "R32G32_SFLOAT", 4, 1);
    spec.encoding = "hemi_xy";
    const auto v = floats(read_dump(spec));
    CHECK(v[2] == Approx(0.8).epsilon(1e-7));
    CHECK(v[6] == 1);
    CHECK(v[10] == 0);
    CHECK(v[14] == 0);  // longer than 1: on the horizon
    DumpSpec unorm = raw(folder.put("u.raw", bytes_of<float>({0.8f, 0.5f})), "R32G32_SFLOAT", 1, 1);
    unorm.encoding = "hemi_xy_unorm";
    CHECK(floats(read_dump(unorm))[0] == Approx(0.6).epsilon(1e-6));
    CHECK(floats(read_dump(unorm))[2] == Approx(0.8).epsilon(1e-6));
}

TEST_CASE("dump: rgbe is HEM 5.7 as core/formats.h has it", "[io][dump][HEM 5.7]") {
    const Folder folder;
    for (const glm::vec3 rgb :
         {glm::vec3(0), glm::vec3(1, 0.5f, 0.25f), glm::vec3(1e-9f, 3, 1e4f), glm::vec3(0, 1e-30f, 0)}) {
        const glm::u8vec4 code = encode_rgbe(rgb);
        const glm::vec3 expected = decode_rgbe(code);
        DumpSpec spec =
            raw(folder.put("e.raw", bytes_of<std::uint8_t>({code.x, code.y, code.z, code.w})), "R8G8B8A8_UNORM", 1, 1);
        spec.encoding = "rgbe";
        const DumpedImage image = read_dump(spec);
        for (int c = 0; c < 3; ++c) CHECK(floats(image)[std::size_t(c)] == Approx(expected[c]).epsilon(1e-6));
        CHECK(image.channels == 7);
        CHECK(image.stored == Format::rgbe);
    }
}

TEST_CASE("dump: depth becomes linear eye depth, as the camera's own", "[io][dump]") {
    const Folder folder;
    Camera camera;
    camera.near = 0.1;
    for (const double far : {100.0, infinity})
        for (const std::string encoding : {"depth", "reversed_depth", "depth_gl"}) {
            camera.far = far, camera.reversed_z = encoding == "reversed_depth";
            for (const float d : {0.0f, 0.125f, 0.5f, 0.9990234375f, 1.0f}) {
                CAPTURE(far, encoding, d);
                const float stored = encoding == "depth_gl" ? 2 * d - 1 : d;
                DumpSpec spec = raw(folder.put("d.raw", bytes_of<float>({stored})), "D32_SFLOAT", 1, 1);
                spec.encoding = encoding, spec.near_far = {0.1, far};
                const DumpedImage image = read_dump(spec);
                const double expected = linear_depth_from_clip(camera, d);
                if (std::isinf(expected))
                    CHECK(floats(image)[0] == std::numeric_limits<float>::infinity());
                else
                    CHECK(floats(image)[0] == Approx(expected).epsilon(1e-6));
                CHECK(image.channels == 1);
            }
        }
}

TEST_CASE("dump: a depth goes where its channel is put, and may be linear over a range", "[io][dump]") {
    const Folder folder;
    DumpSpec spec = raw(folder.put("d.raw", bytes_of<float>({0.25f, 1.0f})), "D32_SFLOAT", 2, 1);
    spec.encoding = "linear_depth", spec.near_far = {0, 8}, spec.channels = "000x";
    const DumpedImage image = read_dump(spec);
    CHECK(image.channels == 15);
    const std::vector<float> expected = {0, 0, 0, 2, 0, 0, 0, 8};
    CHECK(floats(image) == expected);
    spec.near_far = {2, 6}, spec.channels = "";
    CHECK(read_dump(spec).channels == 1);
    CHECK(floats(read_dump(spec))[0] == 3);
    // n f / (f - d (f - n)) at d = 1/4, n = 1, f = 4: 4 / (4 - 3 / 4).
    spec.encoding = "depth", spec.near_far = {1, 4}, spec.channels = "_x";
    CHECK(read_dump(spec).channels == 2);
    CHECK(floats(read_dump(spec))[1] == float(4 / 3.25));
    for (const auto& [channels, planes, message] :
         {std::tuple("xx", std::vector<double>{0, 8}, "expected 1 of"), std::tuple("00", std::vector<double>{0, 8}, "expected 1 of"),
          std::tuple("x", std::vector<double>{0, infinity}, "0 <= near < far, finite"),
          std::tuple("x", std::vector<double>{-1, 8}, "0 <= near < far, finite")}) {
        spec.encoding = "linear_depth", spec.channels = channels, spec.near_far = planes;
        CHECK_THROWS_WITH(read_dump(spec), Catch::Matchers::Contains(message));
    }
}

TEST_CASE("dump: what a store moved lies within the rounding that is told", "[io][dump][property]") {
    const Folder folder;
    constexpr int n = 400;
    struct Case {
        std::string format, encoding;
        std::size_t bytes;
        // Writes the i-th texel, and gives what the decoded x, y, z should have been.
        std::function<glm::dvec3(std::int32_t i, void* to)> put;
    };
    const auto write = [](void* to, auto... codes) {
        const std::array values{codes...};
        std::memcpy(to, values.data(), sizeof values);
    };
    const auto hemisphere = [](std::int32_t i) {
        glm::dvec3 v = random_unit(i);
        v.z = std::fabs(v.z);
        return v;
    };
    const auto octahedral = [](const glm::dvec3& v) {
        const double sum = std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
        glm::dvec2 p(v.x / sum, v.y / sum);
        if (v.z < 0) p = {(1 - std::fabs(p.y)) * (p.x >= 0 ? 1 : -1), (1 - std::fabs(p.x)) * (p.y >= 0 ? 1 : -1)};
        return p;
    };
    const auto eye = [](std::int32_t i) {
        return 0.1 + 99.9 * std::fabs(random_number(i)) * std::fabs(random_number(i + 5000));
    };
    const auto device_depth = [](double z) { return (1 - 0.1 / z) / (1 - 0.1 / 100); };
    const std::vector<Case> cases = {
        {"R16G16B16A16_UNORM", "plain", 8,
         [&](std::int32_t i, void* to) {
             const glm::dvec3 v = glm::abs(random_unit(i));
             return write(to, unorm16(v.x), unorm16(v.y), unorm16(v.z), std::uint16_t(0)), v;
         }},
        {"R16G16B16A16_SNORM", "plain", 8,
         [&](std::int32_t i, void* to) {
             const glm::dvec3 v = random_unit(i);
             return write(to, snorm16(v.x), snorm16(v.y), snorm16(v.z), std::int16_t(0)), v;
         }},
        {"R8G8B8A8_SNORM", "plain", 4,
         [&](std::int32_t i, void* to) {
             const glm::dvec3 v = random_unit(i);
             return write(to, snorm8(v.x), snorm8(v.y), snorm8(v.z), std::int8_t(0)), v;
         }},
        {"R8G8B8A8_SRGB", "plain", 4,
         [&](std::int32_t i, void* to) {
             // Encoded numbers are chosen, and decoded by the standard's own words.
             const auto linear = [](double e) { return e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4); };
             const glm::dvec3 e = glm::abs(random_unit(i));
             write(to, unorm8(e.x), unorm8(e.y), unorm8(e.z), std::uint8_t(0));
             return glm::dvec3(linear(e.x), linear(e.y), linear(e.z));
         }},
        {"R16G16B16A16_SFLOAT", "srgb", 8,
         [&](std::int32_t i, void* to) {
             const auto linear = [](double e) { return e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4); };
             const glm::dvec3 e = 1.3 * glm::abs(random_unit(i));
             write(to, half(e.x), half(e.y), half(e.z), half(0));
             return glm::dvec3(linear(e.x), linear(e.y), linear(e.z));
         }},
        {"R8G8B8A8_UNORM", "srgb", 4,
         [&](std::int32_t i, void* to) {
             const auto linear = [](double e) { return e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4); };
             const glm::dvec3 e = glm::abs(random_unit(i));
             write(to, unorm8(e.x), unorm8(e.y), unorm8(e.z), std::uint8_t(0));
             return glm::dvec3(linear(e.x), linear(e.y), linear(e.z));
         }},
        {"A2B10G10R10_UNORM_PACK32", "biased", 4,
         [&](std::int32_t i, void* to) {
             const glm::dvec3 v = random_unit(i);
             std::uint32_t packed = 0;
             for (int c = 0; c < 3; ++c) packed |= std::uint32_t(std::rint((v[c] * 0.5 + 0.5) * 1023)) << 10 * c;
             return write(to, packed), v;
         }},
        {"R16G16B16A16_SFLOAT", "biased", 8,
         [&](std::int32_t i, void* to) {
             const glm::dvec3 v = random_unit(i);
             return write(to, half(v.x * 0.5 + 0.5), half(v.y * 0.5 + 0.5), half(v.z * 0.5 + 0.5), half(0)), v;
         }},
        {"R16G16_SFLOAT", "octahedral", 4,
         [&](std::int32_t i, void* to) {
             const glm::dvec3 v = random_unit(i);
             return write(to, half(octahedral(v).x), half(octahedral(v).y)), v;
         }},
        {"R32G32_SFLOAT", "octahedral", 8,
         [&](std::int32_t i, void* to) {
             const glm::dvec3 v = random_unit(i);
             return write(to, float(octahedral(v).x), float(octahedral(v).y)), v;
         }},
        {"R16G16_SNORM", "hemi_xy", 4,
         [&](std::int32_t i, void* to) {
             const glm::dvec3 v = hemisphere(i);
             return write(to, snorm16(v.x), snorm16(v.y)), v;
         }},
        {"R8G8_UNORM", "hemi_xy_unorm", 2,
         [&](std::int32_t i, void* to) {
             const glm::dvec3 v = hemisphere(i);
             return write(to, unorm8(v.x * 0.5 + 0.5), unorm8(v.y * 0.5 + 0.5)), v;
         }},
        {"D24_UNORM_S8_UINT", "depth", 4,
         [&](std::int32_t i, void* to) {
             return write(to, std::uint32_t(std::rint(device_depth(eye(i)) * 16777215))), glm::dvec3(eye(i), 0, 0);
         }},
        {"D16_UNORM", "depth", 2,
         [&](std::int32_t i, void* to) { return write(to, unorm16(device_depth(eye(i)))), glm::dvec3(eye(i), 0, 0); }},
        {"D32_SFLOAT", "depth", 4,
         [&](std::int32_t i, void* to) { return write(to, float(device_depth(eye(i)))), glm::dvec3(eye(i), 0, 0); }},
        {"R16_SFLOAT", "reversed_depth", 2,
         [&](std::int32_t i, void* to) { return write(to, half(1 - device_depth(eye(i)))), glm::dvec3(eye(i), 0, 0); }},
    };
    for (const Case& k : cases) {
        CAPTURE(k.format, k.encoding);
        std::string bytes(n * k.bytes, '\0');
        std::vector<glm::dvec3> expected;
        for (std::int32_t i = 0; i < n; ++i) expected.push_back(k.put(i, bytes.data() + std::size_t(i) * k.bytes));
        DumpSpec spec = raw(folder.put("r.raw", bytes), k.format, 20, n / 20);
        spec.encoding = k.encoding;
        if (k.encoding == "depth" || k.encoding == "reversed_depth") spec.near_far = {0.1, 100};
        const DumpedImage image = read_dump(spec);
        REQUIRE(image.rounding.shape == image.array.shape);
        const auto got = floats(image);
        const auto bound = elements<float>(image.rounding, image.rounding.shape);
        double tightest = infinity;
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                if (!(image.channels >> c & 1)) continue;
                const double error = std::fabs(double(got[4 * i + c]) - expected[i][int(c)]);
                CAPTURE(i, c, got[4 * i + c], expected[i][int(c)], bound[4 * i + c]);
                REQUIRE(error <= bound[4 * i + c]);
                if (error > 0) tightest = std::min(tightest, bound[4 * i + c] / error);
            }
        // A bound that is never near the error would hide faults: stores here round to nearest, half a step.
        CHECK(tightest < 4);
    }
}

TEST_CASE("dump: what can be told by a format is told by it", "[io][dump]") {
    const Folder folder;
    const std::vector<std::tuple<std::string, std::string, Format>> cases = {
        {"R32G32B32A32_SFLOAT", "plain", Format::rgba32f},
        {"R16G16B16A16_SFLOAT", "plain", Format::rgba16f},
        {"R8G8B8A8_UNORM", "plain", Format::rgba8},
        {"B8G8R8A8_UNORM", "plain", Format::rgba8},
        {"R8G8B8A8_UNORM", "biased", Format::normal8},
        {"B10G11R11_UFLOAT_PACK32", "plain", Format::r11g11b10f},
        {"R16G16_SNORM", "octahedral", Format::octahedral16},
        {"R8G8_SNORM", "octahedral", Format::octahedral8},
        {"A2B10G10R10_UNORM_PACK32", "plain", Format::r10g10b10a2},
        {"D32_SFLOAT", "plain", Format::d32f},
        {"D24_UNORM_S8_UINT", "plain", Format::d24s8},
        {"R8G8B8A8_UNORM", "rgbe", Format::rgbe},
    };
    for (const auto& [format, encoding, stored] : cases) {
        CAPTURE(format, encoding);
        DumpSpec spec =
            raw(folder.put("f.raw", std::string(std::size_t(find_texel_format(format)->bytes), '\0')), format, 1, 1);
        spec.encoding = encoding;
        CHECK(read_dump(spec).stored == stored);
        CHECK(read_dump(spec).rounding.bytes.empty());
    }
    // Alpha's two bits, taken for x: no format has them there.
    DumpSpec alpha = raw(folder.put("f.raw", bytes_of({1u << 30})), "A2B10G10R10_UNORM_PACK32", 1, 1);
    alpha.channels = "w";
    const DumpedImage image = read_dump(alpha);
    REQUIRE(image.rounding.shape == Shape{1, 1, 4});
    CHECK(elements<float>(image.rounding, {1, 1, 4})[0] == Approx(1 / 3.0).epsilon(1e-5));
}
