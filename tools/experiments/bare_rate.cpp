#include "tools/experiments/bare_rate.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <tuple>
#include <vector>

#include "core/parallel.h"
#include "core/ray_query.h"

namespace plumb::cli {

namespace {

constexpr int packets_a_band = 256;  // with their answers 0.3 MB: they stay in a cache

double seconds_of(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// What a query was asked. A query moves t_far: the packet keeps what it was.
template <int W>
struct Asked {
    RayPacket<W> rays;
    alignas(64) std::int32_t active[W];
    float t_far[W];
    bool occluded;
};

class RecordingQuery : public RayQuery {
  public:
    explicit RecordingQuery(const RayQuery& query) : query_(query) {}

    void nearest(const std::int32_t* active, RayPacket<1>& rays) const override { ask(active, rays, false); }
    void nearest(const std::int32_t* active, RayPacket<4>& rays) const override { ask(active, rays, false); }
    void nearest(const std::int32_t* active, RayPacket<8>& rays) const override { ask(active, rays, false); }
    void nearest(const std::int32_t* active, RayPacket<16>& rays) const override { ask(active, rays, false); }
    void occluded(const std::int32_t* active, RayPacket<1>& rays) const override { ask(active, rays, true); }
    void occluded(const std::int32_t* active, RayPacket<4>& rays) const override { ask(active, rays, true); }
    void occluded(const std::int32_t* active, RayPacket<8>& rays) const override { ask(active, rays, true); }
    void occluded(const std::int32_t* active, RayPacket<16>& rays) const override { ask(active, rays, true); }

    // Asks all of it again, each band twice; seconds of the second time, by which its packets lie in a cache.
    double replay(const RunOptions& options) {
        double seconds = 0;
        std::apply([&](auto&... asked) { (replay(asked, options, seconds), ...); }, asked_);
        return seconds / thread_count(options.threads);
    }

  private:
    template <int W>
    void ask(const std::int32_t* active, RayPacket<W>& rays, bool occluded) const {
        {
            const std::lock_guard lock(mutex_);
            auto& all = std::get<std::vector<Asked<W>>>(asked_);
            all.emplace_back();
            all.back().rays = rays, all.back().occluded = occluded;
            std::copy_n(active, W, all.back().active), std::copy_n(rays.t_far, W, all.back().t_far);
        }
        occluded ? query_.occluded(active, rays) : query_.nearest(active, rays);
    }

    template <int W>
    void replay(std::vector<Asked<W>>& asked, const RunOptions& options, double& seconds) {
        parallel_bands(int(asked.size()), packets_a_band, options, [&](int first, int last) {
            const auto all = [&] {
                for (int i = first; i < last; ++i) ask_again(asked[std::size_t(i)]);
            };
            all();
            const double one = seconds_of(all);
            const std::lock_guard lock(mutex_);
            seconds += one;
        });
    }

    template <int W>
    void ask_again(Asked<W>& asked) const {
        std::memcpy(asked.rays.t_far, asked.t_far, sizeof asked.t_far);
        asked.occluded ? query_.occluded(asked.active, asked.rays) : query_.nearest(asked.active, asked.rays);
    }

    const RayQuery& query_;
    mutable std::mutex mutex_;
    mutable std::tuple<std::vector<Asked<1>>, std::vector<Asked<4>>, std::vector<Asked<8>>, std::vector<Asked<16>>> asked_;
};

}  // namespace

BareRate bare_rate(const probes::BakeGraph& graph, std::uint64_t rays, int repeats, const RunOptions& options) {
    const int blocks = graph.bake().blocks();
    const std::uint64_t a_block = std::max<std::uint64_t>(1, graph.bake().counts().traced / std::uint64_t(blocks));
    const int looked_at = int(std::min<std::uint64_t>(std::uint64_t(blocks), rays / a_block + 1));
    RunOptions silent = options, alone = options;
    silent.progress = {}, alone.progress = {}, alone.threads = 1;
    BareRate all;
    for (int k = 0; k < looked_at; ++k) {
        const int receiver = int(std::int64_t(k) * blocks / looked_at) * probes::block_receivers;
        RecordingQuery recording(graph.query());
        all.rays += graph.traced(receiver, recording, alone).counts.traced;
        double bake = 1e30, bare = 1e30;
        for (int i = 0; i < repeats; ++i) {
            bake = std::min(bake, seconds_of([&] { graph.traced(receiver, graph.query(), silent); }));
            bare = std::min(bare, recording.replay(silent));
        }
        all.bake_seconds += bake, all.bare_seconds += bare;
    }
    return all;
}

}  // namespace plumb::cli
