// What `plumb formfactor` found, the verdict on it, and how it is printed.
#pragma once

#include <string>
#include <vector>

#include "gi/radiosity/hemicube_factor.h"
#include "tools/plumb/formfactor_shapes.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

struct FormFactorReport {
    const Shape *a = nullptr, *b = nullptr;
    radiosity::Between between;
    std::size_t pairs = 0;      // of faces
    bool with_contour = false;  // false: too many pairs
    radiosity::ContourFactor contour, contour_back;
    radiosity::RayFactor rays, rays_back;  // back: from B to A; not of a point
    std::int64_t ray_count = 0;
    int batches = 0;
    int points = 0;
    double at_points = 0;  // mean of Lambert's formula over the hemicubes' points
    struct Row {
        int size;
        double value;
    };
    std::vector<Row> hemicubes;
    struct Projected {
        std::string name;  // plane, fish-eye
        int size;
        double value;
    };
    std::vector<Projected> projections;  // as many texels as each hemicube; empty where none were asked for
    double view_deg = 0;                 // of them
    std::string weights;

    // judge() sets them.
    bool contour_holds = false;  // nothing hides a part of one from the other
    double sigmas = 0;           // rays less contour, in standard errors
    bool agrees = true;          // false: nothing hides, and rays and contour differ by more than 5
    std::string verdict;
};

void judge(FormFactorReport& report);
std::string form_factor_text(const FormFactorReport& report);
std::string form_factor_csv(const FormFactorReport& report);
Json form_factor_json(const FormFactorReport& report);

struct RotationRow {
    int size;
    radiosity::RotationErrors exact, centre;
};
std::string rotations_text(const std::vector<RotationRow>& rows);
std::string rotations_csv(const std::vector<RotationRow>& rows);
Json rotations_json(const std::vector<RotationRow>& rows);

}  // namespace plumb::cli
