#include "tools/experiments/hemicube_world.h"

#include <algorithm>
#include <cmath>

#include "io/scenes/generate.h"
#include "tools/experiments/ipr_truth.h"

namespace plumb::cli {

namespace {

constexpr double longest_repeated = 2;  // s

// Those elements' values as an image of one row.
Image4 picked(const Buffer<glm::vec4>& values, const std::vector<int>& index) {
    Image4 some(int(index.size()), 1);
    for (std::size_t i = 0; i < index.size(); ++i) some.texels[i] = values[std::size_t(index[i])];
    return some;
}

}  // namespace

double timed(int repeats, const std::function<void()>& work) {
    std::vector<double> seconds;
    while (seconds.empty() || (int(seconds.size()) < repeats && seconds.front() < longest_repeated)) {
        const Clock::time_point start = Clock::now();
        work();
        seconds.push_back(seconds_since(start));
    }
    std::sort(seconds.begin(), seconds.end());
    return seconds[seconds.size() / 2];
}

Box benchmark_box(int triangles, bool as_published, const RunOptions& options) {
    Box box{io::generate_scene("hemicube_box", {triangles, 1}, "experiment hemicube"), {}, 0};
    radiosity::ElementParams p;
    p.of_file = true, p.inset = !as_published;
    box.seconds = timed(1, [&] { box.elements = radiosity::elements_of(box.scene, p, options); });
    return box;
}

RowTransport::RowTransport(const radiosity::FormFactors& factors, const radiosity::Elements& elements)
    : factors_(factors), dark_(std::size_t(factors.count), glm::vec4(0)) {
    std::vector<float> row;
    for (int i = 0; i < factors.count; ++i) {
        row.assign(std::size_t(factors.count), 0.0f);
        factors.add_row(i, row);
        double sum = 0;
        for (const float f : row) sum += double(f);
        row_sums_.push_back(sum);
    }
    transport_.count = factors.count, transport_.area = &elements.area, transport_.row_sums = &row_sums_;
    transport_.gather = [this](const Buffer<glm::vec4>& b, Buffer<glm::vec4>& h, const RunOptions& o) { radiosity::gather(factors_, dark_, b, o, h); };
    transport_.row = [this](int i, std::vector<float>& dense) {
        dense.assign(std::size_t(factors_.count), 0.0f);
        factors_.add_row(i, dense);
    };
}

Buffer<glm::vec4> RowTransport::irradiance(const Buffer<glm::vec4>& radiosity, const RunOptions& options) const {
    Buffer<glm::vec4> h;
    radiosity::gather(factors_, dark_, radiosity, options, h);
    return h;
}

radiosity::Solution converged(const radiosity::Elements& elements, const RowTransport& rows, const RunOptions& options) {
    radiosity::SolveParams p;
    p.solver = radiosity::Solver::bicgstab, p.tolerance = 1e-6;
    return radiosity::solve(system_of(elements), rows.transport(), p, options);
}

radiosity::Solution passes_of(const radiosity::Elements& elements, const RowTransport& rows, int passes, const RunOptions& options) {
    radiosity::SolveParams p;
    p.solver = radiosity::Solver::passes, p.tolerance = 0, p.most_products = passes;
    return radiosity::solve(system_of(elements), rows.transport(), p, options);
}

ElementTruth trace_elements(const Box& box, const HemicubeRequest& request, const RunOptions& options) {
    ElementTruth truth;
    const int n = box.elements.count(), step = (n + request.elements - 1) / request.elements;
    for (int i = step / 2; i < n; i += step) truth.index.push_back(i);
    const Image4 position = picked(box.elements.eye, truth.index), normal = picked(box.elements.normal, truth.index);
    Image4 mean, error;
    trace_points(box.scene, {&position, &normal}, request.samples, Rays::exact, options, mean, error);
    truth.mean = compare::luminances(mean), truth.error = compare::luminance_errors(error);
    return truth;
}

IprErrors errors_of(const Buffer<glm::vec4>& irradiance, const ElementTruth& truth) {
    return ipr_errors(compare::luminances(picked(irradiance, truth.index)), truth.mean, truth.error);
}

double luminance_of(const glm::vec4& v) { return 0.2126 * double(v.x) + 0.7152 * double(v.y) + 0.0722 * double(v.z); }

double mean_difference(const Buffer<glm::vec4>& own, const Buffer<glm::vec4>& truth, const std::vector<double>& area) {
    double off = 0, all = 0;
    for (std::size_t i = 0; i < area.size(); ++i) {
        off += area[i] * std::fabs(luminance_of(own[i]) - luminance_of(truth[i]));
        all += area[i] * luminance_of(truth[i]);
    }
    return off / all;
}

}  // namespace plumb::cli
