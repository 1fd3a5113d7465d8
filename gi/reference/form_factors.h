// Form factors in closed form, with their numbers in Howell, "A Catalog of Radiation Heat Transfer Configuration
// Factors". A patch is a differential area. Lengths in m, angles in radians; all above 0.
#pragma once

namespace plumb::reference {

// C-11: between rectangles a x b, the one straight above the other, c apart.
double opposed_rectangles(double a, double b, double c);
// C-14: from a rectangle to another at a right angle; they share an edge of length `shared`, from which they reach
// `depth` and `height`.
double perpendicular_rectangles(double shared, double depth, double height);

// B-12: to a disc on the patch's axis, parallel to it.
double patch_to_disc(double radius, double distance);
// B-13: the disc's axis lies `aside` of the patch's, 0 or more.
double patch_to_disc_aside(double radius, double distance, double aside);
// B-14: to a disc in a plane at a right angle to the patch's, `distance` from the patch to that plane; the disc's axis
// lies `aside` in front of the patch, more than its radius.
double upright_patch_to_disc(double radius, double distance, double aside);
// The patch lies on the disc's axis and is turned away from it by `angle`, 0 to pi: as much of the disc as stands above
// its horizon. A disc seen from its axis is a cone, as a sphere is: B-12 and the two parts of the sphere's (Juul 1979).
double tilted_patch_to_disc(double radius, double distance, double angle);

// C-41: from a disc to another on the same axis.
double coaxial_discs(double from, double to, double distance);
// C-125: from a sphere to a disc whose axis goes through its middle, `distance` away; the sphere's radius is all the
// same as long as it does not reach the disc's plane.
double sphere_to_coaxial_disc(double disc, double distance);

}  // namespace plumb::reference
