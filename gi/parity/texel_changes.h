// What may be done to the numbers of a texel by mistake. Private to gi/parity/.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/binding.h"

namespace plumb::parity {

// y = f(x) that never falls: of an interval it may be taken at both ends.
struct Curve {
    std::string text;
    double (*at)(double);
};
// Colour spaces, clamps, steps of formats, powers.
const std::vector<Curve>& curves();

// Three numbers in another order: "x and y swapped".
struct Order {
    std::string text;
    int from[3];
};
const std::vector<Order>& orders();

// What a result becomes: [low, high], and what a float rounds; or a multiple.
void put(BoundedValue& value, double low, double high);
void scale(BoundedValue& value, double by);

double srgb_to_linear(double encoded);  // IEC 61966-2-1, also below 0 and above 1
double linear_to_srgb(double linear);

}  // namespace plumb::parity
