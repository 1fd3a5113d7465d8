// Pictures of one size side by side in one image, a sheet: block 0 is of mirrors, block j of the j-th ray of each pixel's lobe.
#pragma once

#include <glm/glm.hpp>

namespace plumb::screen {

// How many pictures lie beside each other: as many as below each other, or one more.
inline int sheet_across(int blocks) {
    int across = 1;
    while (across * across < blocks) ++across;
    return across;
}
inline glm::ivec2 sheet_of(glm::ivec2 picture, int blocks) {
    const int across = sheet_across(blocks);
    return {picture.x * across, picture.y * ((blocks + across - 1) / across)};
}

}  // namespace plumb::screen
