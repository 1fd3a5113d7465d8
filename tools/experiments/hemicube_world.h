// plumb experiment hemicube: the box, its rows and its light, as all parts take them.
#pragma once

#include <chrono>

#include "core/signed_error.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/rows.h"
#include "gi/radiosity/solve.h"
#include "tools/experiments/hemicube.h"

namespace plumb::cli {

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Seconds of `work`: the median of as many runs as asked, of one where that takes longer than two seconds.
double timed(int repeats, const std::function<void()>& work);

// The benchmark's box with so many triangles, and an element a vertex of its file, moved in from borders (as_published: not).
struct Box {
    Scene scene;
    radiosity::Elements elements;
    double seconds = 0;  // of the elements
};
Box benchmark_box(int triangles, bool as_published, const RunOptions& options);

// F as solvers take it. Holds a reference to the rows.
class RowTransport {
  public:
    RowTransport(const radiosity::FormFactors& factors, const radiosity::Elements& elements);
    const radiosity::Transport& transport() const { return transport_; }
    // H = F B, W/m2.
    Buffer<glm::vec4> irradiance(const Buffer<glm::vec4>& radiosity, const RunOptions& options) const;

  private:
    const radiosity::FormFactors& factors_;
    Buffer<glm::vec4> dark_;
    std::vector<double> row_sums_;
    radiosity::Transport transport_;
};
inline radiosity::System system_of(const radiosity::Elements& e) { return {&e.reflectance, &e.exitance, nullptr}; }
radiosity::Solution converged(const radiosity::Elements& elements, const RowTransport& rows, const RunOptions& options);
radiosity::Solution passes_of(const radiosity::Elements& elements, const RowTransport& rows, int passes, const RunOptions& options);

// Irradiance of some elements by path tracing, where they look from.
struct ElementTruth {
    std::vector<int> index;
    compare::Plane mean, error;  // luminance, W/m2
};
ElementTruth trace_elements(const Box& box, const HemicubeRequest& request, const RunOptions& options);
IprErrors errors_of(const Buffer<glm::vec4>& irradiance, const ElementTruth& truth);
double luminance_of(const glm::vec4& v);
// Mean |difference| of luminance over all elements, of the mean of `truth`, by area.
double mean_difference(const Buffer<glm::vec4>& own, const Buffer<glm::vec4>& truth, const std::vector<double>& area);

}  // namespace plumb::cli
