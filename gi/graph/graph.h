// A graph of nodes: what there is to run, what each node reads and writes, and what of it need not run again. It knows no
// method: what a node does are functions that it was given.
//
// Nodes run in the order in which they were added. What a node reads it tells before it runs: parameters by their values,
// and memory by its address. Memory that a node before it wrote counts by that node's key, any other by its content. So what a
// dispatch binds is in the key, and an edge of the graph is an address: neither is written down a second time. Equal keys are
// equal bits.
//
// A node without a twin (a host node) is the same but for its dispatches. What a node makes is kept in memory from one run to
// the next (Kept) and, where the node can load it, in a store that outlives the program (store.h): what is found there does
// not run, so that a run that was killed goes on where it was. Facts that a host node finds out (counts, extents) are arrays
// among its outputs, and are kept beside them. repeat() makes a node of a group that runs until a residual is small enough.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/binding.h"
#include "core/content_hasher.h"
#include "core/fields.h"
#include "gi/graph/store.h"

namespace plumb::graph {

// A part of a node's work that a rule leaves out.
struct LeftOut {
    std::string rule;
    std::string reason;  // "no emission: nothing emits"
    double saved_ms = 0;
};

// What is known of a node before it runs.
struct NodePlan {
    std::string name;      // of the kind of work: a stage as `plumb stages` lists it
    int light = -1;        // index into Scene::lights, for work that is done once a light
    std::string label;     // as people read it: "rsm.disc (key)"
    bool needed = true;
    std::string reason;    // why it is needed, or why it is left out
    std::string rule;      // the rule that leaves it out, or empty
    std::string form;      // of work that is done more than once: "position", "horizontal", "bounce 2"
    int view = 0;          // which of several views it draws or reads; 0: the frame itself
    std::string layer;     // which layer it makes
    int samples = 0;       // paths a pixel; 0: as many as it takes
    double work = 0;       // how often its inner loop runs: pixels, triangles, samples
    std::string work_unit;
    double expected_ms = 0;  // on one core with AVX-512, from the benchmark's figures; an order of magnitude
    double saved_ms = 0;     // what leaving it out, or parts of it, is expected to save; the same order of magnitude
    std::vector<LeftOut> parts;  // of a node that is needed
};

// Whether both plans are of the same node.
bool same_node(const NodePlan& a, const NodePlan& b);

// What became of a node.
struct NodeRun {
    std::string label;
    bool needed = true;
    bool kept = false;      // not run: what it makes was kept from an earlier run, or lies in the store
    std::string reason;
    std::string rule;       // as NodePlan has it
    double saved_ms = 0;    // of a kept node: what making it took; of one left out: as NodePlan has it
    std::vector<LeftOut> parts;  // as NodePlan has them, and those that only the run could tell
    double ms = 0;
    std::size_t bytes = 0;  // of its output
    Isa isa = Isa::scalar;  // of the kernels that ran
    Key key = 0;            // 0: nothing is kept
    std::vector<std::string> reads;  // labels of the nodes, and sources, that it reads; no two alike
};

// Which node wrote which memory last.
class Written {
  public:
    struct Range {
        std::size_t size = 0;  // bytes
        Key key = 0;
        std::string output;     // which of the node's
        std::string id, label;  // of the node
    };
    // What lay there is gone.
    void write(const void* at, Range range);
    // Whether that node was the last to write all of it.
    bool is_by(const std::string& id, const void* at, std::size_t size) const;
    // Whether any node has written any of it.
    bool any_in(const void* at, std::size_t size) const;

  private:
    friend class Reads;
    std::map<const unsigned char*, Range> ranges_;  // none overlaps another
};

// What a node reads: the functions it may call before it runs.
class Reads {
  public:
    // hashes: else it only tells who wrote what is read, and there is no key.
    explicit Reads(const Written& written, bool hashes = true) : written_(written), hashes_(hashes) {}

    // Memory that the node itself writes before it reads it: what lies there counts only where an earlier node wrote it.
    void own(const void* at, std::size_t size) { own_.emplace_back(static_cast<const unsigned char*>(at), size); }

    // Parameters, bit by bit.
    template <class... T>
    void value(const T&... values) {
        h_.add(values...);
    }
    void text(const std::string& text) { h_.add(text); }
    bool hashes() const { return hashes_; }
    void fields(const std::vector<Field>& fields);
    // What does not come from a node: a part of the scene.
    void source(const std::string& name, Key key);
    // Memory: the keys of those that wrote it, or its content.
    void memory(const void* at, std::size_t size);
    template <class T>
    void image(const Image<T>& image) {
        h_.add(image.width, image.height);
        memory(image.data(), image.size() * sizeof(T));
    }
    template <class T>
    void list(const T& values) {
        memory(values.data(), values.size() * sizeof(values[0]));
    }
    // Memory that the node finds changed by a node of that label, where the key does not depend on it.
    void edge(const std::string& label) { from_.insert(label); }
    // All that a dispatch binds: its size, the members of its block, its inputs.
    void dispatch(const StageBinding& binding, const StageData& data);

    Key key() const { return h_.hash; }
    std::vector<std::string> from() const { return {from_.begin(), from_.end()}; }

  private:
    const Written& written_;
    const bool hashes_;
    ContentHasher h_;
    std::set<std::string> from_;
    std::vector<std::pair<const unsigned char*, std::size_t>> own_;
};

struct Node {
    NodePlan plan;
    bool listed = true;  // false: it has no row of its own; it joins what others made

    // Says all that it reads.
    std::function<void(Reads&)> reads;
    // The same of what leave_out() writes; may be missing.
    std::function<void(Reads&)> reads_left_out = {};
    // What it has written: lent arrays, by the names of its stage's outputs.
    std::function<Bundle()> outputs;
    // Writes all of its outputs.
    std::function<void(const RunOptions&, NodeRun&)> run;
    // The same where it is left out.
    std::function<void()> leave_out;
    // Writes those outputs again that an earlier node of the same run writes as well, where they are kept; may be missing.
    std::function<void()> reuse = {};

    // Takes its outputs from a bundle that outputs() once returned; missing: they are kept in no store. Throws InputError for
    // one that does not fit.
    std::function<void(const Bundle&)> load = {};

    // Nodes that run at once after it and that only it could tell, as how many blocks there are; the caller holds them. May be
    // missing.
    std::function<std::vector<const Node*>()> then = {};

    // What a device would be given, of what lies in memory now, lent; missing where nothing has a twin.
    std::function<std::vector<StageData>()> dispatches = {};
    // Every named value of one item; missing where there is nothing to name.
    std::function<std::vector<TapValue>(glm::ivec2)> explain = {};
    std::function<glm::ivec2()> size;  // items of the domain
};

// What a node made in an earlier run.
struct KeptOutput {
    Key key = 0;
    NodeRun run;
    std::vector<std::pair<const void*, std::size_t>> outputs;  // where it lies
};
using Kept = std::map<std::string, KeptOutput>;  // by id_of(); empty: nothing to rely on

// A name of a node that no other node of the graph has.
std::string id_of(const NodePlan& plan);

// Called before each node and while it runs: its label and the share that is done.
using Progress = std::function<void(const std::string& label, double done)>;

struct RunWith {
    RunOptions options;
    Progress progress = {};
    Kept* kept = nullptr;    // nodes whose outputs lie there do not run; null: nothing is kept in memory
    Store* store = nullptr;  // the same of nodes that can load them; without either there are no keys
    // Rules that only the run can ask: whether all of the node is left out; then the run says so.
    std::function<bool(const Node&, NodeRun&)> leaves_out = {};
    // Another key than the node's own, for what is kept: a test breaks one and must see the picture change.
    std::function<Key(const Node&, Key)> other_key = {};
};

// When a group of nodes has run often enough.
struct Until {
    int most = 1;                        // rounds
    double enough = 0;                   // residual at which no further round runs
    std::function<double()> residual = {};  // of the round before; missing: all rounds run. NaN never is enough
};
// A node that runs `start` once and then `body` in rounds. `start` writes what the body reads in its first round; both may read
// what earlier nodes made. Memory that they write is allocated before the node is asked what it reads. `plan` is the node's own;
// its outputs, its size and what else a node has are the caller's to add.
Node repeat(NodePlan plan, Node start, std::vector<Node> body, Until until);

// Runs the nodes one after the other. Returns what became of each that is listed. After an exception nothing is kept.
std::vector<NodeRun> run(const std::vector<const Node*>& nodes, const RunWith& with);

}  // namespace plumb::graph
