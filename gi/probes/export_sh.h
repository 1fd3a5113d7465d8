// Probes in the spherical harmonics of engines: orders, signs, factors and axes of their coefficients.
//
// What goes in is radiance L_lm to degree 2 in the world of scenes (right-handed, +y up) by core/sh.h. README.md of this folder
// says where each engine's form is known from. No engine is linked or run: tests evaluate each form by its own formula.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb::probes {

enum class ShOrder : int { unity, unreal, threejs, l1, geomerics };

struct ShForm {
    std::string name;                       // as the command line has it
    int coefficients = 9;                   // of a channel
    bool by_channel = false;                // a list of coefficients for each of red, green, blue; or of three numbers each
    std::vector<std::string> basis;         // of each coefficient: the polynomial of the unit direction (x, y, z)
    std::string axes, quantity, evaluation; // in words
    glm::dmat3 to_engine{1};                // directions: orthogonal, left-handed where its determinant is -1
    double length = 1;                      // the engine's units a metre
};
const ShForm& sh_form(ShOrder order);
std::vector<std::string> sh_order_names();

using Radiance9 = std::array<glm::dvec3, 9>;  // index l (l + 1) + m

// The coefficients of that form: as many as it has.
std::vector<glm::dvec3> exported_sh(ShOrder order, const Radiance9& radiance);
glm::dvec3 exported_position(ShOrder order, const glm::dvec3& position);

}  // namespace plumb::probes
