#include "tools/plumb/diagnosis_mutants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "core/error.h"
#include "tools/plumb/devices.h"

#ifdef PLUMB_WITH_VULKAN
#include "tools/mutants/edit.h"
#include "tools/mutants/selectable.h"
#include "tools/vulkan/runner.h"
#include "tools/vulkan/twins.h"
#endif

namespace plumb::cli {

#ifdef PLUMB_WITH_VULKAN

namespace {

using mutants::Change;
using mutants::Instruction;
using mutants::Site;

// A device rounds otherwise than the one that was dumped, and has no bound: what is this near, of a texel's largest,
// agrees.
constexpr double device_slack = 0x1p-13;
// Pixels whose groups alone are run.
constexpr std::size_t most_pixels = 4096;
// Turns of all loops of an invocation.
constexpr std::uint32_t most_turns = 1 << 20;

const char* operator_of(std::uint32_t op) {
    using namespace mutants;
    switch (op) {
        case op_i_add:
        case op_f_add:
            return "+";
        case op_i_sub:
        case op_f_sub:
            return "-";
        case op_i_mul:
        case op_f_mul:
        case op_vector_times_scalar:
            return "*";
        case op_u_div:
        case op_s_div:
        case op_f_div:
            return "/";
        case op_u_greater:
        case op_s_greater:
        case op_f_greater:
            return ">";
        case op_u_greater_equal:
        case op_s_greater_equal:
        case op_f_greater_equal:
            return ">=";
        case op_u_less:
        case op_s_less:
        case op_f_less:
            return "<";
        case op_u_less_equal:
        case op_s_less_equal:
        case op_f_less_equal:
            return "<=";
        case op_i_equal:
        case op_f_equal:
            return "==";
        case op_i_not_equal:
        case op_f_not_equal:
            return "!=";
        case op_logical_and:
            return "&&";
        case op_logical_or:
            return "||";
        default:
            return nullptr;
    }
}

const char* function_of(std::uint32_t number) {
    using namespace mutants;
    switch (number) {
        case glsl_round_even:
            return "roundEven";
        case glsl_f_abs:
        case glsl_s_abs:
            return "abs";
        case glsl_floor:
            return "floor";
        case glsl_ceil:
            return "ceil";
        case glsl_fract:
            return "fract";
        case glsl_sqrt:
            return "sqrt";
        case glsl_inverse_sqrt:
            return "inversesqrt";
        case glsl_f_min:
        case glsl_u_min:
        case glsl_s_min:
            return "min";
        case glsl_f_max:
        case glsl_u_max:
        case glsl_s_max:
            return "max";
        case glsl_f_clamp:
        case glsl_u_clamp:
        case glsl_s_clamp:
            return "clamp";
        case glsl_normalize:
            return "normalize";
        default:
            return "f";
    }
}

// A value of the twin as GLSL might say it, by the names of its variables.
class Expressions {
  public:
    explicit Expressions(const mutants::SpirvIndex& index) : index_(index) {}

    std::string of(std::uint32_t id, int depth = 3) const {
        using namespace mutants;
        const Instruction* i = index_.definition(id);
        if (!i) return "..";
        if (const std::string name = index_.name(id); !name.empty() && i->opcode == op_variable) return name;
        if (i->opcode == op_constant) return constant(*i);
        if (depth == 0) return "..";
        if (i->opcode == op_load || i->opcode == op_copy_object) return of(i->words[2], depth);
        if (i->opcode == op_access_chain)
            return of(i->words[2], depth) + (i->words.size() > 3 ? component(i->words.back()) : "");
        if (i->opcode == op_composite_extract) return of(i->words[2], depth) + "." + letter(i->words[3]);
        if (i->opcode == op_f_negate || i->opcode == op_s_negate) return "-" + of(i->words[2], depth - 1);
        if (i->opcode == op_logical_not) return "!" + of(i->words[2], depth - 1);
        if (i->opcode == op_function_call) return short_name(index_.name(i->words[2])) + "()";
        if (const char* sign = operator_of(i->opcode); sign && i->words.size() >= 4) {
            const std::string text = of(i->words[2], depth - 1) + " " + sign + " " + of(i->words[3], depth - 1);
            return depth == 3 ? text : "(" + text + ")";
        }
        if (i->opcode == op_ext_inst) {
            std::string text = std::string(function_of(i->words[3])) + "(";
            for (std::size_t k = 4; k < i->words.size(); ++k) text += (k > 4 ? ", " : "") + of(i->words[k], depth - 1);
            return text + ")";
        }
        return "..";
    }

  private:
    static std::string short_name(const std::string& name) { return name.substr(0, name.find('(')); }
    static std::string letter(std::uint32_t n) { return n < 4 ? std::string(1, "xyzw"[n]) : fmt::format("{}", n); }
    std::string component(std::uint32_t id) const {
        const Instruction* i = index_.definition(id);
        return i && i->opcode == mutants::op_constant ? "." + letter(i->words[2]) : "[" + of(id, 1) + "]";
    }
    std::string constant(const Instruction& i) const {
        float f;
        std::memcpy(&f, &i.words[2], 4);
        return index_.is_float(i.words[0]) ? fmt::format("{:g}", f) : fmt::format("{}", std::int32_t(i.words[2]));
    }

    const mutants::SpirvIndex& index_;
};

// What is done to an expression; "" for what nobody does by mistake.
std::string words_of(const Site& site) {
    const char* which = site.part == 0 ? "first" : "second";
    switch (site.change) {
        case Change::plus_minus:
            return "with + for -, or - for +";
        case Change::times_divide:
            return "with * for /, or / for *";
        case Change::min_max:
            return "with min and max exchanged";
        case Change::comparison_turned:
            return "the other way round";
        case Change::boundary_moved:
            return "with its boundary on the other side";
        case Change::condition_dropped:
            return fmt::format("without the {} condition", which);
        case Change::saturate_dropped:
            return "not clamped to 0..1";
        case Change::limit_dropped:
            return "without its limit";
        case Change::function_dropped:
            return "without that function";
        case Change::normalize_dropped:
            return "not normalised";
        case Change::term_dropped:
            return fmt::format("without the {} term", which);
        case Change::factor_dropped:
            return fmt::format("without the {} factor", which);
        case Change::constant_plus_one:
            return "with 1 more in its constant";
        case Change::loop_bound:
            return site.part == 0 ? "one turn less" : "one turn more";
        case Change::components_swapped:
            return "with components swapped";
        case Change::neighbour_read:
            return site.part == 1 ? "read in the next row" : "read at the next place";
        case Change::input_dropped:  // as inputs and uniforms that are not read
        case Change::constant_scaled:
        case Change::input_scaled:
            return "";
    }
    return "";
}

// What people do beside the changes of generic mutants.
enum class Slip : int {
    abs_for_max,    // abs(x) for max(0, x)
    first_twice,    // a a b for a b
    second_twice,   // a b b for a b, a / b / b for a / b
};

// Puts it in the place of the instruction.
void make_slip(mutants::Editor& e, std::size_t at, Slip slip) {
    using namespace mutants;
    Instruction& i = e[at];
    if (slip == Slip::abs_for_max) {
        const std::uint32_t kept = e.index().is_float_constant(i.words[4], 0) ? i.words[5] : i.words[4];
        i = {op_ext_inst, {i.words[0], i.words[1], i.words[2], glsl_f_abs, kept}};
    } else {
        const std::uint32_t once = e.new_id(), again = i.words[slip == Slip::first_twice ? 2 : 3];
        e.before(at, {i.opcode, {i.words[0], once, i.words[2], i.words[3]}});
        i = {i.opcode, {i.words[0], i.words[1], once, again}};
    }
}

struct PlacedSlip {
    Slip slip;
    std::size_t at;
    std::string words;
};
std::vector<PlacedSlip> slips_of(const mutants::SpirvModule& module, const mutants::SpirvIndex& index) {
    using namespace mutants;
    std::vector<PlacedSlip> all;
    for (std::size_t at = index.first_function(); at < module.code.size(); ++at) {
        const Instruction& i = module.code[at];
        if (i.opcode == op_ext_inst && i.words[3] == glsl_f_max &&
            (index.is_float_constant(i.words[4], 0) || index.is_float_constant(i.words[5], 0)))
            all.push_back({Slip::abs_for_max, at, "as abs()"});
        const bool product = i.opcode == op_f_mul, quotient = i.opcode == op_f_div;
        if (product && !index.is_constant(i.words[2]))
            all.push_back({Slip::first_twice, at, "with the first factor twice"});
        if ((product || quotient) && !index.is_constant(i.words[3]))
            all.push_back({Slip::second_twice, at, product ? "with the second factor twice" : "with its divisor twice"});
    }
    return all;
}

// A module that runs, and what it changes: one thing, or one of many, by the z of its invocations.
struct Wave {
    std::vector<mutants::PlacedChange> changes;
    bool selects = true;
};

// The twin with its data on the device; other shaders run there one by one.
struct Held {
    mutants::SpirvModule module;
    mutants::SpirvIndex index;
    vulkan::PreparedTwin twin;
    std::vector<Wave> waves;
    std::optional<std::size_t> running;  // of the waves

    Held(const vulkan::Device& device, const StageBinding& binding, const StageData& data,
         std::span<const std::uint32_t> spirv)
        : module(mutants::parse_spirv(spirv)), index(module), twin(device, binding, data, selecting()) {}
    static vulkan::RunTwin selecting() {
        vulkan::RunTwin options;
        options.selects = true;
        return options;
    }

    // Which wave has the change from now on, and its number there, from 1; 0: it is alone.
    std::pair<std::size_t, std::uint32_t> placed(mutants::PlacedChange change, bool selects) {
        std::size_t w = 0;
        const auto taken = [&](const Wave& wave) {
            return !selects || !wave.selects ||
                   std::any_of(wave.changes.begin(), wave.changes.end(),
                               [&](const mutants::PlacedChange& c) { return c.at == change.at; });
        };
        while (w < waves.size() && taken(waves[w])) ++w;
        if (w == waves.size()) waves.push_back({{}, selects});
        waves[w].changes.push_back(std::move(change));
        return {w, selects ? std::uint32_t(waves[w].changes.size()) : 0};
    }

    mutants::SpirvModule of(const Wave& wave) const {
        if (wave.selects) return mutants::selectable(module, index, wave.changes);
        mutants::Editor e(module, index);
        wave.changes[0].edit(e);
        return e.apply();
    }

    bool run(std::size_t wave, std::uint32_t number, std::span<const glm::ivec2> pixels, Bundle& outputs) {
        try {
            if (running != wave) {
                running = {};
                twin.use(mutants::words_of(mutants::guarded(of(waves[wave]), most_turns)));
                running = wave;
            }
            // Most groups have some of many pixels.
            twin.select(number, pixels.size() > most_pixels ? std::span<const glm::ivec2>{} : pixels);
            twin.submit();
            outputs = twin.read().outputs;
        } catch (const vulkan::Error&) {
            return false;
        }
        return true;
    }
};

}  // namespace

struct TwinMutants::Parts {
    vulkan::Device device;
    explicit Parts(const std::string& name) : device(vulkan::DeviceOptions{name, false}) {}
};

TwinMutants::TwinMutants(const std::string& device) {
    try {
        parts_ = std::make_unique<Parts>(device);
    } catch (const vulkan::Error& error) {
        throw InputError(fmt::format("--mutants {}: {}", device, error.what()));
    }
}

std::vector<parity::Hypothesis> TwinMutants::of(const StageBinding& binding, const StageData& data) const {
    std::vector<parity::Hypothesis> all;
    std::shared_ptr<Held> held;
    try {
        const vulkan::Twin twin = vulkan::find_twin(binding.raster ? binding.twin + ".frag" : binding.twin);
        held = std::make_shared<Held>(parts_->device, binding, data, twin.spirv);
    } catch (const vulkan::Error&) {
        return all;
    }
    const Expressions expressions(held->index);
    const bool compute = !binding.raster;
    std::vector<std::pair<std::size_t, parity::Hypothesis>> placed;  // by their waves
    auto add = [&](std::size_t at, const std::string& words, std::function<void(mutants::Editor&)> edit) {
        const Instruction& i = held->module.code[at];
        const std::string what = mutants::has_result(i.opcode) ? expressions.of(i.words[1]) : "..";
        const bool selects = compute && mutants::is_selectable(held->module, held->index, at);
        // A module for each of them alone takes its time; of addresses there are many.
        if (!selects && i.opcode == mutants::op_access_chain) return;
        const auto [wave, number] = held->placed({at, std::move(edit)}, selects);
        parity::Hypothesis h{fmt::format("{} {} in {}()", what, words, held->index.places()[at].function)};
        h.outputs = [held, wave = wave, number = number](std::span<const glm::ivec2> pixels, Bundle& outputs) {
            return held->run(wave, number, pixels, outputs);
        };
        h.slack = device_slack;
        placed.push_back({wave, std::move(h)});
    };
    for (const Site& site : mutants::find_sites(held->module, held->index))
        if (const std::string words = words_of(site); !words.empty())
            add(site.at, words, [site, held = held.get()](mutants::Editor& e) { mutants::edit(e, held->module, site); });
    for (const PlacedSlip& slip : slips_of(held->module, held->index))
        add(slip.at, slip.words, [slip](mutants::Editor& e) { make_slip(e, slip.at, slip.slip); });
    // A wave is compiled once for all that it has.
    std::stable_sort(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [wave, h] : placed) all.push_back(std::move(h));
    return all;
}

#else

struct TwinMutants::Parts {};

TwinMutants::TwinMutants(const std::string&) { require_vulkan("--mutants"); }
std::vector<parity::Hypothesis> TwinMutants::of(const StageBinding&, const StageData&) const { return {}; }

#endif

TwinMutants::~TwinMutants() = default;

}  // namespace plumb::cli
