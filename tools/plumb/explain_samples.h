// The values of one invocation as samples: what each one read, and what it brought.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/tap.h"
#include "gi/parity/side_by_side.h"

namespace plumb::cli {

// One pass through a kernel's loop: a run of values with the same sample.
struct Sample {
    int number = -1;                   // as the kernel counts
    std::size_t first = 0, last = 0;   // of the values: [first, last)
    std::optional<int> path, step;     // of a stage whose samples lie on paths
    std::optional<glm::dvec2> texel;   // of the map, or of the picture, that is read
    std::optional<double> slot, visibility, weight, form;
    bool inside = true;
    // weight visibility flux form, where the stage has flux and form; of a filter weight irradiance_i, or its weight; else
    // the step of a running sum or count, or what one light sends (E). Empty where nothing can be said.
    std::vector<double> contribution;
    std::vector<double> sum;  // the kernel's own running sum behind this sample

    // Rec. 709 luminance of three components, else the first one; what is no number, or negative, is 0.
    double brought() const;
    // By which samples are ordered: the luminance of what it brings without its signs; infinite where that is no number, which
    // must not be overlooked.
    double magnitude() const;
    bool brings_nothing() const;  // it is known, and 0
    bool hidden() const { return visibility && *visibility == 0; }
};

struct Samples {
    std::vector<Sample> all;        // in the kernel's order
    bool gathers = false;           // contributions are products of flux and form
    double most = 0;                // the largest brought()
    std::vector<double> together;   // contributions added up
    double total() const;           // brought() added up
};

// What a stage knows of its samples beyond their values.
struct SampleShape {
    int steps = 0;      // samples of a path, one path after another; 0: no paths
    int map_width = 0;  // texels: where the values name no texel, or name one by its index
    // Of a filter whose samples are the window around the pixel, row by row: as far as it reaches; below 0: no window.
    glm::ivec2 radius{-1};
    glm::ivec2 pixel{0};
};

// `values`: of our kernel.
Samples samples_of(const std::vector<TapValue>& values, const SampleShape& shape);
std::vector<TapValue> our_values(const parity::SideBySide& values);  // a line that ours lacks has no components

// Head and rows of the table of samples: of a gather sample, (path, step), texel, inside, (slot), (visibility), weight,
// form, contribution, sum; of another stage every value of a sample. `rows` name samples by their place in `all`.
struct SampleTable {
    std::vector<std::string> head;
    std::vector<std::vector<std::string>> rows;
};
SampleTable sample_table(const Samples& samples, const std::vector<TapValue>& values,
                         const std::vector<std::size_t>& rows);
std::vector<std::size_t> every_sample(const Samples& samples);

// Of [first, last) of `all` those that bring most first, as the kernel has them where they bring the same.
std::vector<std::size_t> by_contribution(const Samples& samples, std::size_t first, std::size_t last);
// Behind the samples that follow `first` without a value of another kind between them.
std::size_t end_of_run(const Samples& samples, std::size_t first);
// The same values; the samples of each run in that order.
std::vector<TapValue> by_contribution(const std::vector<TapValue>& values);
// "12 of 37 samples bring 0"; "" where what they bring is not known.
std::string nothing_brought(const Samples& samples);

// Of a gather the table of the samples that bring something, largest first, with the sum below; of any other stage with samples
// how many bring nothing, where that is known; else "".
std::string samples_text(const std::vector<TapValue>& values, const SampleShape& shape);

}  // namespace plumb::cli
