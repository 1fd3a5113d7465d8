// Hashes one value after the other; core/content_hash.h.
#pragma once

#include <string>
#include <type_traits>

#include "core/content_hash.h"

namespace plumb {

struct ContentHasher {
    std::uint64_t hash = 0;

    // Values without padding: numbers, vectors and matrices of them.
    template <class... T>
    void add(const T&... values) {
        static_assert((std::is_trivially_copyable_v<T> && ...));
        ((hash = content_hash(&values, sizeof values, hash)), ...);
    }
    void add(const std::string& text) { hash = content_hash(text, hash); }
    // The number of elements counts, so that two lists in a row are told apart.
    template <class List>
    void add_all(const List& list) {
        hash = content_hash(list.data(), list.size() * sizeof(list[0]), hash);
    }
    template <class T>
    void add_image(const Image<T>& image) {
        hash = content_hash(image, hash);
    }
};

}  // namespace plumb
