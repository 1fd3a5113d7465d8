// OpenGL 4.5 without a window (EGL, surfaceless), and passes over the whole frame.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "tests/foreign/textures.h"

namespace plumb::foreign::gl {

enum class Filter { nearest, linear };
enum class Border { edge, black, white };

struct Sampled {
    std::string name;  // of the sampler in the shader
    Texture texture;
    Filter filter = Filter::nearest;
    Border border = Border::edge;
    bool compares = false;  // of depth: a sampler2DShadow
};
struct Uniform {
    std::string name;
    int components = 1;  // 1 to 3 floats, 16: a mat4 by columns, 0: an int
    std::vector<float> values;
};

// Throws std::runtime_error, with the causes, where no device has `name` in its own.
class Context {
  public:
    explicit Context(const std::string& name);
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    std::string device() const;
    // A triangle over all of `size`, into targets of these formats. Textures and results have their lowest row first.
    // Throws for what does not compile.
    std::vector<Texture> draw(glm::ivec2 size, const std::string& vertex, const std::string& fragment,
                              const std::vector<Sampled>& textures, const std::vector<Uniform>& uniforms,
                              const std::vector<std::string>& formats);

  private:
    struct Handles;
    std::unique_ptr<Handles> handles_;
};

}  // namespace plumb::foreign::gl
