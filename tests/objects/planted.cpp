// A hash that cannot change proves nothing. This program is linked once with the library's kernels (its argument is
// "none": all sets agree) and once per instruction set with that set's object compiled with contraction to fma: that
// set's hash differs from the others', which still agree.
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/isa.h"
#include "core/kernel_rows.h"
#include "gi/rsm/gather_kernel.h"

namespace {

using namespace plumb;

constexpr int skipped = 77;  // ctest's SKIP_RETURN_CODE
constexpr int width = 67, height = 3, map_size = 16, samples = 50, rotations = 4;

// Numbers in [-1, 1) from an integer recurrence (Numerical Recipes' quick LCG).
struct Numbers {
    std::uint32_t state = 1;
    float next() {
        state = state * 1664525u + 1013904223u;
        return float(std::int32_t(state) >> 8) * 0x1p-23f;
    }
    Buffer<float> list(int count, float centre) {
        Buffer<float> v(count);
        for (float& x : v) x = centre + next();
        return v;
    }
};

// FNV-1a, 64 bits.
std::uint64_t hash(const Buffer<float>& values) {
    std::vector<unsigned char> bytes(values.size() * sizeof(float));
    std::memcpy(bytes.data(), values.data(), bytes.size());
    std::uint64_t h = 0xcbf29ce484222325u;
    for (unsigned char byte : bytes) h = (h ^ byte) * 0x100000001b3u;
    return h;
}

// Shading points around the origin gather from a map of lights around (0, 0, 3), normals towards each other.
std::uint64_t gathered(Isa isa) {
    Numbers numbers;
    const Buffer<float> position = numbers.list(4 * width * height, 0.0f);
    Buffer<float> normal = numbers.list(4 * width * height, 0.0f);
    for (std::size_t i = 2; i < normal.size(); i += 4) normal[i] = 1.0f;
    Buffer<float> records = numbers.list(record_stride * map_size * map_size, 2.0f);
    for (std::size_t i = 0; i < records.size(); i += record_stride) records[i + 2] = 3.0f, records[i + 6] = -1.0f;
    const Buffer<float> weights = numbers.list(samples, 1.5f);
    Buffer<std::int32_t> offsets(samples * rotations);
    for (std::int32_t& offset : offsets) {
        const int dx = int(7 * numbers.next()), dy = int(7 * numbers.next());
        offset = std::int32_t(std::uint32_t(dx & 0xffff) | std::uint32_t(dy) << 16);
    }

    Buffer<float> irradiance(4 * width * height);
    rsm::GatherInputsView<float> in{};
    raster::Projection& map = in.u.map;
    map.to_texel_x[0] = map.to_texel_y[1] = 4.0f;
    map.to_texel_x[3] = map.to_texel_y[3] = 8.0f;
    map.to_texel_w[3] = 1.0f;
    map.least_w = 1e-6f;
    map.low = -1e4f, map.high = 1e4f;
    map.size = map_size;
    in.u.least_distance2 = 1e-6f;
    in.u.scale = 0.25f;
    in.u.samples = samples, in.u.rotations = rotations;
    in.u.width = width, in.u.height = height, in.u.seed = 1;
    in.position = position.data(), in.normal = normal.data(), in.records = records.data();
    in.offsets = offsets.data(), in.weights = weights.data(), in.irradiance = irradiance.data();
    dispatch(isa, [&](auto set) { Rows<rsm::DiscKernel<false>, set.value>::run(in, 0, height, {}, nullptr); });
    return hash(irradiance);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return std::puts("usage: planted_<set> <set>"), 2;
    const std::string planted = argv[1];
    bool planted_ran = planted == "none", right = true;
    if (!__builtin_cpu_supports("fma")) return std::puts("this machine has no fma to plant"), skipped;

    // What every set that is not planted must give.
    const std::uint64_t expected = gathered(planted == "scalar" ? Isa::sse : Isa::scalar);
    for (Isa isa : supported_isas()) {
        const bool is_planted = planted == isa_name(isa);
        const std::uint64_t h = gathered(isa);
        std::printf("%-6s %016llx%s\n", isa_name(isa), static_cast<unsigned long long>(h), is_planted ? " planted" : "");
        right = right && (h != expected) == is_planted;
        planted_ran = planted_ran || is_planted;
    }
    if (!planted_ran) return std::printf("this machine lacks %s\n", planted.c_str()), skipped;
    std::puts(right ? "as planted" : "WRONG: not exactly the planted set differs");
    return right ? 0 : 1;
}
