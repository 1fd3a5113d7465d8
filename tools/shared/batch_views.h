// Goes through the views of camera lists one after the other and keeps their path traced truths, for plumb batch and
// plumb experiment isr.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gi/reference/cache.h"
#include "io/camera_list.h"
#include "tools/shared/reference_files.h"

namespace plumb::cli {

inline constexpr int least_side = 16;  // of a view, pixels

// A view of a list: where it is from, and what its files are called.
struct BatchView {
    std::size_t list = 0;   // index of its list
    std::size_t index = 0;  // in its list
    std::string name;       // "isr_simple_cornell_01": unique over all lists
    std::string group;      // the list's name: "isr_simple"
};

// Opens a scene once for all views of it that follow each other.
class BatchScenes {
  public:
    explicit BatchScenes(const std::vector<std::string>& lists);

    const std::vector<BatchView>& views() const { return views_; }
    const io::ListedCamera& listed(const BatchView& view) const;
    // The scene in the view's pose, of `size` pixels. It stays until the next call with another view.
    const Scene& scene(const BatchView& view, glm::ivec2 size);
    // Of all of the view's scene that light depends on, and its camera: not of settings.
    std::uint64_t content(const BatchView& view, glm::ivec2 size);
    std::size_t triangles() const { return triangles_; }  // of the scene that is open

  private:
    void open(const BatchView& view);

    std::vector<io::CameraList> lists_;
    std::vector<BatchView> views_;
    std::string word_;  // of the scene that is open
    Scene loaded_, posed_;
    std::uint64_t loaded_content_ = 0;
    std::size_t triangles_ = 0;
};

// Hashes everything of a scene that sends, stops or reflects light.
std::uint64_t light_hash(const Scene& scene);

// A truth of a view by the path tracer, all bounces, kept in a folder of its own under a key of the view, not of the
// program: a build that traces otherwise raises truth_version.
inline constexpr std::uint64_t truth_version = 1;
class BatchTruths {
  public:
    BatchTruths(const std::string& folder, int samples) : samples_(samples), files_(folder, max_bytes, truth_version) {}
    reference::KeptEstimate of(BatchScenes& scenes, const BatchView& view, glm::ivec2 size, const RunOptions& options);
    int traced() const { return traced_; }  // that were not there
    const std::vector<std::string>& notes() const { return files_.notes(); }

  private:
    static constexpr std::uint64_t max_bytes = std::uint64_t(64) << 30;
    int samples_, traced_ = 0;
    ReferenceFiles files_;
};

}  // namespace plumb::cli
