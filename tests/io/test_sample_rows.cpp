// Sample patterns from files: what is read, and that each bad file is refused in one line that names it.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "files.h"
#include "io/npy.h"
#include "io/sample_rows.h"
#include "io/scene_file.h"

using namespace plumb;
using namespace plumb::io;
using Catch::Matchers::Contains;

namespace {

const float two_rows[] = {0, 10, 1.5f, -3.25f, 4, 0};

std::string read_error(const std::string& path) {
    return error_of([&] { read_sample_rows("rows.npy", path, "[rsm]"); });
}

// The error for a pattern of one row.
std::string row_error(const Folder& folder, double dx, double dy, double weight) {
    const double row[] = {dx, dy, weight};
    write_npy(folder / "rows.npy", DType::f64, {1, 3}, row);
    return read_error(folder / "rows.npy");
}

}  // namespace

TEST_CASE("sample rows: floats, doubles and integers are read as they are", "[io][pattern]") {
    const Folder folder;
    write_npy(folder / "rows.npy", DType::f32, {2, 3}, two_rows);
    const SampleRowsPtr rows = read_sample_rows("rows.npy", folder / "rows.npy", "[rsm]");
    REQUIRE(rows);
    CHECK(rows->name == "rows.npy");
    CHECK(rows->rows == std::vector<glm::dvec3>{{0, 10, 1.5}, {-3.25, 4, 0}});

    const double doubles[] = {0.1, 32767, 1e-3};
    write_npy(folder / "rows.npy", DType::f64, {1, 3}, doubles);
    CHECK(read_sample_rows("rows.npy", folder / "rows.npy", "")->rows == std::vector<glm::dvec3>{{0.1, 32767, 1e-3}});
    const std::int32_t integers[] = {-32767, 2, 3};
    write_npy(folder / "rows.npy", DType::i32, {1, 3}, integers);
    CHECK(read_sample_rows("rows.npy", folder / "rows.npy", "")->rows == std::vector<glm::dvec3>{{-32767, 2, 3}});
    CHECK(read_sample_rows("", "", "[rsm]") == nullptr);
}

TEST_CASE("sample rows: a bad file is refused in one line that names it", "[io][pattern][errors]") {
    const Folder folder;
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
    const std::string path = folder / "rows.npy";
    auto check = [&](const std::string& error, const std::string& cause) {
        CHECK_THAT(error, Contains(path) && Contains("[rsm] names it") && Contains(cause));
        CHECK(error.find('\n') == std::string::npos);
    };
    check(read_error(path), "");  // there is none
    folder.put("rows.npy", "dx,dy,weight\n0,1,2\n");
    check(read_error(path), "");
    for (const Shape& shape : {Shape{6}, Shape{3, 2}, Shape{1, 6}, Shape{0, 3}, Shape{1, 2, 3}}) {
        write_npy(path, DType::f32, shape, two_rows);
        check(read_error(path), "expected [N, 3]");
    }
    const std::vector<std::uint8_t> bytes(6);
    write_npy(path, DType::u8, {2, 3}, bytes.data());
    check(read_error(path), "expected f32, f64 or i32");
    const std::vector<float> many(3 * 65537);
    write_npy(path, DType::f32, {65537, 3}, many.data());
    check(read_error(path), "65536");

    check(row_error(folder, nan, 0, 1), "row 0: nan");
    check(row_error(folder, 0, infinite, 1), "row 0: inf");
    check(row_error(folder, 32767.5, 0, 1), "row 0: 32767.5: expected an offset of -32767 to 32767");
    check(row_error(folder, 0, -40000, 1), "row 0: -40000");
    check(row_error(folder, 0, 0, -1), "row 0: the weight is -1");
    check(row_error(folder, 0, 0, nan), "row 0: the weight is nan");
    CHECK(row_error(folder, -32767, 32767, 0) == "");
}

TEST_CASE("sample rows: a scene file names them relative to itself", "[io][pattern]") {
    const Folder folder;
    folder.put("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string scene = folder.put("scene.toml", "[[mesh]]\nfile = \"mesh.obj\"\n[rsm]\npattern = \"rows.npy\"\n");
    CHECK_THAT(error_of([&] { load_scene(scene, {"rsm"}); }),
               Contains(folder / "rows.npy") && Contains("scene.toml") && Contains("4"));
    write_npy(folder / "rows.npy", DType::f32, {2, 3}, two_rows);
    const Scene loaded = load_scene(scene, {"rsm"});
    REQUIRE(loaded.settings.size() == 1);
    CHECK(std::get<std::string>(loaded.settings[0].value) == "rows.npy");
    REQUIRE(loaded.settings[0].rows);
    CHECK(loaded.settings[0].rows->rows.size() == 2);
}
