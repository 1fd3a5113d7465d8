// The floating-point state under which every kernel and every host computation runs: round to nearest even, denormals
// kept, exceptions masked. Libraries that change it (or threads that inherit a changed one) cannot move a bit.
#pragma once

#include <xmmintrin.h>

namespace plumb {

class FpEnvironment {
  public:
    FpEnvironment() : saved_(_mm_getcsr()) { _mm_setcsr(0x1f80); }
    ~FpEnvironment() { _mm_setcsr(saved_); }
    FpEnvironment(const FpEnvironment&) = delete;
    FpEnvironment& operator=(const FpEnvironment&) = delete;

  private:
    unsigned saved_;
};

}  // namespace plumb
