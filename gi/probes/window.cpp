#include "gi/probes/window.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/sh.h"

namespace plumb::probes {

std::vector<double> window_factors(Window window, int degree) {
    if (degree < 0 || degree > sh::max_degree)
        throw InputError(fmt::format("window: degree {}: expected 0 to {}", degree, sh::max_degree));
    std::vector<double> factors;
    for (int l = 0; l <= degree; ++l) {
        const double angle = host::pi * l / (degree + 1);
        double factor = 1;
        if (window == Window::hann) factor = (1 + host::cos(angle)) / 2;
        if (window == Window::lanczos && l > 0) factor = host::sin(angle) / angle;
        factors.push_back(factor);
    }
    return factors;
}

Buffer<float> windowed(const Buffer<float>& harmonics, int degree, Window window) {
    const std::vector<double> factors = window_factors(window, degree);
    const std::size_t count = std::size_t(sh::count(degree));
    if (harmonics.size() % count != 0)
        throw InputError(fmt::format("window: {} harmonics are no rows of {}", harmonics.size(), count));
    Buffer<float> out = harmonics;
    for (std::size_t row = 0; row < out.size(); row += count)
        for (int l = 0; l <= degree; ++l)
            for (int j = sh::index(l, -l); j <= sh::index(l, l); ++j) {
                float& y = out[row + std::size_t(j)];
                y = float(double(y) * factors[std::size_t(l)]);
            }
    return out;
}

NegativeIrradiance negative_irradiance(const Buffer<glm::vec4>& irradiance) {
    NegativeIrradiance found;
    for (std::size_t i = 0; i < irradiance.size(); ++i) {
        const glm::vec4& e = irradiance[i];
        if (e.w == 0) continue;
        for (int c = 0; c < 4; ++c)
            if (!std::isfinite(e[c])) throw InputError(fmt::format("irradiance of receiver {} is not finite", i));
        const float least = std::min({e.x, e.y, e.z});
        ++found.computed;
        found.negative += least < 0 ? 1 : 0;
        found.least = std::min(found.least, least);
    }
    return found;
}

}  // namespace plumb::probes
