// plumb explain --html: a stage's buffers as pictures with the pixel and the samples on them, and the numbers beside.
//
// Knows no stage: a picture is an input of the stage's binding, a sample is a run of values with one number, and where it
// lies is its value "texel".
#pragma once

#include <string>
#include <vector>

#include "core/binding.h"
#include "gi/frame/frame_graph.h"
#include "tools/page/page.h"
#include "tools/plumb/explain_samples.h"

namespace plumb::cli {

// One dispatch or draw at one pixel.
struct ExplainedStage {
    std::string label;     // "rsm.disc (bulb) px"
    std::string source;    // of the stage: "VRSM Algorithm 4"
    glm::ivec2 pixel{0};   // of the dispatch's outputs
    const StageBinding* binding = nullptr;  // null: the buffers have no names, and no pictures
    const StageData* data = nullptr;        // with the binding
    const Bundle* outputs = nullptr;        // pictured where given, by the names of the binding's outputs
    parity::SideBySide values;
    std::string device;              // empty: ours alone
    std::vector<std::string> notes;  // the checks, or what the device says
    std::vector<frame::ItemPicture> pictures = {};  // of the item alone
    bool item = false;               // `pixel` is an item of a list: x, or of a list folded into rows
};

class ExplainPage {
  public:
    explicit ExplainPage(const std::string& title);

    // The picture that all of it leads to, sRGB-encoded, with the pixel on it.
    void picture(const Image4& display, glm::ivec2 pixel);
    void add(const ExplainedStage& stage);
    std::string html() const { return page_.html(); }

  private:
    page::Page page_;
    int stages_ = 0;
};

// A picture for a page, with what is drawn over it.
struct DrawnPicture {
    Image<std::uint32_t> texels;
    std::string caption;
    page::Overlay overlay;
};
// The samples of an invocation on what they read: the light of its map first of all. None of a stage without samples that
// have a place, or with so many that marks would hide each other.
std::vector<DrawnPicture> sample_plot(const StageBinding& binding, const StageData& data, glm::ivec2 pixel,
                                      const std::vector<TapValue>& values);

// Paths, windows and maps as the stage's uniform block and inputs have them.
SampleShape sample_shape(const StageBinding* binding, const StageData* data, glm::ivec2 pixel);

// A page lists no more samples than that: those that bring most. Above the second number marks are a picture of their own.
inline constexpr std::size_t most_rows = 1000, most_marks = 4096;

}  // namespace plumb::cli
