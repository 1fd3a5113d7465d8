// Cornell University Program of Computer Graphics, "The Cornell Box: Physical model" (measured data of the real box):
// corners in millimetres, x to the left as its camera sees it, y up, z away from the camera.
//
// Ours: turned half around the vertical axis, so that the camera looks along -z; scaled so that the ceiling is 2 m
// high; centred on the camera's axis (x = 278) and on the middle of the depth (z = 279.6). The ceiling has the hole
// that the lamp fills, where the published faces lie upon each other. A half turn and a scale keep the faces'
// direction: all front sides look into the room.
#include "io/cornell.h"

#include <fmt/format.h>

#include <array>
#include <vector>

namespace plumb::io {
namespace {

struct Point {
    double x, y, z;
};
using Quad = std::array<Point, 4>;

constexpr double height = 548.8, depth = 559.2;

class ObjText {
  public:
    void group(const std::string& name, const std::string& material) {
        text_ += fmt::format("\ng {}\nusemtl {}\n", name, material);
    }
    void quad(const Quad& q) {
        constexpr double scale = 2 / height;
        for (const Point& p : q)
            text_ += fmt::format("v {:.6f} {:.6f} {:.6f}\n", (278 - p.x) * scale, p.y * scale, (279.6 - p.z) * scale);
        text_ += fmt::format("f {} {} {} {}\n", count_ + 1, count_ + 2, count_ + 3, count_ + 4);
        count_ += 4;
    }
    // A block on the floor: its top, counter-clockwise from above, and the four sides below it.
    void block(double top, const std::array<std::array<double, 2>, 4>& ring) {
        Quad lid;
        for (std::size_t i = 0; i < 4; ++i) lid[i] = {ring[i][0], top, ring[i][1]};
        quad(lid);
        for (std::size_t i = 0; i < 4; ++i) {
            const Point a = lid[i], b = lid[(i + 1) % 4];
            quad({a, Point{a.x, 0, a.z}, Point{b.x, 0, b.z}, b});
        }
    }
    const std::string& text() const { return text_; }

  private:
    std::string text_ = "# The Cornell box, in metres (plumb make-scene cornell)\nmtllib cornell.mtl\n";
    int count_ = 0;
};

}  // namespace

std::string cornell_obj() {
    const Quad lamp = {{{343, height, 227}, {343, height, 332}, {213, height, 332}, {213, height, 227}}};
    const Quad ceiling = {{{556, height, 0}, {556, height, depth}, {0, height, depth}, {0, height, 0}}};

    ObjText obj;
    obj.group("floor", "white");
    obj.quad({{{552.8, 0, 0}, {0, 0, 0}, {0, 0, depth}, {549.6, 0, depth}}});
    obj.group("ceiling", "white");
    for (std::size_t i = 0; i < 4; ++i) obj.quad({ceiling[i], ceiling[(i + 1) % 4], lamp[(i + 1) % 4], lamp[i]});
    obj.group("lamp", "lamp");
    obj.quad(lamp);
    obj.group("back_wall", "white");
    obj.quad({{{549.6, 0, depth}, {0, 0, depth}, {0, height, depth}, {556, height, depth}}});
    obj.group("right_wall", "green");
    obj.quad({{{0, 0, depth}, {0, 0, 0}, {0, height, 0}, {0, height, depth}}});
    obj.group("left_wall", "red");
    obj.quad({{{552.8, 0, 0}, {549.6, 0, depth}, {556, height, depth}, {556, height, 0}}});
    obj.group("short_block", "white");
    obj.block(165, {{{130, 65}, {82, 225}, {240, 272}, {290, 114}}});
    obj.group("tall_block", "white");
    obj.block(330, {{{423, 247}, {265, 296}, {314, 456}, {472, 406}}});
    return obj.text();
}

// Kd: the published spectral reflectances (every 4 nm from 400 to 700) at three wavelengths, taken as linear R, G, B:
// 650 nm (mean of 648 and 652), 510 nm (mean of 508 and 512) and 476 nm. The lamp's 0.78 is published too; its exitance
// is ours, so small beside the spot (1.1 W of 38 W) that it shows where the lamp is and hardly lights anything.
std::string cornell_mtl() {
    return R"(# The Cornell box: measured reflectances at 650, 510 and 476 nm
newmtl white
Kd 0.7295 0.7355 0.729

newmtl red
Kd 0.611 0.0555 0.062

newmtl green
Kd 0.117 0.4125 0.115

# Ke: radiant exitance, W/m2
newmtl lamp
Kd 0.78 0.78 0.78
Ke 6 6 6
)";
}

// The camera is the published one: (278, 273, -800), 35 mm focal length, 25 mm film; fov 2 atan(12.5 / 35).
std::string cornell_toml() {
    return R"(# The Cornell box with a spot under its lamp (plumb make-scene cornell)
seed = 1

[frame]
size = [1024, 1024]

[camera]
position = [0, 0.995, 3.934]     # m
look_at = [0, 0.995, 0]
up = [0, 1, 0]
fov_y_deg = 39.3077
near = 0.1
far = 100

[[mesh]]
file = "cornell.obj"

[[light]]
name = "key"
type = "spot"
position = [0, 1.97, 0]
direction = [0, -1, 0]
cone_deg = [55, 65]              # inner, outer half angle
intensity = [12, 12, 12]         # W/sr
rsm_size = 1024

[render]
method = "rsm"

[shadow]
pcf_kernel = 2                   # a border of two texels shows no stairs

[rsm]                            # samples span the map, so that the ceiling, which the map does not see, gathers all
radius = 1
projection = "clamped"
thickness = 0.1                  # m: of what a sample stands for
)";
}

}  // namespace plumb::io
