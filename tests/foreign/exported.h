// What `plumb export` wrote of tests/foreign/scene.toml: what the renderers of this folder get.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/image.h"
#include "io/manifest.h"

namespace plumb::foreign {

class Exported {
  public:
    // Runs the program; `folder` is where it writes to.
    explicit Exported(const std::string& folder);

    // Each throws for what was not exported.
    const io::ManifestStage& stage(const std::string& name) const;
    Image4 image(const std::string& stage, const std::string& input) const;
    std::vector<float> numbers(const std::string& stage, const std::string& input) const;  // a buffer's
    std::vector<double> uniform(const std::string& stage, const std::string& name) const;
    double number(const std::string& stage, const std::string& name) const { return uniform(stage, name).at(0); }
    glm::dvec3 vector(const std::string& stage, const std::string& name) const;

    int width() const { return stage("direct").width; }
    int height() const { return stage("direct").height; }

  private:
    io::Manifest manifest_;
};

// From the world's (x, 1) to clip space, y down, 0 <= z <= w.
using Clip = glm::dmat4;

// Of a view that plumb describes by rows from (x, 1) to texels (x and y, before the division) and to w.
Clip clip_of(const std::vector<double>& to_x, const std::vector<double>& to_y, const std::vector<double>& to_w,
             glm::ivec2 size, glm::dvec2 planes);
// The light's matrix as a shader has it, in place of the rows and the size of the map.
void set_light(io::ManifestStage& stage, const glm::mat4& clip, bool y_up = false);
void set(io::ManifestStage& stage, const std::string& name, const glm::vec3& value);

// The stage with its uniforms, without files and parameters.
io::ManifestStage bare(const Exported& exported, const std::string& name, const std::string& label);

}  // namespace plumb::foreign
