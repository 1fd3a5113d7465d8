#include "gi/radiosity/kept_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <list>
#include <mutex>
#include <optional>
#include <utility>

#include "core/content_hasher.h"
#include "core/error.h"
#include "core/parallel.h"
#include "gi/radiosity/row_bundle.h"

namespace plumb::radiosity {

namespace {

double megabytes(std::uint64_t bytes) { return 1e-6 * double(bytes); }

}  // namespace

std::uint64_t rows_key(const Elements& e, const RowParams& params) {
    ContentHasher h;
    h.add(std::string("radiosity.rows"));
    h.add(e.geometry.vertices.size());
    for (const Vertex& v : e.geometry.vertices) h.add(v.position);
    h.add_all(e.geometry.triangles), h.add_all(e.of), h.add_all(e.eye), h.add_all(e.normal);
    h.add(params.size), h.add(int(params.weights));
    return h.hash;
}

RowPlan plan_rows(int elements, int size, std::uint64_t memory, bool has_store) {
    RowPlan plan;
    if (elements == 0) return plan;
    plan.expected = bytes_expected(elements, size), plan.most = bytes_at_most(elements, size);
    plan.block = std::min(plan.most, plan.most / std::uint64_t(elements) * rows_of_block + 1);
    plan.fits = plan.most <= memory;
    const std::string what = fmt::format("radiosity: {} elements with hemicubes of {} texels: form factors take {:.1f} MB at most, memory_mb allows {:.1f}",
                                         elements, size, megabytes(plan.most), megabytes(memory));
    if (!plan.fits && !has_store)
        throw InputError(fmt::format("{}, and without a cache they cannot be read from disk: expected memory_mb = {:.0f} or more", what,
                                     std::ceil(megabytes(plan.most))));
    if (!plan.fits && 2 * plan.block > memory)
        throw InputError(fmt::format("{}; from disk {} elements are read at a time, {:.1f} MB twice: expected memory_mb = {:.0f} or more", what,
                                     std::min(elements, rows_of_block), megabytes(plan.block), std::ceil(megabytes(2 * plan.block))));
    return plan;
}

// Fitted to boxes of 1,200 to 120,000 triangles (data/bench/radiosity.md), one core with AVX-512.
double row_seconds(int elements, std::size_t triangles, int size) {
    constexpr double each_texel = 15e-9, each_triangle = 15e-9;
    return elements * (each_texel * rows_of_hemicube(size) * size + each_triangle * double(triangles));
}

namespace {

// Blocks of rows, from the store or made.
class Maker {
  public:
    Maker(const Elements& elements, const RowParams& params, const RowsWith& with)
        : elements_(elements), params_(params), with_(with), key_(with.store ? rows_key(elements, params) : 0) {
        with_.options.progress = nullptr;
    }

    std::optional<RowBlock> find(int index) const {
        const std::optional<Bundle> bundle = with_.store ? with_.store->find(key_of(index)) : std::nullopt;
        if (!bundle) return std::nullopt;
        try {
            return block_of(*bundle, elements_.count(), index);
        } catch (const InputError&) {
            return std::nullopt;  // of another make: it is made anew, and replaced
        }
    }
    // progress: of these blocks; may be empty.
    std::vector<RowBlock> make(int first, int last, std::function<void(double)> progress = {}) const {
        RunOptions options = with_.options;
        options.progress = std::move(progress);
        std::vector<RowBlock> blocks = row_blocks(elements_, params_, options, first, last);
        for (std::size_t k = 0; with_.store && k < blocks.size(); ++k)
            with_.store->keep(key_of(first + int(k)), bundle_of(blocks[k]), "a part of radiosity.rows");
        return blocks;
    }

  private:
    graph::Key key_of(int index) const {
        ContentHasher h;
        h.add(key_, index);
        return h.hash;
    }

    const Elements elements_;
    const RowParams params_;
    RowsWith with_;
    const std::uint64_t key_;
};

// The blocks that are not in memory: those that were looked at last are, as far as there is room. What is no longer in the store, or
// was damaged there, is made once more.
class ReadRows : public RowSource {
  public:
    ReadRows(std::shared_ptr<const Maker> maker, std::uint64_t room, std::size_t bytes) : maker_(std::move(maker)), room_(room), bytes_(bytes) {}

    void with_block(int index, const std::function<void(const RowBlock&)>& look) const override {
        const std::lock_guard lock(mutex_);
        const auto at = std::find_if(read_.begin(), read_.end(), [&](const RowBlock& b) { return b.first == index * rows_of_block; });
        if (at != read_.end()) {
            read_.splice(read_.begin(), read_, at);
        } else {
            make_room();
            std::optional<RowBlock> block = maker_->find(index);
            read_.push_front(block ? std::move(*block) : std::move(maker_->make(index, index + 1).front()));
        }
        look(read_.front());
    }
    std::size_t bytes() const override { return bytes_; }

  private:
    // For one more, twice: as it is read, and as it is kept. It is taken to be as large as the largest that there is.
    void make_room() const {
        std::size_t all = 0, largest = 0;
        for (const RowBlock& b : read_) all += b.bytes(), largest = std::max(largest, b.bytes());
        for (; !read_.empty() && all + 2 * largest > room_; read_.pop_back()) all -= read_.back().bytes();
    }

    const std::shared_ptr<const Maker> maker_;
    const std::uint64_t room_;
    const std::size_t bytes_;
    mutable std::mutex mutex_;
    mutable std::list<RowBlock> read_;  // those looked at last in front
};

// Takes blocks in their order: into memory as long as there is room.
struct Taker {
    FormFactors& factors;
    std::uint64_t room;  // bytes, for those in memory
    std::size_t further = 0;

    // Whether it is in memory now.
    bool take(RowBlock block) {
        factors.add_facts(block);
        const std::size_t bytes = block.bytes();
        if (further > 0 || bytes > room) return further += bytes, false;
        room -= bytes;
        factors.blocks.push_back(std::move(block));
        return true;
    }
};

}  // namespace

RowsMade rows_within(const Elements& elements, const RowParams& params, const RowsWith& with) {
    const RowPlan plan = plan_rows(elements.count(), params.size, with.memory, with.store != nullptr);
    const auto maker = std::make_shared<const Maker>(elements, params, with);
    RowsMade made;
    made.factors.count = elements.count();
    // A quarter is for blocks that are read, so that threads find several of them.
    const std::uint64_t room = plan.fits ? 0 : std::max(2 * plan.block, with.memory / 4);
    Taker taker{made.factors, with.memory - room};
    const int blocks = blocks_of(elements.count()), threads = thread_count(with.options.threads);
    const std::uint64_t fit = plan.fits ? std::uint64_t(blocks) : room / std::max<std::uint64_t>(plan.block, 1);
    const int batch = int(std::clamp<std::uint64_t>(fit, 1, std::uint64_t(std::max(32, 4 * threads))));
    const auto progress = [&](double done) {
        if (with.options.progress) with.options.progress(done / blocks);
    };

    for (int index = 0; index < blocks;) {
        // Those from `index` on that the store has not, and the one after them that it has.
        std::optional<RowBlock> found = maker->find(index);
        int last = index;
        while (!found && ++last < blocks && last - index < batch) found = maker->find(last);
        if (last > index) {
            for (RowBlock& b : maker->make(index, last, [&](double done) { progress(index + done * (last - index)); })) {
                const int own = b.first / rows_of_block;
                if (taker.take(std::move(b)) || maker->find(own)) continue;
                throw InputError(fmt::format("radiosity: form factors of {} elements do not fit into memory_mb, {:.1f} MB, and cannot be kept on disk: "
                                             "expected room for {:.1f} MB in the cache, or a larger memory_mb", elements.count(),
                                             megabytes(with.memory), megabytes(plan.most)));
            }
        }
        if (found) taker.take(std::move(*found)), ++made.found, ++last;
        index = last;
        progress(index);
    }
    if (taker.further > 0) made.factors.further = std::make_shared<ReadRows>(maker, room, taker.further);
    return made;
}

}  // namespace plumb::radiosity
