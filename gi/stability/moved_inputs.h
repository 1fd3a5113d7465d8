// Lists the inputs of a dispatch and moves each of them by one ULP.
#pragma once

#include <string>
#include <vector>

#include "core/binding.h"

namespace plumb::stability {

// Numbers that are moved at once: every `stride`-th float from `first` on.
struct Input {
    std::string name;  // "position.x"
    unsigned char* bytes;
    std::size_t first, stride, count;
};

// All inputs of `data`, which they point into: columns of images and buffers, the numbers of a small buffer, the
// numbers of the uniform block. Integers and what is `fixed` are left out.
std::vector<Input> inputs_of(const StageBinding& binding, StageData& data);

// How many ways there are to move an input: `patterns` of signs, or up and down where it is one number.
int ways_to_move(const Input& input, int patterns);

// x one ULP up, or down; where that is no finite number, the other way. 0 and what is not finite stay.
float moved(float x, bool up);

// Moves an input in that way; false where nothing moved. `before` gets what there was.
bool move(const Input& input, int way, std::vector<float>& before);
void put_back(const Input& input, const std::vector<float>& before);

}  // namespace plumb::stability
