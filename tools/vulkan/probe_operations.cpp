// Single operations on a device, against what they should be.
#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "core/formats.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "tools/vulkan/compute.h"
#include "tools/vulkan/probe.h"
#include "tools/vulkan/twins.h"

namespace plumb::vulkan {
namespace {

constexpr int columns = 256, rows = 256, count = columns * rows;  // inputs of each operation

// Where operands come from.
enum class Domain { any, moderate, blend, steps, positive, unit, angle, exp2, exp, power, wide };

struct Formula {
    const char* name;
    float (*value)(const glm::vec4&);
};
struct Operation {
    const char* name;
    Domain domain;
    double (*exact)(const glm::dvec4&);  // null: there is none to hold it against, the formulas alone
    std::vector<Formula> formulas;       // as the device may compute it
    bool raw = false;                    // of bits or to bits: denormals and NaN are values like others
    bool (*bounded)(const glm::vec4&) = nullptr;  // inputs of which Vulkan bounds the error in units; null: all
};

float from_bits(std::uint32_t u) { return number<float>::from_bits(std::int32_t(u)); }
std::uint32_t to_bits(float x) { return std::uint32_t(number<float>::bits(x)); }
bool normal(double x) { return std::abs(x) >= 0x1p-126 && std::abs(x) <= 0x1.fffffep127; }
bool denormal(float x) { return x != 0 && std::abs(x) < 0x1p-126f; }
float flush(float x) { return denormal(x) ? std::copysign(0.0f, x) : x; }
bool same(float a, float b) { return to_bits(a) == to_bits(b) || (a != a && b != b); }

float unit_clamp(float x) { return std::min(std::max(x, 0.0f), 1.0f); }
float divided(const glm::vec4& v) { return unit_clamp((v.z - v.x) / (v.y - v.x)); }
float scaled(const glm::vec4& v) { return unit_clamp((v.z - v.x) * (1 / (v.y - v.x))); }
float hermite(float t) { return t * t * (3 - 2 * t); }
float hermite_back(float t) { return t * (t * (3 - 2 * t)); }
float hermite_fused(float t) { return t * t * fused(-2, t, 3); }
float hermite_fused_back(float t) { return t * (t * fused(-2, t, 3)); }
float squares(const glm::vec4& v) { return v.x * v.x + v.y * v.y + v.z * v.z; }
float squares_back(const glm::vec4& v) { return v.z * v.z + v.y * v.y + v.x * v.x; }
float squares_fused(const glm::vec4& v) { return fused(v.z, v.z, fused(v.y, v.y, v.x * v.x)); }
float squares_fused_back(const glm::vec4& v) { return fused(v.x, v.x, fused(v.y, v.y, v.z * v.z)); }
float packed(const glm::vec4& v, HalfStore store) {
    return from_bits(std::uint32_t(float_to_half(v.x, store).bits) |
                     std::uint32_t(float_to_half(v.y, store).bits) << 16);
}
// Vulkan 1.3, "Precision and Operation of SPIR-V Instructions": of a quotient |divisor| in 2^-126 .. 2^126; of a logarithm outside of 0.5 .. 2.
bool divisor_in_range(float x) { return std::abs(x) >= 0x1p-126f && std::abs(x) <= 0x1p126f; }
bool far_from_one(const glm::vec4& v) { return v.x < 0.5f || v.x > 2.0f; }
double length(const glm::dvec4& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

#define EXACT [](const glm::dvec4& v) -> double
#define VALUE [](const glm::vec4& v) -> float

// In the order of tools/probe/operations.comp, then packing.comp.
const std::vector<Operation>& operations() {
    static const std::vector<Operation> all = {
        {"a + b", Domain::any, EXACT { return v.x + v.y; }, {{"IEEE 754", VALUE { return v.x + v.y; }}}},
        {"a - b", Domain::any, EXACT { return v.x - v.y; }, {{"IEEE 754", VALUE { return v.x - v.y; }}}},
        {"a * b", Domain::any, EXACT { return v.x * v.y; }, {{"IEEE 754", VALUE { return v.x * v.y; }}}},
        {"a / b", Domain::any, EXACT { return v.x / v.y; }, {{"IEEE 754", VALUE { return v.x / v.y; }},
                                                              {"a (1 / b)", VALUE { return v.x * (1 / v.y); }}}, false,
         [](const glm::vec4& v) { return divisor_in_range(v.y); }},
        {"1 / a", Domain::any, EXACT { return 1 / v.x; }, {{"IEEE 754", VALUE { return 1 / v.x; }}}, false,
         [](const glm::vec4& v) { return divisor_in_range(v.x); }},
        {"sqrt(a)", Domain::positive, EXACT { return std::sqrt(v.x); }, {{"IEEE 754", VALUE { return sqrt(v.x); }}}},
        {"inversesqrt(a)", Domain::positive, EXACT { return 1 / std::sqrt(v.x); },
         {{"1 / sqrt(a)", VALUE { return 1 / sqrt(v.x); }}}},
        {"fma(a, b, c)", Domain::moderate, EXACT { return v.x * v.y + v.z; },
         {{"a b + c", VALUE { return v.x * v.y + v.z; }}, {"fused", VALUE { return fused(v.x, v.y, v.z); }}}},
        {"a * b + c", Domain::moderate, nullptr,
         {{"a b + c", VALUE { return v.x * v.y + v.z; }}, {"fused", VALUE { return fused(v.x, v.y, v.z); }}}},
        {"precise a * b + c", Domain::moderate, nullptr,
         {{"a b + c", VALUE { return v.x * v.y + v.z; }}, {"fused", VALUE { return fused(v.x, v.y, v.z); }}}},
        {"(a + 0.1) + 0.2", Domain::moderate, nullptr,
         {{"in order", VALUE { return (v.x + 0.1f) + 0.2f; }},
          {"a + 0.3", VALUE { return v.x + (0.1f + 0.2f); }}}},
        {"precise (a + 0.1) + 0.2", Domain::moderate, nullptr,
         {{"in order", VALUE { return (v.x + 0.1f) + 0.2f; }},
          {"a + 0.3", VALUE { return v.x + (0.1f + 0.2f); }}}},
        {"min(a, b)", Domain::any, EXACT { return std::min(v.x, v.y); },
         {{"the lesser", VALUE { return v.x < v.y ? v.x : v.y; }}}},
        {"max(a, b)", Domain::any, EXACT { return std::max(v.x, v.y); },
         {{"the greater", VALUE { return v.x < v.y ? v.y : v.x; }}}},
        {"floor(a)", Domain::moderate, EXACT { return floor(v.x); }, {{"exact", VALUE { return floor(v.x); }}}},
        {"int(floor(a))", Domain::wide, EXACT { return floor(v.x); }, {{"exact", VALUE { return floor(v.x); }}}},
        {"float(uint)", Domain::any, nullptr, {{"nearest", VALUE { return float(to_bits(v.x)); }},
                                                  {"of 31 bits and 1, added",
                                                   VALUE { return float(to_bits(v.x) & 0x7fffffffu) +
                                                                  (to_bits(v.x) >> 31 ? 0x1p31f : 0.0f); }}}, true},
        {"mix(a, b, c)", Domain::blend, nullptr,
         {{"a + c (b - a)", VALUE { return v.x + v.z * (v.y - v.x); }},
          {"a (1 - c) + b c", VALUE { return v.x * (1 - v.z) + v.y * v.z; }},
          {"fma(c, b - a, a)", VALUE { return fused(v.z, v.y - v.x, v.x); }},
          {"fma(b, c, fma(-a, c, a))", VALUE { return fused(v.y, v.z, fused(-v.x, v.z, v.x)); }}}},
        {"smoothstep(a, b, c)", Domain::steps, nullptr, 
         {{"t t (3 - 2 t)", VALUE { return hermite(divided(v)); }},
          {"t (t (3 - 2 t))", VALUE { return hermite_back(divided(v)); }},
          {"t t fma(-2, t, 3)", VALUE { return hermite_fused(divided(v)); }},
          {"t (t fma(-2, t, 3))", VALUE { return hermite_fused_back(divided(v)); }},
          {"t t (3 - 2 t), by 1 / (b - a)", VALUE { return hermite(scaled(v)); }},
          {"t (t (3 - 2 t)), by 1 / (b - a)", VALUE { return hermite_back(scaled(v)); }}}},
        {"length(abc)", Domain::moderate, length,
         {{"sqrt(x x + y y + z z)", VALUE { return sqrt(squares(v)); }},
          {"sqrt(z z + y y + x x)", VALUE { return sqrt(squares_back(v)); }},
          {"sqrt of fused sums", VALUE { return sqrt(squares_fused(v)); }},
          {"sqrt of fused sums, last first", VALUE { return sqrt(squares_fused_back(v)); }}}},
        {"normalize(abc)", Domain::moderate, EXACT { return v.x / length(v); },
         {{"v / sqrt(v.v)", VALUE { return v.x / sqrt(squares(v)); }},
          {"v (1 / sqrt(v.v))", VALUE { return v.x * (1 / sqrt(squares(v))); }},
          {"v / sqrt(v.v), last first", VALUE { return v.x / sqrt(squares_back(v)); }},
          {"v (1 / sqrt(v.v)), last first", VALUE { return v.x * (1 / sqrt(squares_back(v))); }},
          {"v (1 / sqrt(v.v)), fused", VALUE { return v.x * (1 / sqrt(squares_fused(v))); }}}},
        {"dot(abc, bcd)", Domain::moderate, nullptr,
         {{"left to right", VALUE { return v.x * v.y + v.y * v.z + v.z * v.w; }},
          {"right to left", VALUE { return v.z * v.w + v.y * v.z + v.x * v.y; }},
          {"left to right, fused", VALUE { return fused(v.z, v.w, fused(v.y, v.z, v.x * v.y)); }},
          {"right to left, fused", VALUE { return fused(v.x, v.y, fused(v.y, v.z, v.z * v.w)); }}}},
        {"dot(abcd, dabc)", Domain::moderate, nullptr,
         {{"left to right", VALUE { return v.x * v.w + v.y * v.x + v.z * v.y + v.w * v.z; }},
          {"right to left", VALUE { return v.w * v.z + v.z * v.y + v.y * v.x + v.x * v.w; }},
          {"by pairs", VALUE { return (v.x * v.w + v.y * v.x) + (v.z * v.y + v.w * v.z); }},
          {"left to right, fused",
           VALUE { return fused(v.w, v.z, fused(v.z, v.y, fused(v.y, v.x, v.x * v.w))); }},
          {"right to left, fused",
           VALUE { return fused(v.x, v.w, fused(v.y, v.x, fused(v.z, v.y, v.w * v.z))); }}}},
        {"mat4 * vec4", Domain::moderate, nullptr,
         {{"first column first",
           VALUE { return abs(v.y) * v.x + abs(v.z) * v.y + abs(v.w) * v.z + abs(v.x) * v.w; }},
          {"last column first",
           VALUE { return abs(v.x) * v.w + abs(v.w) * v.z + abs(v.z) * v.y + abs(v.y) * v.x; }},
          {"by pairs", VALUE { return (abs(v.y) * v.x + abs(v.z) * v.y) + (abs(v.w) * v.z + abs(v.x) * v.w); }},
          {"first column first, fused",
           VALUE { return fused(abs(v.x), v.w, fused(abs(v.w), v.z, fused(abs(v.z), v.y, abs(v.y) * v.x))); }},
          {"last column first, fused",
           VALUE { return fused(abs(v.y), v.x, fused(abs(v.z), v.y, fused(abs(v.w), v.z, abs(v.x) * v.w))); }}}},
        {"exp2(a)", Domain::exp2, EXACT { return host::exp2(v.x); }, {}},
        {"exp(a)", Domain::exp, EXACT { return host::exp(v.x); }, {}},
        {"log2(a)", Domain::positive, EXACT { return host::log2(v.x); }, {}, false, far_from_one},
        {"log(a)", Domain::positive, EXACT { return host::log(v.x); }, {}, false, far_from_one},
        {"pow(a, b)", Domain::power, EXACT { return host::pow(v.x, v.y); }, {}},
        {"sin(a)", Domain::angle, EXACT { return host::sin(v.x); }, {}},
        {"cos(a)", Domain::angle, EXACT { return host::cos(v.x); }, {}},
        {"acos(a)", Domain::unit, EXACT { return host::acos(v.x); }, {}},
        {"atan(a)", Domain::moderate, EXACT { return host::atan(v.x); }, {}},
        {"unpackUnorm4x8", Domain::any, nullptr,
         {{"v / 255", VALUE { return float(to_bits(v.x) & 0xff) / 255; }},
          {"v (1 / 255)", VALUE { return float(to_bits(v.x) & 0xff) * (1.0f / 255); }}}, true},
        {"packHalf2x16", Domain::moderate, nullptr,
         {{"nearest even", VALUE { return packed(v, HalfStore::nearest); }},
          {"truncated", VALUE { return packed(v, HalfStore::truncate); }}},
         true},
        {"unpackHalf2x16", Domain::any, nullptr,
         {{"exact", VALUE { return half_to_float(Half{std::uint16_t(to_bits(v.x))}); }}}, true},
    };
    return all;
}

// Four hashed words.
struct Words {
    std::uint32_t w[4];
};
Words words(int operation, int i) {
    const auto h = pixel_hash<std::int32_t>(i, operation, 0, 1), g = pixel_hash<std::int32_t>(i, operation, 1, 1);
    return {{std::uint32_t(h.x), std::uint32_t(h.y), std::uint32_t(h.z), std::uint32_t(g.x)}};
}
float between(std::uint32_t w, float low, float high) { return low + (high - low) * float(w >> 8) * 0x1p-24f; }
// Sign and mantissa of the word; the exponent from its spare mixture, of first..last.
float spread(std::uint32_t w, std::uint32_t spare, int first, int last) {
    const int exponent = first + int(spare % std::uint32_t(last - first + 1));
    return from_bits((w & 0x807fffffu) | std::uint32_t(exponent + 127) << 23);
}

constexpr float special_values[] = {0.0f,        -0.0f,        1.0f,         -1.0f,       0x1p-126f,  -0x1p-126f,
                                    0x1p-149f,   0x1p-127f,    0x1.8p-130f,  -0x1p-149f,  0x1p-1f,    2.0f,
                                    0x1p127f,    0x1.fffffep127f, __builtin_inff(), -__builtin_inff(),
                                    __builtin_nanf(""), 0x1.fffffep-1f, 0x1.000002p0f, 255.0f, 65504.0f, 65520.0f};
constexpr int special_count = int(std::size(special_values));

glm::vec4 any_inputs(const Words& k, int i) {
    if (i < special_count * special_count)
        return {special_values[i % special_count], special_values[i / special_count], 1, 1};
    glm::vec4 v;
    for (int c = 0; c < 4; ++c) v[c] = from_bits(k.w[c]);
    // A sum's operands lie near each other more often than chance would have it; every eighth is denormal.
    const int near = int(to_bits(v.x) >> 23 & 0xff) - 30 + int(k.w[2] % 61);
    if (i % 2) v.y = from_bits((k.w[1] & 0x807fffffu) | std::uint32_t(std::clamp(near, 1, 254)) << 23);
    if (i % 8 == 7) v[i / 8 % 2] = from_bits(k.w[0] & 0x807fffffu);
    return v;
}

glm::vec4 inputs(Domain domain, int operation, int i) {
    const Words k = words(operation, i);
    glm::vec4 v;
    for (int c = 0; c < 4; ++c) v[c] = spread(k.w[c], k.w[(c + 1) % 4] >> 8, -12, 4);
    switch (domain) {
        case Domain::any:
            return any_inputs(k, i);
        case Domain::moderate:
            if (i % 4 == 0) v.z = -v.x * v.y * between(k.w[2], 0.999f, 1.001f);  // cancels
            return v;
        case Domain::wide:
            v.x = spread(k.w[0], k.w[1] >> 8, -2, 30);
            return v;
        case Domain::blend:
            v.z = between(k.w[2], 0, 1);
            return v;
        case Domain::steps:
            v.x = between(k.w[0], -2, 2), v.y = v.x + between(k.w[1], 0.1f, 3), v.z = between(k.w[2], -3, 5);
            return v;
        case Domain::positive:
            if (i < special_count) return glm::vec4(special_values[i]);
            v.x = i % 2 ? spread(k.w[0], k.w[1] >> 8, -126, 127) : spread(k.w[0], k.w[1] >> 8, -1, 0);
            if (i % 8 == 2) v.x = 1 + spread(k.w[0], k.w[1] >> 8, -24, -2);
            if (i % 16 == 14) v.x = from_bits(k.w[0] & 0x7fffff);
            v.x = std::abs(v.x);
            return v;
        case Domain::unit:
            v.x = between(k.w[0], -1, 1);
            return v;
        case Domain::angle:
            v.x = between(k.w[0], -3.14159265f, 3.14159265f);
            return v;
        case Domain::exp2:
            v.x = i % 2 ? between(k.w[0], -126, 127.5f) : spread(k.w[0], k.w[1] >> 8, -24, 1);
            return v;
        case Domain::exp:
            v.x = i % 2 ? between(k.w[0], -87.3f, 88.5f) : spread(k.w[0], k.w[1] >> 8, -24, 1);
            return v;
        case Domain::power:
            v.x = between(k.w[0], 0.01f, 4), v.y = between(k.w[1], -8, 8);
            return v;
    }
    return v;
}

// Unit in the last place of a normal number.
int exponent(double x) { return int(std::bit_cast<std::uint64_t>(x) >> 52 & 0x7ff) - 1023; }
double unit(double x) { return std::bit_cast<double>(std::uint64_t(exponent(x) - 23 + 1023) << 52); }

// NaN is as wrong as can be.
double error_of(double value, double exact) {
    return value == value ? std::abs(value - exact) : __builtin_inf();
}

struct Results {
    const Operation& operation;
    std::span<const glm::vec4> inputs;
    std::span<const std::uint32_t> bits;

    float value(int i) const { return from_bits(bits[std::size_t(i)]); }
    int operands() const { return operation.domain == Domain::positive || operation.name[0] == '1' ? 1 : 2; }
    bool normal_operands(int i) const {
        const glm::vec4& v = inputs[std::size_t(i)];
        for (int c = 0; c < operands(); ++c)
            if (v[c] != 0 && !normal(v[c])) return false;
        return true;
    }
};

// The visitor gets the index, the device's value and the exact one.
template <class Visit>
void for_each_exact(const Results& r, Visit&& visit) {
    for (int i = 0; i < count; ++i) {
        if (!r.operation.exact || !r.normal_operands(i)) continue;
        const double exact = r.operation.exact(glm::dvec4(r.inputs[std::size_t(i)]));
        if (normal(exact)) visit(i, double(r.value(i)), exact);
    }
}

void measure_errors(const Results& r, OperationFigures& figures) {
    for_each_exact(r, [&](int i, double value, double exact) {
        const double error = error_of(value, exact), ulp = error / unit(exact);
        ++figures.inputs;
        figures.off += !(value == double(float(exact)));
        figures.worst_absolute = std::max(figures.worst_absolute, error);
        if (r.operation.bounded && !r.operation.bounded(r.inputs[std::size_t(i)])) return;
        if (ulp > figures.worst_ulp) figures.worst_ulp = ulp, figures.worst_at = r.inputs[std::size_t(i)].x;
    });
    figures.off /= std::max(figures.inputs, 1);
}

// Denormals are looked for where the first formula is IEEE 754's.
Denormals find_denormals(const Results& r) {
    if (r.operation.formulas.empty() || r.operation.formulas[0].name != std::string("IEEE 754")) return {};
    int kept = 0, flushed = 0;
    for (int i = 0; i < count; ++i) {
        const glm::vec4& v = r.inputs[std::size_t(i)];
        const float ours = r.operation.formulas[0].value(v);
        glm::vec4 without = v;
        for (int c = 0; c < 4; ++c) without[c] = flush(v[c]);
        const float theirs = flush(r.operation.formulas[0].value(without));
        if (same(ours, theirs)) continue;
        kept += same(r.value(i), ours);
        flushed += !same(r.value(i), ours);
    }
    if (kept + flushed == 0) return Denormals::not_met;
    return flushed == 0 ? Denormals::kept : kept == 0 ? Denormals::flushed : Denormals::both;
}

// The first with all bits of the device, but where something is denormal before it is rounded, infinite or NaN. -0 and
// 0 count as one.
std::string find_formula(const Results& r) {
    for (const Formula& formula : r.operation.formulas) {
        bool all = true;
        for (int i = 0; i < count && all; ++i) {
            const float ours = formula.value(r.inputs[std::size_t(i)]), theirs = r.value(i);
            const bool safe = ours == 0 || (normal(ours) && std::abs(ours) != 0x1p-126f);
            if (!r.operation.raw && !(safe && r.normal_operands(i))) continue;
            all = same(ours, theirs) || (ours == 0 && theirs == 0);
        }
        if (all) return formula.name;
    }
    return "";
}

std::string nan_rule(const Results& r) {
    int number = 0, nan = 0, first = 0, n = 0;
    for (int i = 0; i < count; ++i) {
        const glm::vec4& v = r.inputs[std::size_t(i)];
        if ((v.x != v.x) == (v.y != v.y)) continue;
        const bool is_nan = r.value(i) != r.value(i);
        ++n, number += !is_nan, nan += is_nan, first += is_nan == (v.x != v.x);
    }
    if (n == 0) return "not met";
    if (number == n) return "the number";
    if (nan == n) return "NaN";
    return first == n ? "the first operand" : first == 0 ? "the second operand" : "either";
}

void grade(const Results& r, Probe& probe) {
    const std::string name = r.operation.name;
    auto raise = [](GradedError& errors, int k, double error) {
        const std::size_t bin = std::size_t(std::max(k, 0));
        if (bin >= errors.size()) errors.resize(bin + 1);
        errors[bin] = std::max(errors[bin], error);
    };
    for_each_exact(r, [&](int i, double value, double exact) {
        const double error = error_of(value, exact), x = r.inputs[std::size_t(i)].x;
        if (name == "exp2(a)" || name == "exp(a)") raise(probe.exp2, int(std::abs(x) * 1024), error / unit(exact));
        if (name == "log2(a)") raise(probe.log2, exponent(exact) + 24, error);
    });
}

// Without F16C, Mesa 22.3's lavapipe ends the program with an illegal instruction.
bool survives_packing(const Device& device) {
    return device.name().find("llvmpipe") == std::string::npos || device.name().find("128 bits") == std::string::npos;
}

}  // namespace

const char* denormals_text(Denormals denormals) {
    constexpr const char* texts[] = {"-", "kept", "flushed", "kept and flushed"};
    return texts[int(denormals)];
}

void probe_operations(const Device& device, Probe& probe) {
    const std::size_t n = operations().size();
    std::vector<glm::vec4> values(n * count);
    for (std::size_t k = 0; k < n; ++k)
        for (int i = 0; i < count; ++i) values[k * count + std::size_t(i)] = inputs(operations()[k].domain, int(k), i);

    const auto usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const Buffer in = device_buffer(device, values.data(), values.size() * sizeof values[0], usage);
    const Buffer out = host_buffer(device, values.size() * 4, usage);
    const std::vector<Resource> resources{{.binding = 0, .buffer = &in}, {.binding = 1, .buffer = &out}};
    const DescriptorSet set = make_descriptor_set(device, resources);
    auto run = [&](const char* shader) {
        const ComputePipeline pipeline =
            make_compute_pipeline(device, make_shader(device, find_twin(shader).spirv, shader), set.layout.get());
        device.run([&](VkCommandBuffer commands) { pipeline.dispatch(commands, set.set, {columns, rows}); });
    };
    run("tools/probe/operations.comp");
    const bool packing = survives_packing(device);
    if (packing) run("tools/probe/packing.comp");

    for (std::size_t k = 0; k < n; ++k) {
        const Results r{operations()[k], std::span(values).subspan(k * count, count),
                        {static_cast<const std::uint32_t*>(out.mapped) + k * count, count}};
        OperationFigures figures;
        figures.name = r.operation.name;
        if (figures.name.find("Half") != std::string::npos && !packing) {
            figures.formula = "not run: this driver would end the program";
            probe.operations.push_back(figures);
            continue;
        }
        measure_errors(r, figures);
        figures.denormals = find_denormals(r);
        figures.formula = find_formula(r);
        if (figures.name == "min(a, b)") probe.minimum_of_nan = nan_rule(r);
        if (figures.name == "max(a, b)") probe.maximum_of_nan = nan_rule(r);
        grade(r, probe);
        probe.operations.push_back(figures);
    }
}

}  // namespace plumb::vulkan
