#include "gi/probes/export_sh.h"

#include <cmath>

#include "core/host_math.h"
#include "core/sh.h"

namespace plumb::probes {
namespace {

const std::vector<std::string> functions = {"1", "y", "z", "x", "xy", "yz", "3zz-1", "xz", "xx-yy"};
std::vector<std::string> first_functions(std::size_t count) { return {functions.begin(), functions.begin() + std::ptrdiff_t(count)}; }

// What the polynomials of `functions` are multiplied by to be orthonormal (Sloan 2008, "Stupid Spherical Harmonics Tricks").
double norm(int i) {
    static const std::array<double, 9> values = [] {
        const double l0 = std::sqrt(1 / (4 * host::pi)), l1 = std::sqrt(3 / (4 * host::pi)), l2 = std::sqrt(15 / (4 * host::pi)),
                     l20 = std::sqrt(5 / (16 * host::pi)), l22 = std::sqrt(15 / (16 * host::pi));
        return std::array<double, 9>{l0, l1, l1, l1, l2, l2, l20, l2, l22};
    }();
    return values[std::size_t(i)];
}
constexpr int degree_of(int i) { return i == 0 ? 0 : i < 4 ? 1 : 2; }
constexpr bool odd_order(int i) { return i == 1 || i == 3 || i == 5 || i == 7; }  // |m| = 1

std::vector<ShForm> make_forms() {
    // Columns: where our x, y and z go.
    const glm::dmat3 same(1), unity({1, 0, 0}, {0, 1, 0}, {0, 0, -1}), unreal({0, 1, 0}, {0, 0, 1}, {-1, 0, 0});
    std::vector<ShForm> forms(5);
    forms[int(ShOrder::unity)] = {"unity", 9, true, functions,
        "left-handed, +y up, metres: (x, y, -z) of the scene",
        "irradiance / pi, W/(m2 sr): convolved with the cosine, divided by pi, the functions' factors multiplied in",
        "irradiance / pi = sum of coefficient times polynomial", unity, 1};
    forms[int(ShOrder::unreal)] = {"unreal", 9, true, functions,
        "left-handed, +z up, centimetres: (-z, x, y) of the scene",
        "radiance, W/(m2 sr), in an orthonormal basis whose functions of odd m are negative",
        "irradiance = sum of coefficient times function times pi, 2 pi / 3, pi / 4 by degree", unreal, 100};
    forms[int(ShOrder::threejs)] = {"threejs", 9, false, functions,
        "right-handed, +y up, metres: as the scene",
        "radiance, W/(m2 sr), in an orthonormal basis without signs",
        "irradiance = sum of coefficient times function times pi, 2 pi / 3, pi / 4 by degree", same, 1};
    forms[int(ShOrder::l1)] = {"l1", 4, false, first_functions(4),
        "right-handed, +y up, metres: as the scene",
        "radiance, W/(m2 sr), in an orthonormal basis without signs: Y00, Y1-1, Y10, Y11",
        "irradiance = sum of coefficient times function times pi, 2 pi / 3 by degree", same, 1};
    forms[int(ShOrder::geomerics)] = {"geomerics", 4, false, {"1", "x", "y", "z"},
        "right-handed, +y up, metres: as the scene",
        "R0, the mean radiance, and R1 = mean of radiance times direction, W/(m2 sr)",
        "irradiance / pi = R0 + 2 R1 . n, or the curve that Geomerics fit to these two", same, 1};
    return forms;
}

const std::vector<ShForm>& forms() {
    static const std::vector<ShForm> all = make_forms();
    return all;
}

Radiance9 turned(const Radiance9& radiance, const glm::dmat3& to_engine) {
    if (to_engine == glm::dmat3(1)) return radiance;
    sh::Coefficients<glm::dvec3> c{};
    for (std::size_t i = 0; i < radiance.size(); ++i) c[i] = radiance[i];
    const sh::Coefficients<glm::dvec3> there = sh::Rotation(to_engine, 2)(c);
    Radiance9 result;
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = there[i];
    return result;
}

}  // namespace

const ShForm& sh_form(ShOrder order) { return forms().at(std::size_t(order)); }

std::vector<std::string> sh_order_names() {
    std::vector<std::string> names;
    for (const ShForm& form : forms()) names.push_back(form.name);
    return names;
}

std::vector<glm::dvec3> exported_sh(ShOrder order, const Radiance9& radiance) {
    const Radiance9 there = turned(radiance, sh_form(order).to_engine);
    std::vector<glm::dvec3> result(there.begin(), there.begin() + sh_form(order).coefficients);
    if (order == ShOrder::unity)
        for (int i = 0; i < 9; ++i) result[std::size_t(i)] *= sh::clamped_cosine()[std::size_t(degree_of(i))] / host::pi * norm(i);
    if (order == ShOrder::unreal)
        for (int i = 0; i < 9; ++i)
            if (odd_order(i)) result[std::size_t(i)] = -result[std::size_t(i)];
    if (order == ShOrder::geomerics) {
        // Means over the sphere: of L, and of L times x, y, z = Y_1m sqrt(4 pi / 3).
        const double mean = norm(0), first = 1 / std::sqrt(12 * host::pi);
        result = {there[0] * mean, there[3] * first, there[1] * first, there[2] * first};
    }
    return result;
}

glm::dvec3 exported_position(ShOrder order, const glm::dvec3& position) {
    return sh_form(order).length * (sh_form(order).to_engine * position);
}

}  // namespace plumb::probes
