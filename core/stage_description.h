// What a stage says of itself, once: one aggregate, from which everything else about it follows (core/kernel_stage.h).
//
// Kernel is a struct beside the algorithm, in <stage>_kernel.h:
//
//     using View = BlurView;                        the twin's block as member u, and a pointer for each input and output
//     static vec4<F> item<F>(const View&, index_t<F> x, index_t<F> y, Tap&)     one item of the domain; or F
//     static float* out(const View&)                where it goes; of several outputs: store<F>(View, at, value, active)
//     static mask_t<F> writes<F>(const View&, x, y)                   optional: which items this dispatch writes
//     static std::size_t scratch(const View&, int rows)               optional: floats that a band of rows needs
//     static constexpr int band                                       optional: rows of a band, 16
//     static std::size_t shared_floats(const View&), static int shared_rows(const View&)
//                                                                     optional: what all bands read, member `shared` of View
//
// and describe(Kernel) in <stage>.h returns its StageDescription. Binding numbers, types of buffers, names and offsets
// of the block's members come from the twin.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/bundle.h"
#include "core/stage.h"

namespace plumb {

// A member of View that points to an input or an output: &BlurView::normal.
template <class View>
struct PointerOf {
    std::function<void(View&, const void*)> set;

    template <class T>
    PointerOf(const T* View::*member) : set([=](View& v, const void* p) { v.*member = static_cast<const T*>(p); }) {}
    template <class T>
    PointerOf(T* View::*member)
        : set([=](View& v, const void* p) { v.*member = static_cast<T*>(const_cast<void*>(p)); }) {}
};

template <class View>
struct Reads {
    std::string name;        // as the twin's variable, with or without _image
    PointerOf<View> at;
    std::string unit = {}, meaning = {};
    std::uint32_t fixed = 0;  // bit c: column c is a flag, a whole number or the rasteriser's: nothing rounds it
    int channels = 4;         // of a sampled image; a buffer's are the twin's
    // How large an image has to be; null: as the domain; (0, 0): any. A buffer, or all layers of an image array: how many
    // elements the kernel reads at most.
    glm::ivec2 (*size)(const View& v) = nullptr;
    std::size_t (*count)(const View& v) = nullptr;
    std::string why = {};     // "half of the outputs, rounded up"
    bool (*read)(const View& v) = nullptr;  // whether the kernel reads it at all; else a texel of nothing will do
    bool optional = false;                  // may be missing: the kernel gets null, a device zeros
    std::string instead = {};               // may be missing where this one of `lends` is there: the kernel gets null
};

// What the host may lend beside the twin's inputs, because it has the same in a form that the kernel reads faster. No
// device binds it and no file holds it.
template <class View>
struct Lends {
    std::string name;
    PointerOf<View> at;
    DType dtype;
    std::size_t (*count)(const View& v);  // numbers that the kernel reads at most
    std::string why = {};
};

template <class View>
struct Writes {
    std::string name;
    PointerOf<View> at;
    std::string unit = {}, meaning = {};
    std::uint32_t fixed = 0;
    glm::vec4 unwritten{0};  // what an item holds that is not computed
};

// What a member of the uniform block may be: dumps are not trusted.
struct Within {
    std::string member;
    double low, high;
};

template <class View>
struct StageDescription {
    std::string name;    // "<folder>.<stage>"
    std::string source;  // document and section
    std::string domain;  // what an item is: "pixel", "coarse pixel", "texel", "receiver"
    std::vector<Reads<View>> inputs;
    std::vector<Writes<View>> outputs;
    std::vector<Lends<View>> lends = {};
    std::vector<ParamInfo> params = {};
    std::vector<Within> uniforms = {};
    std::vector<std::pair<std::string, std::uint32_t>> fixed_uniforms = {};  // members that nothing rounds: bit a component
    // Says what else the kernel cannot serve, or nothing.
    std::string (*refuses)(const View& v, glm::ivec2 size) = nullptr;
    // Derives what the kernel needs beyond its inputs, from inputs that were checked; `own` lives as long as the view.
    void (*prepare)(View& v, Buffer<float>& own) = nullptr;
    Budget budget = {};
    Cost cost = {};
};

}  // namespace plumb
