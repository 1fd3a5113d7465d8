#include "gi/radiosity/published_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/lend.h"
#include "gi/radiosity/items.h"

namespace plumb::radiosity {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr std::size_t texels_at_a_time = std::size_t(1) << 21;

// What hemicubes see, as radiosity.items tells it.
struct Drawn {
    std::vector<std::int32_t> triangle;
    Buffer<glm::vec4> seen;
};

class Drawer {
  public:
    Drawer(const Elements& e, int size) : eyes_(eyes_of(e.eye, e.normal)), size_(size) {
        for (const Vertex& v : e.geometry.vertices) vertices_.push_back(glm::vec4(v.position, 0));
        for (const glm::uvec3& t : e.geometry.triangles) triangles_.push_back(glm::ivec4(glm::ivec3(t), 0));
    }
    void draw(int first, int count, const RunOptions& options, Drawn& out) const {
        const StageData d = data_of({&vertices_, &triangles_, &eyes_, size_}, first, count);
        const std::int64_t texels = std::int64_t(d.size.x) * d.size.y;
        out.triangle.resize(std::size_t(texels)), out.seen.resize(std::size_t(texels));
        Bundle outputs;
        lend(outputs, "triangle", {texels, 1}, out.triangle.data());
        lend(outputs, "seen", {texels, 4}, &out.seen[0].x);
        stage<ItemsKernel>().bind(d)->run(options, {}, outputs);
    }

  private:
    Buffer<glm::vec4> vertices_, eyes_;
    Buffer<glm::ivec4> triangles_;
    int size_;
};

// What a texel shows: xyz B, W/m2, w 1 where it is a front.
glm::vec4 shown(const Elements& e, const PublishedPass& pass, const Buffer<glm::vec4>& b, std::int32_t triangle, const glm::vec4& seen) {
    if (!(seen.w > 0)) return glm::vec4(0);
    const glm::uvec3 of = e.of[std::size_t(triangle)];
    const glm::vec3 at(1.0f - seen.x - seen.y, seen.x, seen.y);
    const std::array<glm::vec3, 3> corners = {glm::vec3(b[of.x]), glm::vec3(b[of.y]), glm::vec3(b[of.z])};
    return glm::vec4(pass.texel ? pass.texel(corners, at) : at.x * corners[0] + at.y * corners[1] + at.z * corners[2], 1);
}

// Texels in their order, in double.
glm::vec4 sum_of(const Elements& e, const PublishedPass& pass, const std::vector<double>& weights, const Buffer<glm::vec4>& b,
                 const std::int32_t* triangle, const glm::vec4* seen) {
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * glm::dvec3(glm::vec3(shown(e, pass, b, triangle[i], seen[i])));
    return glm::vec4(glm::vec3(sum), 0);
}

// The same as a device makes it, of all that is drawn.
void reduce(const Elements& e, const PublishedPass& pass, const std::vector<double>& weights, const Buffer<glm::vec4>& b, const Drawn& drawn,
            const RunOptions& options, glm::vec4* irradiance) {
    Buffer<glm::vec4> texels(drawn.seen.size());
    parallel_bands(int(texels.size()), 4096, options.threads, [&](int a, int z) {
        for (int i = a; i < z; ++i) texels[std::size_t(i)] = shown(e, pass, b, drawn.triangle[std::size_t(i)], drawn.seen[std::size_t(i)]);
    });
    for (const glm::vec4& h : reduced_irradiance(pass.row.size, texels, weights, pass.reduction, options)) *irradiance++ = glm::vec4(glm::vec3(h), 0);
}

}  // namespace

PassTimes published_irradiance(const Elements& elements, const PublishedPass& pass, const Buffer<glm::vec4>& radiosity, int first,
                               int count, const RunOptions& options, Buffer<glm::vec4>& irradiance) {
    if (radiosity.size() != std::size_t(elements.count()) || first < 0 || count < 0 || first > elements.count() - count)
        throw InputError(fmt::format("radiosity: elements {} to {} of {}, {} radiosities", first, first + count, elements.count(), radiosity.size()));
    const std::vector<double> weights = texel_weights(pass.row.size, pass.row.weights);
    const Drawer drawer(elements, pass.row.size);
    irradiance.assign(std::size_t(count), glm::vec4(0));
    const int most = rows_a_dispatch / 2 / rows_of_hemicube(pass.row.size);
    const int block = std::clamp(int(texels_at_a_time / weights.size()), 1, most);
    PassTimes times;
    Drawn drawn;
    for (int from = 0; from < count; from += block) {
        const int n = std::min(block, count - from);
        const Clock::time_point start = Clock::now();
        drawer.draw(first + from, n, options, drawn);
        times.draw_seconds += seconds_since(start);
        const Clock::time_point between = Clock::now();
        if (pass.reduction.box > 0)
            reduce(elements, pass, weights, radiosity, drawn, options, &irradiance[std::size_t(from)]);
        else
            parallel_bands(n, 4, options.threads, [&](int a, int z) {
                for (int i = a; i < z; ++i) {
                    const std::size_t at = std::size_t(i) * weights.size();
                    irradiance[std::size_t(from + i)] = sum_of(elements, pass, weights, radiosity, &drawn.triangle[at], &drawn.seen[at]);
                }
            });
        times.sum_seconds += seconds_since(between);
    }
    return times;
}

}  // namespace plumb::radiosity
