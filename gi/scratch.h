// Memory that the bands of a stage share.
#pragma once

#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

#include "core/image.h"

namespace plumb {

// Scratch memory that bands take and give back, so that a thread touches its own again.
class Scratch {
  public:
    explicit Scratch(std::size_t floats) : floats_(floats) {}
    Buffer<float> take() {
        const std::lock_guard lock(mutex_);
        if (free_.empty()) return Buffer<float>(floats_);
        Buffer<float> one = std::move(free_.back());
        free_.pop_back();
        return one;
    }
    void give(Buffer<float> one) {
        const std::lock_guard lock(mutex_);
        free_.push_back(std::move(one));
    }

  private:
    std::size_t floats_;
    std::mutex mutex_;
    std::vector<Buffer<float>> free_;
};

}  // namespace plumb
