// The smallest honest file of a bake: cut anywhere, changed anywhere, replaced while it is read; and files that are none.
#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/gi/probe_bakes.h"
#include "tests/io/files.h"
#include "tools/shared/bake_file.h"

using namespace plumb;
using namespace plumb::test;
namespace fs = std::filesystem;

namespace {

// One receiver, one probe, one ray; or several.
io::DescribedFile smallest(int rays = 1) {
    Mesh quad;
    add_quad(quad, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 0);
    Scene scene = scene_of(quad);
    scene.environment.radiance = glm::vec3(1);
    probes::BakeParams p;
    p.placement.overlaps = 10, p.placement.least = 8, p.receiver_rays = 512;
    p.receivers_per_m2 = 1, p.relight_rays = rays, p.receiver_rays = 16, p.degree = 0, p.singular_values = 4;
    p.placement.count = 1, p.placement.least = 1, p.placement.overlaps = 1;
    probes::BakeGraph graph(scene, p);
    run_all(graph);
    REQUIRE(graph.bake().receivers.count() == 1);
    // It lends what the bake holds, which ends here.
    io::DescribedFile file = cli::bake_file(graph.bake(), "quad", true);
    for (Array& array : file.arrays.arrays) array.bytes.own();
    return file;
}

struct Small {
    io::Folder folder;
    std::string path = folder / "small.bake";
    io::DescribedFile file = smallest();
    std::uintmax_t size = 0;
    Small() {
        io::write_described(path, file);
        size = fs::file_size(path);
    }
    // As it is opened: read whole, or mapped and all of it looked at. The two give one message.
    std::string refusal() const {
        const std::string read = io::error_of([&] { io::read_described(path, cli::bake_kind); });
        CHECK(io::error_of([&] { io::MappedFile(path, cli::bake_kind).verify_all(); }) == read);
        return read;
    }
};

}  // namespace

TEST_CASE("bake file: cut at every length it is refused in one line that names it", "[probes][robustness]") {
    const Small s;
    CHECK(s.refusal() == "");
    CHECK(s.size > 5000);
    CHECK(s.size < 100000);
    // From its end down: cutting needs no writing.
    std::uintmax_t missed = 0, said = 0;
    for (std::uintmax_t n = s.size; n-- > 0;) {
        fs::resize_file(s.path, n);
        const std::string message = s.refusal();
        missed += message.starts_with(s.path + ": ") && message.find('\n') == std::string::npos && message.size() < 300 ? 0 : 1;
        said += message.find("cut off") != std::string::npos ? 1 : 0;
    }
    CHECK(missed == 0);
    CHECK(said == s.size - 8);  // fewer than 8 bytes: is empty, or no bundle
    CHECK(s.folder.files() == 1);
}

TEST_CASE("bake file: with any one byte changed it is refused", "[probes][robustness]") {
    const Small s;
    const std::string bytes = io::read_text(s.path);
    std::fstream file(s.path, std::ios::in | std::ios::out | std::ios::binary);
    const auto put = [&](std::size_t at, char c) { file.seekp(std::streamoff(at)).put(c).flush(); };
    std::uintmax_t missed = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        put(at, char(bytes[at] ^ (1 << at % 8)));
        const std::string message = io::error_of([&] { io::read_described(s.path, cli::bake_kind); });
        missed += message.starts_with(s.path + ": ") && message.find('\n') == std::string::npos ? 0 : 1;
        put(at, bytes[at]);
    }
    CHECK(missed == 0);
    CHECK(s.refusal() == "");
}

TEST_CASE("bake file: replaced while it is mapped, it stays what it was; changed in its place, it is refused", "[probes][robustness]") {
    const Small s;
    const std::string before = io::read_text(s.path);
    io::MappedFile mapped(s.path, cli::bake_kind), late(s.path, cli::bake_kind);
    const Array first = mapped.array("receiver_position");
    // Another bake takes its place, as `plumb bake -o` puts it there.
    io::write_described(s.path, smallest(2));
    CHECK(io::read_text(s.path) != before);
    mapped.verify_all();
    CHECK(mapped.array("relight_direction").shape[0] == 1);
    CHECK(content_hash(mapped.array("receiver_position")) == content_hash(first));
    CHECK(io::MappedFile(s.path, cli::bake_kind).array("relight_direction").shape[0] == 2);
    // Bytes of the very file: what was looked at is lent on, what was not is refused by name.
    io::write_file(s.path, {before});
    io::MappedFile changed(s.path, cli::bake_kind);
    const Array looked_at = changed.array("probe_position");
    const float other[] = {9, 9, 9};
    const std::size_t at = before.find(std::string(reinterpret_cast<const char*>(looked_at.bytes.data()), 12));
    REQUIRE(at != std::string::npos);
    {
        std::fstream file(s.path, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(std::streamoff(at)), file.write(reinterpret_cast<const char*>(other), sizeof other);
    }
    io::require_message(io::error_of([&] { io::MappedFile(s.path, cli::bake_kind).array("probe_position"); }),
                        {"small.bake", "array \"probe_position\"", "checksum"});
    CHECK(io::error_of([&] { changed.array("receiver_position"); }) == "");
}

TEST_CASE("bake file: what a reader of bakes asks of it is checked, under right checksums", "[probes][robustness]") {
    const Small s;
    const auto refused = [&](const std::function<void(io::DescribedFile&)>& change) {
        io::DescribedFile file = io::read_described(s.path, cli::bake_kind);
        change(file);
        const std::string path = s.folder / "other.bake";
        io::write_described(path, file);
        return io::error_of([&] { cli::check_bake(io::read_described(path, cli::bake_kind)); });
    };
    CHECK(refused([](io::DescribedFile&) {}) == "");
    const auto find = [](io::DescribedFile& f, const std::string& name) -> Array& {
        for (Array& a : f.arrays.arrays)
            if (a.name == name) return a;
        FAIL(name);
        return f.arrays.arrays[0];
    };
    // Every array that a reader needs: missing, and of a row more than the others say.
    for (const char* name :
         {"corner_uv", "triangle_chart", "receiver_position", "receiver_normal", "receiver_shift", "receiver_texel",
          "receiver_material", "receiver_triangle", "receiver_border", "receiver_probe", "receiver_weight", "receiver_u",
          "receiver_cluster", "receiver_told", "probe_position", "relight_direction", "relight_weight", "relight_harmonic", "relight_material",
          "relight_triangle", "relight_uv", "relight_position", "cluster_first_receiver", "cluster_receiver",
          "cluster_first_probe", "cluster_probe", "cluster_rank", "cluster_matrix", "cluster_first_value",
          "cluster_singular_value", "cluster_box", "cluster_error"}) {
        CAPTURE(name);
        io::require_message(refused([&](io::DescribedFile& f) {
                                for (std::size_t i = 0; i < f.arrays.arrays.size(); ++i)
                                    if (f.arrays.arrays[i].name == name) {
                                        f.arrays.arrays.erase(f.arrays.arrays.begin() + std::ptrdiff_t(i));
                                        f.descriptions.erase(f.descriptions.begin() + std::ptrdiff_t(i));
                                        break;
                                    }
                            }),
                            {"other.bake", name, "missing"});
    }
    for (const auto& [name, index] : {std::pair("receiver_probe", 2), {"receiver_probe", -2}, {"cluster_receiver", 1},
                                      {"cluster_probe", 2}, {"cluster_rank", 2}, {"cluster_rank", -1}, {"receiver_cluster", 1},
                                      {"cluster_first_receiver", 7}, {"cluster_first_probe", -1}, {"receiver_triangle", 2},
                                      {"receiver_triangle", -1}, {"relight_triangle", 2}, {"triangle_chart", 1}}) {
        CAPTURE(name, index);
        const std::int32_t number = index;
        const std::string array = name;
        io::require_message(refused([&](io::DescribedFile& f) {
                                Bytes& bytes = find(f, array).bytes;
                                std::copy_n(reinterpret_cast<const unsigned char*>(&number), 4, bytes.data());
                            }),
                            {"other.bake"});
    }
    io::require_message(refused([](io::DescribedFile& f) { std::erase_if(f.facts, [](const auto& x) { return x.name == "coefficients"; }); }),
                        {"other.bake", "\"coefficients\" is missing"});
}

TEST_CASE("bake file: spatial receivers come back, and a file without them is whole", "[probes][spatial][robustness]") {
    CHECK(cli::spatial_of(smallest()).empty());
    const Scene scene = furnished();
    probes::BakeParams p = small();
    p.receivers_per_m2 = 1, p.receiver_rays = 16, p.relight_rays = 64, p.degree = 1, p.spatial_receivers = 27;
    probes::BakeGraph graph(scene, p);
    run_all(graph);
    io::Folder folder;
    const std::string path = folder / "air.bake";
    io::write_described(path, cli::bake_file(graph.bake(), "air", false));
    const io::DescribedFile file = io::read_described(path, cli::bake_kind);
    cli::check_bake(file);
    const probes::Spatial &a = graph.bake().spatial, b = cli::spatial_of(file);
    REQUIRE(a.receivers.count() == 6 * 27);
    CHECK((b.grid.count == a.grid.count && b.grid.origin == a.grid.origin && b.grid.spacing == a.grid.spacing));
    CHECK((b.receivers.position == a.receivers.position && b.receivers.normal == a.receivers.normal && b.receivers.shift == a.receivers.shift));
    CHECK(b.shifted == a.shifted);
    CHECK((b.supports.overlaps == a.supports.overlaps && b.supports.probe == a.supports.probe && b.supports.weight == a.supports.weight));
    CHECK(content_hash(lent(b.flat)) == content_hash(lent(a.flat)));
    // What does not fit is refused by name.
    const auto refused = [&](const std::string& name, bool missing, std::int32_t number) {
        io::DescribedFile changed = io::read_described(path, cli::bake_kind);
        for (std::size_t i = 0; i < changed.arrays.arrays.size(); ++i) {
            if (changed.arrays.arrays[i].name != name) continue;
            if (!missing) {
                std::memcpy(changed.arrays.arrays[i].bytes.data(), &number, 4);
            } else {
                changed.arrays.arrays.erase(changed.arrays.arrays.begin() + std::ptrdiff_t(i));
                changed.descriptions.erase(changed.descriptions.begin() + std::ptrdiff_t(i));
            }
            return io::error_of([&] { cli::check_bake(changed); });
        }
        return std::string("no such array");
    };
    for (const char* name : {"spatial_box", "spatial_position", "spatial_shift", "spatial_probe", "spatial_support", "spatial_u", "spatial_cluster",
                             "spatial_cluster_first_receiver", "spatial_cluster_receiver", "spatial_cluster_first_probe", "spatial_cluster_probe",
                             "spatial_cluster_rank", "spatial_cluster_matrix", "spatial_cluster_first_value",
                             "spatial_cluster_singular_value", "spatial_cluster_box", "spatial_cluster_error"}) {
        CAPTURE(name);
        io::require_message(refused(name, true, 0), {"air.bake", name, "missing"});
    }
    for (const auto& [name, number] : {std::pair("spatial_count", 0), {"spatial_count", -3}, {"spatial_count", 1 << 30}, {"spatial_count", 2},
                                       {"spatial_box", 0x7f800000}, {"spatial_probe", 6}, {"spatial_probe", -2}, {"spatial_cluster", 4096},
                                       {"spatial_cluster_probe", 6}, {"spatial_cluster_receiver", 6 * 27}}) {
        CAPTURE(name, number);
        io::require_message(refused(name, false, number), {"air.bake"});
    }
}
