// Images and aligned buffers: plain memory, row-major, first row on top.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <new>
#include <vector>

namespace plumb {

// Allocates on cache lines, so that a texel record never straddles two.
template <class T>
struct CacheLineAllocator {
    using value_type = T;
    CacheLineAllocator() = default;
    template <class U>
    CacheLineAllocator(const CacheLineAllocator<U>&) {}
    T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), std::align_val_t{64})); }
    void deallocate(T* p, std::size_t) { ::operator delete(p, std::align_val_t{64}); }
    template <class U>
    bool operator==(const CacheLineAllocator<U>&) const {
        return true;
    }
};

template <class T>
using Buffer = std::vector<T, CacheLineAllocator<T>>;

// width x height texels of T; (x, y) with y = 0 the top row. No padding between rows.
template <class T>
struct Image {
    int width = 0, height = 0;
    Buffer<T> texels;

    Image() = default;
    Image(int w, int h, T fill = T{}) : width(w), height(h), texels(std::size_t(w) * std::size_t(h), fill) {}

    bool empty() const { return texels.empty(); }
    std::size_t size() const { return texels.size(); }
    T& operator()(int x, int y) { return texels[std::size_t(y) * width + x]; }
    const T& operator()(int x, int y) const { return texels[std::size_t(y) * width + x]; }
    T* data() { return texels.data(); }
    const T* data() const { return texels.data(); }
};

using Image1 = Image<float>;
using Image4 = Image<glm::vec4>;  // what an RGBA32F render target holds; position, normal: w is 0 unless said otherwise

}  // namespace plumb
