#include "gi/stability/unbound_look.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "gi/stability/allowed.h"

namespace plumb::stability {

namespace {

// One invocation, its decisions and what its inputs change.
struct Look {
    const Invocation* invocation;
    DecisionTape tape;
    std::vector<Followed> own, moved;
    std::vector<double> change, of_input;

    void follow() {
        tape.follow();
        moved.clear();
        const FollowScope scope(tape);
        invocation->run(moved);
        for (std::size_t c = 0; c < own.size(); ++c) {
            const double by = std::abs(moved[c].exact - own[c].exact);
            if (is_float(by)) of_input[c] = std::max(of_input[c], by);
        }
    }
    void start_input() { of_input.assign(own.size(), 0); }
    void end_input() {
        for (std::size_t c = 0; c < own.size(); ++c) change[c] += of_input[c];
    }
};

void record(Look& look) {
    look.tape.record();
    const FollowScope scope(look.tape);
    look.invocation->run(look.own);
    look.change.assign(look.own.size(), 0);
}

void move_given(Look& look) {
    for (float& given : look.tape.given) {
        const float own = given;
        look.start_input();
        for (const bool up : {true, false}) {
            given = moved(own, up);
            look.follow();
        }
        given = own;
        look.end_input();
    }
}

void move_inputs(const Subject& subject, int patterns, std::vector<Look>& looks) {
    std::vector<float> before;
    for (const Input& input : subject.inputs) {
        for (Look& l : looks) l.start_input();
        for (int way = 0; way < ways_to_move(input, patterns); ++way) {
            if (move(input, way, before))
                for (Look& l : looks) l.follow();
            put_back(input, before);
        }
        for (Look& l : looks) l.end_input();
    }
}

}  // namespace

void judge(const std::vector<Checked>& numbers, const std::function<std::string(std::size_t)>& place, Cell& cell) {
    double digits = cell.digits_lost > 0 ? host::pow(10, cell.digits_lost) : 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const Checked& n = numbers[i];
        auto told = [&](const std::string& what) {
            return fmt::format("{}: {:.9g}, in truth {:.9g}: {}", place(i), n.got, n.truth, what);
        };
        if (!is_float(n.got) || !is_float(n.truth)) {
            if (cell.nonfinite++ == 0) cell.reason = told("no finite float");
            continue;
        }
        const double error = std::abs(n.got - n.truth), size = std::abs(n.truth);
        const double explained = std::max(eps * n.condition * size, least_step);
        const double used = error / allowed_error(explained, cell.budget), relative = error / std::max(size, least_normal);
        cell.rel_error = std::max(cell.rel_error, relative);
        if (const double lost = error / half_ulp(size); lost > std::max(digits, 1.0)) {
            digits = lost;
            cell.most_lost = told(fmt::format("relative error {:.3g} at condition {:.3g}", relative, n.condition));
        }
        if (used <= cell.used || cell.used != cell.used) continue;
        cell.used = used, cell.condition = n.condition;
        if (cell.nonfinite == 0)
            cell.reason = told(fmt::format("{:.2f} of {:g} {} at condition {:.3g}", used, cell.budget,
                                           by_the_floor(explained, cell.budget) ? "of 2^-126" : "eps condition",
                                           n.condition));
    }
    cell.digits_lost = digits > 1 ? host::log(digits) / host::log(10.0) : 0;
}

void conclude(Cell& cell) {
    cell.ok = (cell.refused || cell.pixels > 0) && cell.nonfinite == 0 && cell.used <= cell.budget;
}

Cell look(const Subject& subject, const Effort& effort) {
    FpEnvironment environment;
    Cell cell;
    cell.stage = subject.stage;
    std::vector<Look> looks(subject.invocations.size());
    for (std::size_t i = 0; i < looks.size(); ++i) looks[i].invocation = &subject.invocations[i], record(looks[i]);
    for (Look& l : looks) move_given(l);
    move_inputs(subject, std::max(effort.patterns, 2), looks);

    for (const Look& l : looks) {
        std::vector<Checked> numbers;
        for (std::size_t c = 0; c < l.own.size(); ++c) {
            const double size = std::max(eps * std::abs(l.own[c].exact), least_step);
            numbers.push_back({l.own[c].value, l.own[c].exact, std::max(1.0, l.change[c] / size)});
        }
        judge(
            numbers, [&](std::size_t c) { return l.invocation->place + ", " + subject.components[c]; }, cell);
        cell.flips += l.tape.flips() > 0;
        ++cell.pixels;
    }
    conclude(cell);
    return cell;
}

void add_columns(const std::string& name, float* rows, std::size_t count, std::size_t stride,
                 const std::vector<std::size_t>& columns, std::vector<Input>& out) {
    for (const std::size_t c : columns)
        if (count > 0)
            out.push_back({fmt::format("{}.{}", name, c), reinterpret_cast<unsigned char*>(rows), c, stride, count});
}

Cell or_refused(const std::string& stage, const std::function<Cell()>& body) {
    try {
        return body();
    } catch (const InputError& e) {
        Cell cell;
        cell.stage = stage;
        cell.refused = true, cell.reason = e.what();
        conclude(cell);
        return cell;
    }
}

}  // namespace plumb::stability
