// The two chunks of a GLB file: JSON, and the buffer that its accessors read. Private to io/.
#pragma once

#include <cstring>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::io {

class GlbParts {
  protected:
    using Json = nlohmann::ordered_json;
    enum Component : int { u32 = 5125, f32 = 5126 };
    enum Target : int { no_target = 0, vertices = 34962, indices = 34963 };

    // With every list that a file may have, empty.
    explicit GlbParts(const std::string& path);
    [[noreturn]] void fail(const std::string& cause) const;
    // Leaves out lists that stayed empty: glTF's may not be.
    void write_chunks();
    void use_extension(const char* name);
    void add_node(Json node);
    // Appends bytes to the buffer, zeros up to a multiple of 4, and returns the index of their view.
    std::size_t add_view(std::string bytes, int target);
    template <class T>
    std::size_t add_accessor(const std::vector<T>& values, const char* type, int component, int target) {
        std::string bytes(values.size() * sizeof(T), '\0');
        std::memcpy(bytes.data(), values.data(), bytes.size());
        const std::size_t view = add_view(std::move(bytes), target);
        json_["accessors"].push_back(
            {{"bufferView", view}, {"componentType", component}, {"count", values.size()}, {"type", type}});
        return json_["accessors"].size() - 1;
    }
    // With the bounds that glTF wants of them.
    std::size_t add_positions(const std::vector<glm::vec3>& values);
    static Json numbers(const glm::vec3& v);

    const std::string& path_;
    Json json_;

  private:
    std::vector<std::string> extensions_;
    std::vector<std::string> parts_;  // of the buffer, each a multiple of 4 bytes
    std::size_t bytes_ = 0;           // of all of them
};

}  // namespace plumb::io
