// plumb experiment ipr: pictures as its page shows them.
#pragma once

#include <optional>
#include <vector>

#include "core/signed_error.h"
#include "core/view.h"

namespace plumb::cli {

inline constexpr double ipr_swing = 0.5;  // relative error of full colour

// What one pixel of fifty exceeds; above 0.
double white_of(const Image4& radiance);
// sRGB's exponent; 0..1.
Image4 displayed(const Image4& radiance, double white);

std::optional<double> ssim_of(const Image4& a, const Image4& b);
// The index of the window around each pixel, grey: 1 white, 0 and below black; beyond the last whole window the nearest one's. Its mean
// over whole windows is ssim_of(). Empty where that is none.
Image4 ssim_map(const Image4& a, const Image4& b);

// Blue too dark, red too bright; grey what is not compared. floor: beside the local truth, W/m2 as the planes.
Image4 error_picture(const compare::Plane& own, const compare::Plane& truth, const compare::Plane& error, const Image<std::uint8_t>& compared,
                     double floor);

// Balls of so many metres, at least a pixel, where nothing nearer to the eye is. seen: w linear depth, m; 0: nothing; empty:
// nothing hides any.
void draw_balls(Image4& picture, const Image4& seen, const View& view, const std::vector<glm::dvec3>& centres, double radius_m,
                const glm::vec3& colour);

// Every k-th texel, so that neither side is longer than `side`.
Image4 smaller(const Image4& image, int side);

}  // namespace plumb::cli
