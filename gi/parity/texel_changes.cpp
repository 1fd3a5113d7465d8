#include "gi/parity/texel_changes.h"

#include <algorithm>
#include <cmath>

#include "core/formats.h"
#include "core/host_math.h"

namespace plumb::parity {

namespace {

double stepped(double x, double codes) { return std::rint(std::clamp(x, 0.0, 1.0) * codes) / codes; }
double signed_stepped(double x, double codes) { return std::rint(std::clamp(x, -1.0, 1.0) * codes) / codes; }

}  // namespace

void put(BoundedValue& v, double low, double high) {
    if (low > high) std::swap(low, high);
    v.shadow = 0.5 * (low + high);
    v.bound = 0.5 * (high - low) + 0x1p-22 * std::max(std::abs(low), std::abs(high));
}
void scale(BoundedValue& v, double by) {
    if (std::isfinite(v.bound)) put(v, by * (v.shadow - v.bound), by * (v.shadow + v.bound));
}

double srgb_to_linear(double c) { return c <= 0.04045 ? c / 12.92 : host::pow((c + 0.055) / 1.055, 2.4); }
double linear_to_srgb(double c) { return c <= 0.0031308 ? 12.92 * c : 1.055 * host::pow(c, 1 / 2.4) - 0.055; }

const std::vector<Curve>& curves() {
    static const std::vector<Curve> all = {
        {"decoded from sRGB", srgb_to_linear},
        {"encoded as sRGB", linear_to_srgb},
        {"to the power of 2.2", [](double x) { return x <= 0 ? 0 : host::pow(x, 2.2); }},
        {"to the power of 1 / 2.2", [](double x) { return x <= 0 ? 0 : host::pow(x, 1 / 2.2); }},
        {"clamped to 0..1", [](double x) { return std::clamp(x, 0.0, 1.0); }},
        {"clamped to 0 and more", [](double x) { return std::max(x, 0.0); }},
        {"rounded to 8 bits", [](double x) { return stepped(x, 255); }},
        {"rounded to 16 bits", [](double x) { return stepped(x, 65535); }},
        {"rounded to 8 bits and a sign", [](double x) { return signed_stepped(x, 127); }},
        {"rounded to half precision", [](double x) { return double(half_to_float(float_to_half(float(x)))); }},
        {"packed once more (0.5 x + 0.5)", [](double x) { return 0.5 * x + 0.5; }},
        {"unpacked once more (2 x - 1)", [](double x) { return 2 * x - 1; }},
        {"squared", [](double x) { return x <= 0 ? 0 : x * x; }},
        {"under a root", [](double x) { return x <= 0 ? 0 : std::sqrt(x); }},
    };
    return all;
}

const std::vector<Order>& orders() {
    static const std::vector<Order> all = {{"x and y swapped", {1, 0, 2}},
                                           {"x and z swapped", {2, 1, 0}},
                                           {"y and z swapped", {0, 2, 1}},
                                           {"read as y, z, x", {1, 2, 0}},
                                           {"read as z, x, y", {2, 0, 1}}};
    return all;
}

}  // namespace plumb::parity
