#include <catch2/catch.hpp>
#include <numeric>

#include "core/bundle.h"
#include "core/error.h"

using namespace plumb;

namespace {

Bundle sample() {
    Bundle b;
    const float values[] = {1, 2, 3, 4, 5, 6};
    const Half halves[] = {{0x3c00}, {0x4000}};
    add(b, "position", {2, 3}, values);
    add(b, "flux", {2}, halves);
    return b;
}

}  // namespace

TEST_CASE("content_hash: published values of XXH64", "[content_hash]") {
    CHECK(hash_text(content_hash(std::string())) == "ef46db3751d8e999");
    CHECK(hash_text(content_hash(std::string("a"))) == "d24ec4f1a98c6e5b");
    CHECK(hash_text(content_hash(std::string("abc"))) == "44bc2cf5ad770999");
    const std::string text = "Nobody inspects the spammish repetition";  // 39 bytes: a stripe and a rest
    CHECK(hash_text(content_hash(text)) == "fbcea83c8a378bf1");
}

TEST_CASE("content_hash: every byte and the length count", "[content_hash]") {
    std::vector<unsigned char> bytes(101);
    std::iota(bytes.begin(), bytes.end(), 0);
    const std::uint64_t whole = content_hash(bytes.data(), bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] ^= 1;
        REQUIRE(content_hash(bytes.data(), bytes.size()) != whole);
        bytes[i] ^= 1;
        REQUIRE(content_hash(bytes.data(), i) != whole);
    }
    CHECK(content_hash(bytes.data(), bytes.size()) == whole);
    CHECK(content_hash(bytes.data(), bytes.size(), 1) != whole);
}

TEST_CASE("content_hash: of a picture, its size counts too", "[content_hash]") {
    Image4 wide(4, 2), tall(2, 4);
    CHECK(content_hash(wide) != content_hash(tall));
    const std::uint64_t before = content_hash(wide);
    wide(3, 1).w = -0.0f;  // equal as a number, not as bytes
    CHECK(content_hash(wide) != before);
}

TEST_CASE("bundle: arrays come back as they were added", "[bundle]") {
    const Bundle b = sample();
    const auto position = elements<float>(b, "position", {2, 3});
    CHECK(std::vector<float>(position.begin(), position.end()) == std::vector<float>{1, 2, 3, 4, 5, 6});
    CHECK(elements<Half>(b, "flux", {any_extent})[1].bits == 0x4000);
    CHECK(b.arrays[0].name == "position");
    CHECK(find(b, "normal") == nullptr);
    CHECK(reinterpret_cast<std::uintptr_t>(position.data()) % 64 == 0);
}

TEST_CASE("bundle: errors name the array, what was expected and what is there", "[bundle]") {
    Bundle b = sample();
    CHECK_THROWS_WITH(elements<float>(b, "position", {3, any_extent}),
                      "array \"position\": expected f32 [3, *], got f32 [2, 3]");
    CHECK_THROWS_WITH(elements<float>(b, "flux", {2}), "array \"flux\": expected f32 [2], got f16 [2]");
    CHECK_THROWS_WITH(elements<float>(b, "position", {6}), "array \"position\": expected f32 [6], got f32 [2, 3]");
    CHECK_THROWS_WITH(elements<float>(b, "normal", {2}), "array \"normal\" is missing; there are: position, flux");
    CHECK_THROWS_WITH(elements<float>(Bundle{}, "normal", {2}), "array \"normal\" is missing; there are: none");
    CHECK_THROWS_WITH(add(b, "flux", DType::u8, {1}), "array \"flux\" is there already");
    b.arrays[0].bytes.pop_back();
    CHECK_THROWS_WITH(elements<float>(b, "position", {2, 3}), "array \"position\": expected 24 bytes, got 23");
}

TEST_CASE("bundle: shapes that no memory holds are refused before memory is taken", "[bundle]") {
    Bundle b;
    CHECK_THROWS_AS(add(b, "a", DType::u8, {1ll << 40, 1ll << 40}), InputError);
    CHECK_THROWS_AS(add(b, "a", DType::f64, {(1ll << 60) + 1}), InputError);
    CHECK_THROWS_WITH(add(b, "a", DType::u8, {2, -3}), "array \"a\": shape [2, -3] has a negative extent");
    CHECK(element_count("a", {1ll << 50, 0, 5}) == 0);
    CHECK(element_count("a", {}) == 1);  // a scalar
    CHECK(b.arrays.empty());
}

TEST_CASE("bundle: pictures go in and out", "[bundle]") {
    Bundle b;
    Image4 colour(3, 2);
    Image1 depth(3, 2);
    for (std::size_t i = 0; i < 6; ++i) colour.data()[i] = glm::vec4(float(i), 1, 2, 3), depth.data()[i] = float(i) / 4;
    add(b, "colour", colour), add(b, "depth", depth);
    CHECK(at(b, "colour").shape == Shape{2, 3, 4});
    const Image4 back = image4(at(b, "colour"));
    CHECK(back.width == 3);
    CHECK(back.texels == colour.texels);
    CHECK(image1(at(b, "depth")).texels == depth.texels);
    CHECK_THROWS_WITH(image4(at(b, "depth")), "array \"depth\": expected f32 [*, *, 4], got f32 [2, 3]");
}

TEST_CASE("bundle: the hash tells names, types, shapes, bytes and order apart", "[bundle][content_hash]") {
    const std::uint64_t h = content_hash(sample());
    auto changed = [&](auto change) {
        Bundle b = sample();
        change(b);
        return content_hash(b) != h;
    };
    CHECK(content_hash(sample()) == h);
    CHECK(changed([](Bundle& b) { b.arrays[0].name = "positioN"; }));
    CHECK(changed([](Bundle& b) { b.arrays[1].dtype = DType::u16; }));
    CHECK(changed([](Bundle& b) { b.arrays[0].shape = {3, 2}; }));
    CHECK(changed([](Bundle& b) { b.arrays[1].bytes[3] ^= 1; }));
    CHECK(changed([](Bundle& b) { std::swap(b.arrays[0], b.arrays[1]); }));
    CHECK(changed([](Bundle& b) { b.arrays.pop_back(); }));
}

TEST_CASE("bundle: the names of types parse", "[bundle]") {
    for (DType t : {DType::f32, DType::f64, DType::u8, DType::u16, DType::i32, DType::u32, DType::f16})
        CHECK(parse_dtype(dtype_name(t), "") == t);
    CHECK(dtype_size(DType::f16) == 2);
    CHECK_THROWS_WITH(parse_dtype("f8", "a.bundle"),
                      "a.bundle: type \"f8\" is unknown; expected one of f32, f64, u8, u16, i32, u32, f16");
}
