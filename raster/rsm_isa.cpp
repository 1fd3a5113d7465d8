#include "raster/rsm_rows.h"

#include <cstring>

#include "core/formats.h"
#include "core/wide.h"

namespace plumb::raster {

namespace {

// Rounds a texel of four floats to halves in place, and stores the halves. The processor's conversion is float_to_half:
// to nearest even, overflow to infinity, and 7e00 for the one NaN that kernels store, 7fc00000.
PLUMB_INLINE void round_texel(float* texel, Half* half) {
#if defined(__F16C__)
    const __m128i halves = _mm_cvtps_ph(_mm_loadu_ps(texel), _MM_FROUND_TO_NEAREST_INT);
    _mm_storel_epi64(reinterpret_cast<__m128i*>(half), halves);
    _mm_storeu_ps(texel, _mm_cvtph_ps(halves));
#else
    for (int c = 0; c < 4; ++c) {
        half[c] = float_to_half(texel[c]);
        texel[c] = half_to_float(half[c]);
    }
#endif
}

}  // namespace

template <>
void RsmRows<Isa::PLUMB_ISA>::pack(const RsmImages& in, float* records, std::ptrdiff_t first, std::ptrdiff_t last) {
    for (std::ptrdiff_t i = first; i < last; ++i) {
        float* record = records + record_stride * i;
        std::memcpy(record, in.position + 4 * i, 16);
        std::memcpy(record + 4, in.normal + 4 * i, 16);
        std::memcpy(record + 8, in.flux + 4 * i, 16);
    }
}

template <>
void RsmRows<Isa::PLUMB_ISA>::pack(const RsmImages& in, Half* records, std::ptrdiff_t first, std::ptrdiff_t last) {
    for (std::ptrdiff_t i = first; i < last; ++i) {
        Half* record = records + record_stride * i;
        round_texel(in.position + 4 * i, record);
        round_texel(in.normal + 4 * i, record + 4);
        round_texel(in.flux + 4 * i, record + 8);
    }
}

}  // namespace plumb::raster
