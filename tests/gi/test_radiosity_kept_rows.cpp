// Rows of form factors that a store keeps: the same bits from memory and from the store, made again where they are damaged.
#include <catch2/catch.hpp>
#include <cstring>
#include <set>

#include "core/content_hasher.h"
#include "core/error.h"
#include "gi/graph/memory_store.h"
#include "gi/radiosity/host_stages.h"
#include "gi/radiosity/kept_rows.h"
#include "gi/radiosity/row_bundle.h"
#include "tests/gi/radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;
using Catch::Matchers::Contains;

namespace {

// 1,014 elements, four blocks of rows; one face emits, others reflect each as much as it likes.
Elements room(int n = 12) {
    test::CubeFaces faces;
    faces.reflectance = {0.2, 0.9, 0.5, 0.7, 0.3, 0.8}, faces.emission[2] = 1;
    return elements_of(test::cube(n, faces), {});
}
constexpr RowParams small{.size = 10};

std::uint64_t hash_of(const RowBlock& b) {
    ContentHasher h;
    h.add(b.first, b.count);
    h.add_all(b.rows), h.add_all(b.runs), h.add_all(b.weights), h.add_all(b.scale), h.add_all(b.escaped), h.add_all(b.back), h.add_all(b.sum);
    return h.hash;
}
std::vector<std::uint64_t> hashes_of(const FormFactors& f) {
    std::vector<std::uint64_t> all;
    f.each_block([&](const RowBlock& b) { all.push_back(hash_of(b)); });
    ContentHasher h;
    h.add_all(f.escaped), h.add_all(f.sums);
    h.add(f.count, f.longest);
    all.push_back(h.hash);
    return all;
}

// A store whose files somebody changes.
class DamagedStore : public graph::MemoryStore {
  public:
    std::function<void(Bundle&)> damage;
    std::optional<Bundle> find(graph::Key key) override {
        ++asked;
        std::optional<Bundle> bundle = MemoryStore::find(key);
        if (bundle && damage) damage(*bundle);
        return bundle;
    }
    void keep(graph::Key key, const Bundle& bundle, const std::string& what) override {
        kept += keeps;
        if (keeps) MemoryStore::keep(key, bundle, what);
    }
    bool keeps = true;
    int asked = 0, kept = 0;
};

constexpr std::uint64_t little = 2'500'000;  // a block or two in memory, and room to read the others

}  // namespace

TEST_CASE("radiosity: rows from memory, from a store, and read for each product are the same bits", "[radiosity][store][bits]") {
    const Elements e = room();
    const FormFactors plain = form_factors(e, small, {});
    const std::vector<std::uint64_t> truth = hashes_of(plain);
    REQUIRE(plain.block_count() == 4);
    DamagedStore store;
    const RowsMade first = rows_within(e, small, {{}, ~std::uint64_t(0), &store});
    CHECK(first.found == 0);
    CHECK(store.size() == 4);
    CHECK(hashes_of(first.factors) == truth);
    const RowsMade again = rows_within(e, small, {{}, ~std::uint64_t(0), &store});
    CHECK(again.found == 4);
    CHECK(hashes_of(again.factors) == truth);
    CHECK(store.kept == 4);
    CHECK(hashes_of(rows_within(e, small, {}).factors) == truth);  // without a store

    // Little memory, from nothing and from what is kept.
    DamagedStore fresh;
    for (DamagedStore* s : {&store, &fresh}) {
        const RowsMade part = rows_within(e, small, {{}, little, s});
        CHECK(part.factors.blocks.size() >= 1);
        CHECK(part.factors.blocks.size() < 4);
        REQUIRE(part.factors.further);
        CHECK(part.factors.bytes() <= little);
        CHECK(part.factors.all_bytes() == plain.bytes());
        CHECK(hashes_of(part.factors) == truth);
        CHECK(hashes_of(part.factors) == truth);  // blocks come and go
        CHECK(s->size() == 4);

        const Transport a = transport_of(plain, e), b = transport_of(part.factors, e);
        Buffer<glm::vec4> light(std::size_t(e.count()), glm::vec4(0)), h = light, k = light;
        for (int i = 0; i < e.count(); ++i) light[std::size_t(i)] = glm::vec4(float(i % 7), 1, 1e-3f * float(i), 0);
        a.gather(light, h, {}), b.gather(light, k, {});
        CHECK(std::memcmp(h.data(), k.data(), h.size() * sizeof h[0]) == 0);
        std::vector<float> x, y;
        for (int i = 0; i < e.count(); i += 97) {
            a.row(i, x), b.row(i, y);
            REQUIRE(x == y);
        }
    }
}

TEST_CASE("radiosity: rows partly in memory bring the same products, whichever large or small block is the last", "[radiosity][store][bits]") {
    // Half of a cube, a plate that looks up and sees nothing, and the same once more: large blocks and small ones after them.
    // Where all has radiosity 1 an element of the cube gets 1, and one of the plates nothing.
    test::CubeFaces faces;
    faces.reflectance = {0.2, 0.9, 0.5, 0.7, 0.3, 0.8};
    Scene s = test::cube(12, faces);
    for (const std::size_t place : {std::size_t(3), std::size_t(7)})
        s.meshes.insert(s.meshes.begin() + std::ptrdiff_t(place), test::grid({0, 2, double(place)}, {0, 0, 1}, {1, 0, 0}, 19, 19, 0));
    const Elements e = elements_of(s, {});
    const FormFactors plain = form_factors(e, small, {});
    const int blocks = plain.block_count();
    REQUIRE(e.count() == 6 * 169 + 2 * 400);
    REQUIRE(blocks == 8);
    const auto bytes = [&](int block) { return plain.blocks[std::size_t(block)].bytes(); };

    Buffer<glm::vec4> ones(std::size_t(e.count()), glm::vec4(1)), uneven = ones, brought, truth;
    for (std::size_t i = 0; i < uneven.size(); ++i) uneven[i] = glm::vec4(float(i % 7), 1, 1e-3f * float(i), 0);
    brought = truth = Buffer<glm::vec4>(ones.size(), glm::vec4(0));
    const Transport whole = transport_of(plain, e);
    whole.gather(ones, brought, {}), whole.gather(uneven, truth, {});
    for (std::size_t i = 0; i < ones.size(); ++i) {
        const bool plate = e.position[i].y > 1.5f;
        CHECK(double(brought[i].x) == Approx(plate ? 0 : 1).epsilon(1e-5).margin(0));
    }

    DamagedStore store;
    rows_within(e, small, {{}, ~std::uint64_t(0), &store});
    const std::uint64_t read = 2 * plan_rows(e.count(), small.size, ~std::uint64_t(0), true).block;  // what is read has room beside
    std::uint64_t before = 0;
    int smaller = 0;
    for (int fit = 0; fit < blocks; before += bytes(fit++)) {
        // Just room for `fit` blocks, and one byte too little for the next one.
        for (const std::uint64_t room : {before, before + bytes(fit) - 1}) {
            const RowsMade part = rows_within(e, small, {{}, read + room, &store});
            CAPTURE(fit, room);
            REQUIRE(part.factors.further);
            CHECK(part.factors.blocks.size() == std::size_t(fit));
            for (int later = fit + 1; later < blocks; ++later) smaller += bytes(later) <= room - before;
            for (int block = 0; block < blocks; ++block)
                part.factors.with_block(block, [&](const RowBlock& b) { CHECK(b.first == block * rows_of_block); });
            Buffer<glm::vec4> products(ones.size(), glm::vec4(0));
            transport_of(part.factors, e).gather(uneven, products, {});
            for (std::size_t i = 0; i < ones.size(); ++i)
                if (std::memcmp(&products[i], &truth[i], sizeof truth[i]) != 0) FAIL_CHECK("element " << i);
        }
    }
    CHECK(smaller > 4);  // blocks that would have fitted after one that did not
}

TEST_CASE("radiosity: every solver has the same bits with rows in memory and rows on disk", "[radiosity][store][bits]") {
    const Elements e = room();
    DamagedStore store;
    const FormFactors whole = rows_within(e, small, {{}, ~std::uint64_t(0), &store}).factors;
    const FormFactors part = rows_within(e, small, {{}, little, &store}).factors;
    REQUIRE(part.further);
    const Buffer<glm::vec4> none(std::size_t(e.count()), glm::vec4(0));
    for (int solver = 0; solver <= int(SolverChoice::direct); ++solver) {
        RadiosityParams p;
        p.solver = SolverChoice(solver), p.tolerance = 1e-4f;
        CAPTURE(solver);
        Buffer<glm::vec4> a, b;
        const Solved x = solve(whole, e, none, none, p, {}, a);
        RunOptions one;
        one.threads = 1;
        const Solved y = solve(part, e, none, none, p, solver % 2 ? one : RunOptions(), b);
        CHECK(x.solution.converged);
        CHECK(text_of(x) == text_of(y));
        REQUIRE(a.size() == b.size());
        CHECK(std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
    }
}

TEST_CASE("radiosity: kept rows are those of what is seen, whatever is lit and reflected", "[radiosity][store][keys]") {
    const Elements e = room(4);
    std::set<std::uint64_t> keys = {rows_key(e, small)};
    // Light and reflectance are not in it.
    test::CubeFaces other;
    other.reflectance = {0.1, 0.1, 0.1, 0.1, 0.1, 0.1}, other.emission[0] = 3;
    CHECK(rows_key(elements_of(test::cube(4, other), {}), small) == *keys.begin());
    // Another instruction set and number of threads make the same elements, and so the same key.
    for (const Isa isa : supported_isas()) {
        RunOptions options;
        options.isa = isa, options.threads = 1;
        CHECK(rows_key(elements_of(test::cube(4, other), {}, options), small) == *keys.begin());
    }
    // All that is seen is.
    const auto differs = [&](const Elements& elements, const RowParams& params) { return keys.insert(rows_key(elements, params)).second; };
    CHECK(differs(e, {.size = 12}));
    CHECK(differs(e, {.size = 10, .weights = Weights::centre}));
    CHECK(differs(elements_of(test::cube(4, {}), {.kind = Kind::triangles}), small));
    CHECK(differs(elements_of(test::cube(4, {}), {.offset = 2e-4}), small));
    CHECK(differs(elements_of(test::cube(4, {}), {.split = false}), small));
    CHECK(differs(elements_of(test::cube(4, {}, 1.5), {}), small));
    CHECK(differs(elements_of(test::cube(5, {}), {}), small));
    Elements moved = e;
    moved.geometry.vertices[3].position.x += 0.01f;
    CHECK(differs(moved, small));
    Elements turned = e;
    std::swap(turned.geometry.triangles[2].x, turned.geometry.triangles[2].y);
    CHECK(differs(turned, small));
    Elements mapped = e;
    mapped.of[5].x = 0;
    CHECK(differs(mapped, small));
}

TEST_CASE("radiosity: rows that were damaged in the store are made again", "[radiosity][store][bad input]") {
    const Elements e = room();
    DamagedStore store;
    const std::vector<std::uint64_t> truth = hashes_of(rows_within(e, small, {{}, ~std::uint64_t(0), &store}).factors);
    const auto change = [](const char* name, auto number, std::size_t at) {
        return [=](Bundle& b) {
            for (Array& a : b.arrays) {
                a.bytes.own();
                if (a.name == name) std::memcpy(a.bytes.data() + at * sizeof number, &number, sizeof number);
            }
        };
    };
    const auto cut = [](const char* name) {
        return [=](Bundle& b) {
            for (Array& a : b.arrays)
                if (a.name == name) a.shape[0] -= 1, a.bytes.resize(a.bytes.size() / std::size_t(a.shape[0] + 1) * std::size_t(a.shape[0]));
        };
    };
    const std::function<void(Bundle&)> damages[] = {
        [](Bundle& b) { b.arrays.clear(); },
        cut("rows"), cut("runs"), cut("weights"), cut("scale"), cut("escaped"), cut("back"), cut("sum"),
        change("runs", std::int32_t(-1), 0), change("runs", std::int32_t(1 << 30), 0), change("runs", std::int32_t(1 << 30), 1),
        change("rows", std::int32_t(7), 0), change("rows", std::int32_t(-7), 1), change("rows", std::int32_t(1 << 30), 1),
        change("rows", std::int32_t(3), 6), change("rows", std::int32_t(-2), 3),
    };
    for (std::size_t k = 0; k < std::size(damages); ++k) {
        CAPTURE(k);
        store.damage = damages[k], store.kept = 0;
        const RowsMade made = rows_within(e, small, {{}, ~std::uint64_t(0), &store});
        CHECK(made.found == 0);
        CHECK(store.kept == 4);
        CHECK(hashes_of(made.factors) == truth);
    }
    // One of them alone: no other is made for it.
    int looked = 0;
    store.damage = [&](Bundle& b) {
        if (++looked == 2) b.arrays.clear();
    };
    store.kept = 0;
    const RowsMade one = rows_within(e, small, {{}, ~std::uint64_t(0), &store});
    CHECK(one.found == 3);
    CHECK(store.kept == 1);
    CHECK(hashes_of(one.factors) == truth);
    // Damaged while they are read for each product: the one that is asked for is made again.
    store.damage = nullptr;
    const RowsMade part = rows_within(e, small, {{}, little, &store});
    REQUIRE(part.factors.further);
    store.damage = damages[1], store.kept = 0;
    CHECK(hashes_of(part.factors) == truth);
    CHECK(store.kept > 0);
}

TEST_CASE("radiosity: seconds that rows are foretold are those measured, to a third", "[radiosity]") {
    // data/bench/radiosity.md: rows of boxes of 1,200 to 120,000 triangles, hemicubes of 64, seconds of the processor; and all of the box's.
    const struct {
        int elements, triangles;
        double seconds;
    } measured[] = {{774, 1200, 0.141}, {690, 4800, 0.176}, {690, 19200, 0.338}, {690, 30000, 0.446}, {690, 120000, 1.515}};
    for (const auto& [elements, triangles, seconds] : measured) {
        CAPTURE(triangles);
        CHECK(row_seconds(elements, std::size_t(triangles), 64) == Approx(seconds).epsilon(0.33));
    }
    CHECK(row_seconds(15814, 30000, 64) == Approx(2 * 4.5).epsilon(0.33));  // two cores
}

TEST_CASE("radiosity: memory that rows take is said before they are made, and refused with the number", "[radiosity][bad input]") {
    const Elements e = room();
    const FormFactors f = form_factors(e, small, {});
    const RowPlan plan = plan_rows(e.count(), small.size, ~std::uint64_t(0), false);
    CHECK(plan.fits);
    CHECK(f.bytes() <= plan.most);
    CHECK(plan.expected <= plan.most);
    for (const RowBlock& b : f.blocks) CHECK(b.bytes() <= plan.block);
    // 30,000 triangles of a box as HEM 5.8 has it: 367 MB.
    CHECK(plan_rows(15606, 64, ~std::uint64_t(0), false).expected == 15606ull * (2 * 15606 + 36));
    CHECK(plan_rows(0, 64, 1, false).most == 0);
    // One block in every five that is kept alone costs most; hemicubes of 2 see 36 elements at most.
    CHECK(plan_rows(100000, 2, ~std::uint64_t(0), false).most < 100000ull * 700);

    DamagedStore store;
    const auto asks = [&](std::uint64_t memory, graph::Store* to) -> std::string {
        store.asked = store.kept = 0;
        try {
            rows_within(e, small, {{}, memory, to});
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    CHECK(asks(plan.most, nullptr).empty());
    CHECK_THAT(asks(plan.most - 1, nullptr), Contains("1014 elements with hemicubes of 10 texels") && Contains("without a cache") && Contains("memory_mb = 4 or more"));
    CHECK(asks(2 * plan.block, &store).empty());
    CHECK_THAT(asks(2 * plan.block - 1, &store), Contains("256 elements are read at a time") && Contains("memory_mb = 2 or more"));
    CHECK(store.asked == 0);
    CHECK(store.kept == 0);  // beforehand
    DamagedStore full;
    full.keeps = false;
    CHECK_THAT(asks(little, &full), Contains("cannot be kept on disk"));
    CHECK(asks(plan.most, &full).empty());  // not needed there
}
