// A stage of a manifest, made into what the judge takes: the data of one dispatch, and what the device made of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gi/frame/frame.h"
#include "gi/parity/verdict.h"
#include "io/manifest.h"

namespace plumb::cli {

struct StageCase {
    const StageBinding* binding = nullptr;
    StageData data;
    std::vector<parity::Dumped> dumped;
    std::vector<std::int32_t> choices;  // [height][width][choices_a_pixel], or empty
    int choices_a_pixel = 0;
    std::vector<bool> covered;       // where something is seen, as [stage.coverage] or a depth buffer says; empty: everywhere
    std::vector<std::string> notes;  // what was assumed
};

// Reads the stages of one manifest, and its scene once.
class CaseReader {
  public:
    // What a device makes of its inputs before it reads them errs as much as the profile grants. Throws InputError where
    // there is a scene that cannot be read.
    explicit CaseReader(const io::Manifest& manifest, const DeviceProfile& profile = {});

    // Throws InputError of one line that begins with the stage's place and names what is missing, has the wrong size or
    // is not known.
    StageCase read(const io::ManifestStage& stage) const;

  private:
    StageData data_of_scene(const io::ManifestStage& stage, const StageBinding& binding) const;

    std::optional<Scene> scene_;
    DeviceProfile profile_;
};

// The stage's data as the frame of a scene would bind it, with images of zeros where `frame` was not executed; one for
// each map of a point light. Leaves out every other stage.
std::vector<StageData> dispatches(const Scene& scene, const frame::Settings& settings, const frame::Plan& plan,
                                  const frame::Frame& frame, const frame::PlannedStage& stage);

// The face of a point light's map that the data belongs to, "px" to "nz"; else "".
std::string face_of(const StageData& data);

}  // namespace plumb::cli
