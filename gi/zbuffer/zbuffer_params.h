// The parameters of the z-buffer techniques: the table [zbuffer] of a scene file.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/fields.h"

namespace plumb::zbuffer {

// HEM 5.3, 5.4: C colour, A ambient, D diffuse, S specular; (P) per pixel, else per vertex.
enum class Technique : int { c, ca, cad, cas, cads, cas_p, cads_p };
enum class Lobe : int { phong, blinn };
enum class Variant : int { corrected, published };
enum class Range : int { hdr, saturate };

struct ZbufferParams {
    Technique technique = Technique::cads_p;
    Lobe lobe = Lobe::phong;
    Variant variant = Variant::corrected;
    Range range = Range::hdr;
    bool renormalise = true;
    glm::vec3 ambient{0.2f};     // W/(m2 sr)
    bool normals = false;
    float normal_length = 0.02f;  // of the scene's diagonal
};
std::vector<Field> fields(ZbufferParams& params);
// Throws InputError that names the parameter.
void validate(const ZbufferParams& params);

inline bool per_pixel(Technique t) { return t == Technique::cas_p || t == Technique::cads_p; }
inline bool has_ambient(Technique t) { return t != Technique::c; }
inline bool has_diffuse(Technique t) { return t == Technique::cad || t == Technique::cads || t == Technique::cads_p; }
inline bool has_specular(Technique t) { return t >= Technique::cas; }
inline bool saturates(const ZbufferParams& p) { return p.range == Range::saturate || p.variant == Variant::published; }

}  // namespace plumb::zbuffer
