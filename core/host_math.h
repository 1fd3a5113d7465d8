// Elementary functions of the host in double precision, with the same bits everywhere.
//
// The C library's sin, exp, pow ... differ in their last bit between processors with and without fma, so nothing that
// reaches a picture may call them. These use + - * / sqrt and the bit pattern of a double alone. Each computes its
// result to about 70 bits as an unevaluated sum of two doubles and rounds once, so the error stays below 0.501 units in
// the last place over the whole domain, arguments of any size and denormals included. tests/core/host_math_mpfr.cpp
// measures it: of 200 million results three were not the nearest double.
//
// Special values are those of C Annex F. Every NaN returned is the one with bits 7ff8000000000000.
//
// They cost a fraction of a microsecond each: meant for cameras, tables and procedural scenes. Kernels use
// core/detmath.h.
#pragma once

#include <cstdint>

namespace plumb::host {

inline constexpr double pi = 0x1.921fb54442d18p+1;

double exp(double x);
double exp2(double x);
double expm1(double x);  // e^x - 1, without cancellation near 0
double log(double x);
double log2(double x);
double pow(double x, double y);

double sin(double radians);
double cos(double radians);
double tan(double radians);
double asin(double x);
double acos(double x);
double atan(double x);
double atan2(double y, double x);

// The binary digits of 2/pi after 64 zeros, for the reduction of large angles; seen here so that a test can read them.
extern const std::uint64_t two_over_pi[20];

}  // namespace plumb::host
