#include "gi/graph/graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/error.h"

namespace plumb::graph {

namespace {

// Which node it is.
void tell_name(const Node& node, Reads& reads) {
    const NodePlan& p = node.plan;
    reads.text(p.name), reads.text(p.form), reads.text(p.layer);
    reads.value(p.light, p.view);
    const glm::ivec2 size = node.size ? node.size() : glm::ivec2(0);
    reads.value(size.x, size.y);
}

// A key of 0 says that there is none.
Key key_of(const Node& node, bool left_out, Reads& reads) {
    tell_name(node, reads);
    reads.value(left_out);
    if (!left_out)
        node.reads(reads);
    else if (node.reads_left_out)
        node.reads_left_out(reads);
    return reads.key() ? reads.key() : 1;
}

class Run {
  public:
    explicit Run(const RunWith& with) : with_(with), keyed_(with.kept || with.store) {
        if (with.kept) before_ = std::exchange(*with.kept, {});
    }

    NodeRun node(const Node& node) {
        const NodePlan& plan = node.plan;
        NodeRun run;
        run.label = plan.label, run.needed = plan.needed, run.reason = plan.reason;
        run.rule = plan.rule, run.saved_ms = plan.saved_ms, run.parts = plan.parts;
        const bool left_out = !plan.needed || (with_.leaves_out && with_.leaves_out(node, run));
        if (with_.progress && node.listed && !left_out) with_.progress(plan.label, 0);
        Reads reads(written_, keyed_);
        const Key own = key_of(node, left_out, reads);
        if (keyed_) run.key = own;
        run.reads = reads.from();
        const auto start = std::chrono::steady_clock::now();
        const Key key = with_.other_key ? with_.other_key(node, run.key) : run.key;
        if (const KeptOutput* made = with_.kept ? holds(node, key) : nullptr)
            reuse(node, *made, left_out, run);
        else if (left_out)
            node.leave_out();
        else if (!load(node, run))
            make(node, run), store(node, run);
        if (!left_out) run.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        note(node, key, run);
        return run;
    }

    // What joins a node's outputs has made it take so long.
    void joined(const Node& node, double ms) {
        if (with_.kept) with_.kept->at(id_of(node.plan)).run.ms = ms;
    }

    // What was written over is not kept.
    void end() {
        if (!with_.kept) return;
        std::erase_if(*with_.kept, [&](const auto& entry) {
            const KeptOutput& made = entry.second;
            return std::any_of(made.outputs.begin(), made.outputs.end(),
                               [&](const auto& o) { return !written_.is_by(entry.first, o.first, o.second); });
        });
    }

  private:
    static std::vector<std::pair<const void*, std::size_t>> places_of(const Node& node) {
        std::vector<std::pair<const void*, std::size_t>> places;
        const Bundle outputs = node.outputs();
        for (const Array& a : outputs.arrays)
            if (!a.bytes.empty()) places.emplace_back(a.bytes.data(), a.bytes.size());
        return places;
    }

    // What was made before, where it lies now, if it was made from the same.
    const KeptOutput* holds(const Node& node, Key key) const {
        const auto at = before_.find(id_of(node.plan));
        if (at == before_.end() || at->second.key != key || at->second.outputs != places_of(node)) return nullptr;
        const bool over = std::any_of(at->second.outputs.begin(), at->second.outputs.end(),
                                      [&](const auto& o) { return written_.any_in(o.first, o.second); });
        return over && !node.reuse ? nullptr : &at->second;
    }

    void make(const Node& node, NodeRun& run) {
        RunOptions options = with_.options;
        if (with_.progress && node.listed)
            options.progress = [&](double done) { with_.progress(node.plan.label, done); };
        node.run(options, run);
        run.isa = last_dispatched_isa();
    }

    static void reuse(const Node& node, const KeptOutput& made, bool left_out, NodeRun& run) {
        if (node.reuse) node.reuse();
        if (left_out) return;
        run.kept = true;
        run.reason = "kept: nothing that it reads has changed";
        run.saved_ms = made.run.kept ? made.run.saved_ms : made.run.ms;
        run.bytes = made.run.bytes, run.isa = made.run.isa;
    }

    // Whether the store had what the node makes.
    bool load(const Node& node, NodeRun& run) {
        if (!with_.store || !node.load) return false;
        const std::optional<Bundle> found = with_.store->find(run.key);
        if (!found) return false;
        try {
            node.load(*found);
        } catch (const InputError&) {
            return false;  // of another make: it is made anew, and replaced
        }
        run.kept = true;
        run.reason = "kept: it lies in the store";
        return true;
    }
    void store(const Node& node, const NodeRun& run) {
        if (with_.store && node.load) with_.store->keep(run.key, node.outputs(), node.plan.label);
    }

    void note(const Node& node, Key key, const NodeRun& run) {
        const std::string id = id_of(node.plan);
        const KeptOutput made{key, run, places_of(node)};
        const Bundle outputs = node.outputs();
        for (const Array& a : outputs.arrays)
            if (!a.bytes.empty()) written_.write(a.bytes.data(), {a.bytes.size(), run.key, a.name, id, run.label});
        if (with_.kept) (*with_.kept)[id] = made;
    }

    const RunWith& with_;
    const bool keyed_;
    Kept before_;
    Written written_;
};

}  // namespace

bool same_node(const NodePlan& a, const NodePlan& b) {
    return a.name == b.name && a.light == b.light && a.form == b.form && a.view == b.view && a.layer == b.layer;
}

std::string id_of(const NodePlan& plan) {
    return fmt::format("{}|{}|{}|{}|{}", plan.name, plan.light, plan.form, plan.view, plan.layer);
}

void Written::write(const void* at, Range range) {
    const auto* first = static_cast<const unsigned char*>(at);
    auto next = ranges_.lower_bound(first);
    if (next != ranges_.begin() && std::prev(next)->first + std::prev(next)->second.size > first) next = std::prev(next);
    while (next != ranges_.end() && next->first < first + range.size) next = ranges_.erase(next);
    ranges_[first] = std::move(range);
}

bool Written::is_by(const std::string& id, const void* at, std::size_t size) const {
    const auto found = ranges_.find(static_cast<const unsigned char*>(at));
    return found != ranges_.end() && found->second.size == size && found->second.id == id;
}

bool Written::any_in(const void* at, std::size_t size) const {
    const auto* first = static_cast<const unsigned char*>(at);
    auto next = ranges_.lower_bound(first);
    if (next != ranges_.end() && next->first < first + size) return true;
    return next != ranges_.begin() && std::prev(next)->first + std::prev(next)->second.size > first;
}

void Reads::fields(const std::vector<Field>& fields) {
    for (const Field& f : fields) {
        h_.add(f.name);
        std::visit([&](const auto* value) { h_.add(*value); }, f.value);
    }
}

void Reads::source(const std::string& name, Key key) {
    h_.add(name), h_.add(key);
    from_.insert(name);
}

void Reads::memory(const void* at, std::size_t size) {
    h_.add(size);
    if (size == 0) return;
    const auto *first = static_cast<const unsigned char*>(at), *last = first + size;
    auto next = written_.ranges_.upper_bound(first);
    if (next != written_.ranges_.begin()) --next;
    const unsigned char* known = first;  // all before it was written by nodes
    for (; next != written_.ranges_.end() && next->first < last; ++next) {
        const auto& [begin, range] = *next;
        if (begin + range.size <= first) continue;
        if (begin > known) break;
        h_.add(range.key, std::ptrdiff_t(begin - first));
        h_.add(range.output);
        from_.insert(range.label);
        known = begin + range.size;
    }
    if (known == last) return;
    const bool own = std::any_of(own_.begin(), own_.end(), [&](const auto& range) {
        return range.first <= first && last <= range.first + range.second;
    });
    if (!own && hashes_) h_.hash = content_hash(at, size, h_.hash);
}

void Reads::dispatch(const StageBinding& binding, const StageData& data) {
    h_.add(binding.info.name);
    h_.add(data.size.x, data.size.y, data.reversed_z);
    for (const UniformMember& member : binding.uniforms)
        for (const double value : uniform_value(binding, data, member.name)) h_.add(value);
    for (const Array& array : data.inputs.arrays) {
        h_.add(array.name), h_.add(int(array.dtype));
        for (const std::int64_t extent : array.shape) h_.add(extent);
        memory(array.bytes.data(), array.bytes.size());
    }
}

Node repeat(NodePlan plan, Node start, std::vector<Node> nodes, Until until) {
    nodes.insert(nodes.begin(), std::move(start));
    const auto all = std::make_shared<const std::vector<Node>>(std::move(nodes));
    Node node;
    node.plan = std::move(plan);
    node.reads = [=](Reads& r) {
        r.value(until.most, until.enough, bool(until.residual), all->size());
        for (const Node& n : *all) {
            const Bundle outputs = n.outputs();
            for (const Array& a : outputs.arrays) r.own(a.bytes.data(), a.bytes.size());
        }
        for (const Node& n : *all) tell_name(n, r), n.reads(r);
    };
    node.run = [=](const RunOptions& options, NodeRun& run) {
        all->front().run(options, run);
        int round = 0;
        double residual = std::numeric_limits<double>::infinity();
        while (round < until.most && !(residual <= until.enough)) {
            for (auto n = all->begin() + 1; n != all->end(); ++n) n->run(options, run);
            ++round;
            if (until.residual) residual = until.residual();
            if (options.progress) options.progress(double(round) / until.most);
        }
        run.reason += fmt::format("; {} round{}", round, round == 1 ? "" : "s");
        if (until.residual) run.reason += fmt::format(", residual {:.4g}", residual);
        if (until.residual && !(residual <= until.enough)) run.reason += fmt::format(": more than {:g}", until.enough);
    };
    return node;
}

namespace {

std::vector<NodeRun> run_all(std::vector<const Node*> nodes, const RunWith& with) {
    Run run(with);
    std::vector<NodeRun> runs;
    std::size_t last_ran = 0;               // index into runs, plus 1
    const Node* last = nullptr;             // that node
    std::map<std::string, std::vector<std::string>> joins;  // what those that are not listed read, by label
    for (std::size_t at = 0; at < nodes.size(); ++at) {
        const Node* node = nodes[at];
        NodeRun made = run.node(*node);
        if (node->then) {
            const std::vector<const Node*> more = node->then();
            nodes.insert(nodes.begin() + std::ptrdiff_t(at) + 1, more.begin(), more.end());
        }
        std::set<std::string> reads;
        for (const std::string& read : made.reads) {
            const auto joined = joins.find(read);
            if (joined == joins.end())
                reads.insert(read);
            else
                reads.insert(joined->second.begin(), joined->second.end());
        }
        made.reads.assign(reads.begin(), reads.end());
        if (!node->listed) {
            joins[made.label] = made.reads;
            if (last) runs[last_ran - 1].ms += made.ms, run.joined(*last, runs[last_ran - 1].ms);
            continue;
        }
        runs.push_back(std::move(made));
        if (runs.back().needed) last = node, last_ran = runs.size();
    }
    run.end();
    return runs;
}

}  // namespace

std::vector<NodeRun> run(const std::vector<const Node*>& nodes, const RunWith& with) {
    try {
        return run_all(nodes, with);
    } catch (...) {
        if (with.kept) with.kept->clear();
        throw;
    }
}

}  // namespace plumb::graph
