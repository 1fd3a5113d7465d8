// Finds out how a device rounds: single operations, stores, filters and rasterisation, against what is exact, and which
// device profile that fits (README.md).
#pragma once

#include <string>
#include <vector>

#include "core/device_profile.h"
#include "raster/visibility.h"
#include "tools/vulkan/device.h"

namespace plumb::vulkan {

enum class Denormals : int { not_met, kept, flushed, both };
const char* denormals_text(Denormals denormals);

// One operation over hashed inputs. Shares and errors are of inputs and exact results that are neither denormal nor
// beyond the largest float.
struct OperationFigures {
    std::string name;           // as GLSL writes it: "a + b"
    int inputs = 0;             // that these figures are of
    double off = 0;             // how many of them are not the nearest float; of what has no exact result here: 0
    double worst_ulp = 0;       // farthest from the exact result, in units of its last place
    double worst_absolute = 0;
    double worst_at = 0;        // the first operand there
    Denormals denormals = Denormals::not_met;
    std::string formula;        // of the ways to compute it the one with all bits of the device; "" for none of them
};

// The errors of an approximation that is granted more where something is larger: worst[k] is of what lies in
// [k/1024, (k+1)/1024), or in [2^(k - 24), 2^(k - 23)).
using GradedError = std::vector<double>;

// Triangles in clip space, three corners each, and what the device made of them.
struct DrawnTriangles {
    glm::ivec2 size;
    std::vector<glm::vec4> corners;
    raster::VisibilityBuffer drawn;
};
// How many pixels of these a profile has otherwise.
struct RasterDifferences {
    int pixels = 0, triangle = 0, depth = 0, barycentrics = 0;
    bool none() const { return pixels > 0 && triangle + depth + barycentrics == 0; }
};
RasterDifferences compare_drawing(const DrawnTriangles& triangles, const DeviceProfile& profile);

// Which grid the corners of triangles are placed on: 256 corners, 2^-11 pixel
// apart, each seen in where its triangle's edge crosses a column of 4096 centres.
struct SnappingFigures {
    int bits = 0;              // 0: none of the grids that were tried
    std::string ties;          // "to even", "up", "down"; "towards zero" where nothing is rounded to nearest
    double displacement = 0;   // pixels: how far the corner seems to be from where it should be, at most
};

struct StoreFigures {
    std::string name;          // "rgba16f storage image"
    int values = 0;            // components stored; 0: not supported
    int not_nearest = 0, not_truncated = 0, neither = 0;
    int not_cut = 0;           // components of 10 bits that are not the first ones of 16, others not nearest
    std::string example{};     // of one that is not the nearest
};

struct FilterFigures {
    std::string format;
    bool supported = false;
    int weights = 0;           // distinct ones, of 65,536 places between two texels
    int bits = 0;              // of a weight; 0: as many as a float has
    double worst = 0;          // deviation from the exact mean of four texels in 0..1
};

struct Probe {
    std::string device, driver;
    std::vector<OperationFigures> operations;
    std::string minimum_of_nan, maximum_of_nan;  // what min() and max() return where one operand is NaN
    GradedError exp2;                            // of exp2 and exp, in units, by |x|
    GradedError log2;                            // absolute, by the exponent of log2 x
    std::vector<StoreFigures> stores;
    std::string half_overflow;                   // what numbers beyond the largest half become
    std::vector<FilterFigures> filters;
    SnappingFigures snapping;
    int shared_edges = 0;                        // pixels that the top-left rule gives to another triangle
    DrawnTriangles inside, clipped;              // within the frame, and across its planes
};
Probe probe_device(const Device& device);

// The parts, in their own files.
void probe_operations(const Device& device, Probe& probe);
void probe_stores(const Device& device, Probe& probe);
void probe_filters(const Device& device, Probe& probe);
void probe_rasterisation(const Device& device, Probe& probe);

// Figures of one operation by its name; throws std::out_of_range for another one.
const OperationFigures& operation(const Probe& probe, const std::string& name);

// ---- Profiles -------------------------------------------------------------------------------------------------------

// A field of DeviceProfile: what was measured, what a profile says, and whether it allows that.
struct ProfileField {
    std::string name, measured, stated;
    bool fits;
};
std::vector<ProfileField> compare_fields(const Probe& probe, const DeviceProfile& profile);
bool fits(const Probe& probe, const DeviceProfile& profile);

// The one that fits: those with a rasteriser of their own first, then those of a driver; null where none does.
const DeviceProfile* fitting_profile(const Probe& probe, const std::vector<DeviceProfile>& profiles);

// A profile that fits, made of what was measured, and C++ that makes it.
DeviceProfile measured_profile(const Probe& probe, const std::string& name);
std::string profile_source(const DeviceProfile& profile);

}  // namespace plumb::vulkan
