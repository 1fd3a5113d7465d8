// What every uniform of every stage means.
#pragma once

#include "core/binding.h"
#include "core/uniform_words.h"
#include "raster/uniform_words.h"

namespace plumb {

// Null where nobody has said it: a test misses it.
const UniformWords* words_of(const StageBinding& binding, const std::string& member);

// Of each folder, in its uniform_words.cpp; of raster/ beside its passes.
namespace compose { std::vector<StageWords> uniform_words(); }
namespace ddgi { std::vector<StageWords> uniform_words(); }
namespace direct { std::vector<StageWords> uniform_words(); }
namespace filter { std::vector<StageWords> uniform_words(); }
namespace isr { std::vector<StageWords> uniform_words(); }
namespace probes { std::vector<StageWords> uniform_words(); }
namespace radiosity { std::vector<StageWords> uniform_words(); }
namespace rsm { std::vector<StageWords> uniform_words(); }
namespace screen { std::vector<StageWords> uniform_words(); }
namespace zbuffer { std::vector<StageWords> uniform_words(); }

}  // namespace plumb
