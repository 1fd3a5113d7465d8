// Memory that is read here and there over more megabytes than the processor's table of small pages covers.
#pragma once

#include "core/image.h"

namespace plumb {

// Asks the system for pages of 2 MB where it has them (Linux: madvise); elsewhere, and where it refuses, nothing happens.
// For memory that nothing was written to yet.
void prefer_large_pages(void* first, std::size_t bytes);

// buffer.resize(n), whose memory, if it has to be new, is of large pages. What it held is lost where it grows.
template <class T>
void resize_in_large_pages(Buffer<T>& buffer, std::size_t n) {
    if (n > buffer.capacity()) {
        buffer = Buffer<T>();
        buffer.reserve(n);
        prefer_large_pages(buffer.data(), n * sizeof(T));
    }
    buffer.resize(n);
}

}  // namespace plumb
