// A scene of a sweep, and what its pictures would be without an error.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gi/reference/cache.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

struct Subject {
    Scene scene;
    frame::Settings settings, truth;  // the scene's own; what the truths are traced with
    reference::Estimate full;
    std::map<frame::Method, reference::Estimate> own;  // as radiance; none where full is its own
};

// Throws InputError for all that is wrong with scene, settings and the truth's samples.
Subject load_subject(const SweepRequest& request, SceneOptions options);

// Fills `scene` but for its name, and the pictures, where they are asked for. `store` and `pictures` may be null.
void trace_truths(const RunOptions& options, reference::Store* store, Subject& subject, SweptScene& scene,
                  std::vector<std::string>& notes, ScenePictures* pictures);

// One line on a terminal, in place of the one before; empty: none.
void show_progress(const std::string& text);

}  // namespace plumb::cli
