// A volume of DDGI's probes over a scene: rays, rounds of light, and what the probes tell a point.
//
//     grid_over()  where probes stand
//     Volume       their two atlases, updated a round at a time, or until nothing changes
//     sample()     irradiance at points
#pragma once

#include <vector>

#include "core/fields.h"
#include "gi/ddgi/blend.h"
#include "gi/ddgi/sample.h"
#include "gi/probes/lit_hits.h"

namespace plumb::ddgi {

// count.x x count.y x count.z probes within low .. high, the outer ones `inset` spacings from its faces: the centres of equal
// boxes, or with 0 probes on the faces. Throws InputError for counts below 1, an inset that is not 0 to 1, and a scene without
// extent along an axis of more than one probe.
//
// differs: DDGI 2019 leaves the place of the grid to the artist; where the scene ends in walls, probes on its faces are blind.
Grid grid_over(const glm::vec3& low, const glm::vec3& high, const glm::ivec3& count, double inset = 0.5);

// fields() says what each means.
struct VolumeParams {
    int side = 8;
    int depth_side = 16;
    int rays = 256;
    int sharpness = 50;
    bool turned = false;
    int seed = 1;
    float hysteresis = 0;
    float normal_bias = 0.2f;
    float view_bias = 0.8f;
    float bias = 0.225f;
    float farthest = 1.5f;
    float back_share = 0.2f;
    bool visibility = true;
    bool wrapped = true;
    bool root = false;
    float crush = 0.2f;
    float energy = 1;
    bool packed = false;
    int rounds = 64;
    float change = 1e-3f;
};
std::vector<Field> fields(VolumeParams& params);

// The rotation of a round, uniform over all rotations; the first one's is none (Shoemake 1992, "Uniform Random Rotations").
glm::dmat3 rotation_of(std::uint32_t seed, int round);

class Volume {
  public:
    // The scene must outlive it. Throws InputError for parameters out of range, or an atlas of more than 32767 texels a side.
    Volume(const probes::LitScene& scene, const Grid& grid, const VolumeParams& params);

    // Rays (where they are new), moments, and radiance with the last round's irradiance.
    void round(const RunOptions& options);
    // Rounds until no texel changes by more than `change` of the mean, or params.rounds of them. Turned rays never settle: all
    // rounds are run. Returns how many.
    int converge(const RunOptions& options);

    // Irradiance at points that are seen along `view` (unit, towards the viewer), W/m2; w: sum of the weights.
    Image4 sample(const Image4& position, const Image4& normal, const Image4& view, const RunOptions& options) const;

    const Grid& grid() const { return grid_; }
    const VolumeParams& params() const { return params_; }
    const Buffer<glm::vec4>& probes() const { return probes_; }  // xyz m
    const Image4& irradiance() const { return irradiance_; }
    const Image4& moments() const { return moments_; }
    int rounds() const { return rounds_; }
    std::uint64_t rays() const { return rays_; }  // traced, those to lamps included
    // On a GPU, as DDGI 2019 stores it: 4 bytes a texel (R11G11B10F, RG16F), gutters included.
    std::size_t bytes() const;
    // What the stages of another round would be given: both blends, a border, and a sample at what the rays met. They own it.
    std::vector<StageData> dispatches() const;
    SampleInputs sample_inputs(const Image4& position, const Image4& normal, const Image4& view) const;

  private:
    void trace(const RunOptions& options);
    BlendInputs blend_inputs(const Image4& atlas, bool moments) const;
    void blend(Image4& atlas, bool moments, const RunOptions& options) const;

    const probes::LitScene& scene_;
    Grid grid_;
    VolumeParams params_;
    Buffer<glm::vec4> probes_, directions_;
    probes::LitHits hits_;
    Image4 lit_;  // of each ray: radiance, and distance, m
    Image4 irradiance_, moments_;
    int rounds_ = 0;
    std::uint64_t rays_ = 0;
    double change_ = 0;  // largest of the last round, over the mean
};

}  // namespace plumb::ddgi
