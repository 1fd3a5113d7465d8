// What `plumb formfactor` is asked about: names of a scene's parts, polygons and points, and the geometry that they lie
// in.
#pragma once

#include <string>
#include <vector>

#include "core/scene.h"
#include "gi/radiosity/ray_form_factors.h"

namespace plumb::cli {

struct Shape {
    std::string words;  // "polygon of 4 corners", "object \"lamp\""
    radiosity::RaySource source;
    bool closed = false;                   // a surface without border: its fronts alone count
    std::vector<std::uint32_t> triangles;  // of the geometry; of a point none

    bool is_point() const { return source.faces.empty(); }
    radiosity::Sides sides() const { return closed ? radiosity::Sides::front : radiosity::Sides::both; }
};

struct ShapePair {
    Scene scene;  // with a mesh for each polygon that was given, before its own
    Geometry geometry;
    Shape a, b;
};

// "x,y,z;x,y,z;x,y,z ..." is a polygon, "x,y,z/nx,ny,nz" a point and its normal (a alone); a whole number is a triangle
// of the scene, all else an object or a material of it, with object: or material: before it where both have the name.
// Round brackets and spaces around them are left out. `scene` may be null. Throws InputError.
ShapePair find_shapes(const std::string& a, const std::string& b, const Scene* scene);

}  // namespace plumb::cli
