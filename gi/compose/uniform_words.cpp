#include "gi/uniform_words.h"

namespace plumb::compose {

std::vector<StageWords> uniform_words() {
    return {
        {"compose",
         {{"environment", "W/(m2 sr)", "xyz: radiance where no surface is", "0: black"},
          {"inv_pi", "1/sr", "radiance of a Lambertian surface of radiosity 1: 1 / pi = 0.31830987"},
          {"shadowed", "", "1: shadow_color is added where no direct light falls", "0: nothing is added"},
          {"shadow_color", "W/(m2 sr)", "xyz: radiance of a surface without direct light", "0"}}},
        {"tonemap",
         {{"op", "", "0 clamp, 1 exposure 1 - exp(-e L), 2 Reinhard, 3 filmic"},
          {"exposure", "", "factor of the radiance before the curve", "1"},
          {"dimmer", "", "another factor before the curve", "1"},
          {"contrast", "", "power about middle grey, 0.18", "1: left out"},
          {"inv_gamma", "", "1 / gamma of the display; 0: the curve of sRGB"}}},
    };
}

}  // namespace plumb::compose
