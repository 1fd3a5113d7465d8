#include "tools/plumb/explain_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

const TapValue* find(const std::vector<TapValue>& values, const Sample& s, const std::string& name) {
    for (std::size_t i = s.first; i < s.last; ++i)
        if (values[i].name == name && !values[i].value.empty()) return &values[i];
    return nullptr;
}

std::optional<double> number(const std::vector<TapValue>& values, const Sample& s, const std::string& name) {
    const TapValue* v = find(values, s, name);
    return v ? std::optional(v->value[0]) : std::nullopt;
}

std::optional<int> whole(std::optional<double> value) {
    return value && std::abs(*value) < 0x1p31 ? std::optional(int(*value)) : std::nullopt;
}

// x and y, or an index into the rows of a map; without either the sample's own number is that index, or its place in the
// window around the pixel.
std::optional<glm::dvec2> texel_of(const std::vector<TapValue>& values, const Sample& s, const SampleShape& shape) {
    const TapValue* v = find(values, s, "texel");
    if (!v) v = find(values, s, "coarse");
    if (v && v->value.size() == 2) return glm::dvec2(v->value[0], v->value[1]);
    if (!v && shape.radius.x >= 0 && shape.radius.y >= 0) {
        const int across = 2 * shape.radius.x + 1;
        return glm::dvec2(shape.pixel - shape.radius + glm::ivec2(s.number % across, s.number / across));
    }
    if (shape.map_width <= 0) return {};
    const std::optional<int> index = v ? whole(v->value[0]) : std::optional(s.number);
    if (!index || *index < 0) return {};
    return glm::dvec2(*index % shape.map_width, *index / shape.map_width);
}

// What runs along: the value of that name behind the sample.
const TapValue* running(const std::vector<TapValue>& values, const Sample& s) {
    for (const char* name : {"sum", "row_sum", "count"})
        if (const TapValue* v = find(values, s, name)) return v;
    return nullptr;
}

std::vector<double> product(const std::vector<double>& flux, double factor) {
    std::vector<double> out = flux;
    for (double& c : out) c *= factor;
    return out;
}

// The step of what runs along; a row's sum starts anew where the name does not go on.
std::vector<double> step_of(const TapValue& now, const Sample* before, const std::vector<TapValue>& values) {
    std::vector<double> step = now.value;
    const TapValue* last = before ? find(values, *before, now.name) : nullptr;
    if (last && last->value.size() == step.size())
        for (std::size_t c = 0; c < step.size(); ++c) step[c] -= last->value[c];
    return step;
}

void set_contribution(const std::vector<TapValue>& values, const Sample* before, Sample& s) {
    const TapValue* flux = find(values, s, "flux");
    const TapValue* sum = running(values, s);
    if (sum) s.sum = sum->value;
    if (flux && s.form) {
        s.contribution = product(flux->value, s.weight.value_or(1) * s.visibility.value_or(1) * *s.form);
    } else if (const TapValue* light = find(values, s, "irradiance_i"); light && s.weight) {
        s.contribution = product(light->value, *s.weight);
    } else if (sum) {
        s.contribution = step_of(*sum, before, values);
    } else if (const TapValue* e = find(values, s, "E")) {
        s.contribution = e->value;
    } else if (s.weight) {
        s.contribution = {*s.weight};
    }
}

std::string texel_text(const Sample& s) {
    return s.texel ? fmt::format("{:g},{:g}", s.texel->x, s.texel->y) : "";
}

std::string short_text(double value) { return fmt::format("{:.4g}", value); }
std::string short_text(const std::vector<double>& value) {
    std::string text;
    for (const double v : value) text += (text.empty() ? "" : " ") + short_text(v);
    return text;
}
std::string short_text(const std::optional<double>& value) { return value ? short_text(*value) : ""; }

// A column that is there where any sample has it.
struct Column0 {
    std::string head;
    std::string (*text)(const Sample&);
};

SampleTable gather_table(const Samples& samples, const std::vector<std::size_t>& rows) {
    const std::vector<Column0> all = {
        {"sample", [](const Sample& s) { return fmt::format("{}", s.number); }},
        {"path", [](const Sample& s) { return s.path ? fmt::format("{}", *s.path) : ""; }},
        {"step", [](const Sample& s) { return s.step ? fmt::format("{}", *s.step) : ""; }},
        {"texel", texel_text},
        {"inside", [](const Sample& s) -> std::string { return s.inside ? "1" : "0"; }},
        {"slot", [](const Sample& s) { return short_text(s.slot); }},
        {"visibility", [](const Sample& s) { return short_text(s.visibility); }},
        {"weight", [](const Sample& s) { return short_text(s.weight); }},
        // Outside of the map the kernel goes on with texel 0 and weight 0, whose form says nothing of this sample.
        {"form", [](const Sample& s) -> std::string { return s.form && !s.inside ? "-" : short_text(s.form); }},
        {"contribution", [](const Sample& s) { return short_text(s.contribution); }},
        {"sum", [](const Sample& s) { return short_text(s.sum); }},
    };
    SampleTable table;
    for (const Column0& column : all) {
        const bool any = std::any_of(samples.all.begin(), samples.all.end(),
                                     [&](const Sample& s) { return !column.text(s).empty(); });
        if (!any) continue;
        table.head.push_back(column.head);
        table.rows.resize(rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) table.rows[i].push_back(column.text(samples.all[rows[i]]));
    }
    return table;
}

// Every name of a sample, in the order in which names first come.
SampleTable plain_table(const Samples& samples, const std::vector<TapValue>& values,
                        const std::vector<std::size_t>& rows) {
    SampleTable table{{"sample"}, {}};
    for (const Sample& s : samples.all)
        for (std::size_t i = s.first; i < s.last; ++i)
            if (std::find(table.head.begin(), table.head.end(), values[i].name) == table.head.end())
                table.head.push_back(values[i].name);
    for (const std::size_t r : rows) {
        const Sample& s = samples.all[r];
        std::vector<std::string> row = {fmt::format("{}", s.number)};
        for (std::size_t c = 1; c < table.head.size(); ++c) {
            const TapValue* v = find(values, s, table.head[c]);
            row.push_back(!v ? "" : v->name == "texel" ? texel_text(s) : short_text(v->value));
        }
        table.rows.push_back(std::move(row));
    }
    return table;
}

}  // namespace

double Sample::brought() const {
    if (contribution.empty()) return 0;
    const double light = contribution.size() < 3
                             ? contribution[0]
                             : 0.2126 * contribution[0] + 0.7152 * contribution[1] + 0.0722 * contribution[2];
    return light > 0 ? light : 0;
}

double Sample::magnitude() const {
    Sample unsigned_one;
    for (const double c : contribution) {
        if (std::isnan(c)) return std::numeric_limits<double>::infinity();
        unsigned_one.contribution.push_back(std::abs(c));
    }
    return unsigned_one.brought();
}

bool Sample::brings_nothing() const {
    return !contribution.empty() && std::all_of(contribution.begin(), contribution.end(), [](double c) { return c == 0; });
}

double Samples::total() const {
    double sum = 0;
    for (const Sample& s : all) sum += s.brought();
    return sum;
}

Samples samples_of(const std::vector<TapValue>& values, const SampleShape& shape) {
    Samples out;
    for (std::size_t i = 0; i < values.size();) {
        Sample s;
        s.number = values[i].sample, s.first = i;
        while (i < values.size() && values[i].sample == s.number) ++i;
        s.last = i;
        if (s.number < 0) continue;
        s.path = whole(number(values, s, "path")), s.step = whole(number(values, s, "step"));
        if (!s.path && shape.steps > 0) s.path = s.number / shape.steps, s.step = s.number % shape.steps;
        s.texel = texel_of(values, s, shape);
        s.slot = number(values, s, "slot"), s.weight = number(values, s, "weight");
        s.visibility = number(values, s, "visibility"), s.form = number(values, s, "form");
        if (!s.visibility) s.visibility = number(values, s, "visible");
        s.inside = number(values, s, "inside").value_or(1) != 0;
        set_contribution(values, out.all.empty() ? nullptr : &out.all.back(), s);
        out.gathers |= s.form && find(values, s, "flux");
        out.most = std::max(out.most, s.brought());
        out.together.resize(std::max(out.together.size(), s.contribution.size()));
        for (std::size_t c = 0; c < s.contribution.size(); ++c) out.together[c] += s.contribution[c];
        out.all.push_back(std::move(s));
    }
    return out;
}

std::vector<TapValue> our_values(const parity::SideBySide& values) {
    std::vector<TapValue> ours;
    for (const parity::TwoValues& v : values.lines)
        ours.push_back({v.name, v.sample, v.ours.value_or(std::vector<double>()), v.equation});
    return ours;
}

SampleTable sample_table(const Samples& samples, const std::vector<TapValue>& values,
                         const std::vector<std::size_t>& rows) {
    return samples.gathers ? gather_table(samples, rows) : plain_table(samples, values, rows);
}

std::vector<std::size_t> every_sample(const Samples& samples) {
    std::vector<std::size_t> rows(samples.all.size());
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
    return rows;
}

std::vector<std::size_t> by_contribution(const Samples& samples, std::size_t first, std::size_t last) {
    std::vector<std::pair<double, std::size_t>> sized;
    for (std::size_t i = first; i < last; ++i) sized.push_back({samples.all[i].magnitude(), i});
    std::stable_sort(sized.begin(), sized.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<std::size_t> rows;
    for (const auto& [size, row] : sized) rows.push_back(row);
    return rows;
}

std::size_t end_of_run(const Samples& samples, std::size_t first) {
    std::size_t end = first + 1;
    while (end < samples.all.size() && samples.all[end].first == samples.all[end - 1].last) ++end;
    return end;
}

std::vector<TapValue> by_contribution(const std::vector<TapValue>& values) {
    const Samples samples = samples_of(values, {});
    std::vector<TapValue> out;
    for (std::size_t i = 0, sample = 0; i < values.size();) {
        if (values[i].sample < 0) {
            out.push_back(values[i++]);
            continue;
        }
        const std::size_t end = end_of_run(samples, sample);
        for (const std::size_t row : by_contribution(samples, sample, end))
            out.insert(out.end(), values.begin() + std::ptrdiff_t(samples.all[row].first), values.begin() + std::ptrdiff_t(samples.all[row].last));
        i = samples.all[end - 1].last, sample = end;
    }
    return out;
}

std::string nothing_brought(const Samples& samples) {
    std::size_t known = 0, nothing = 0;
    for (const Sample& s : samples.all) known += !s.contribution.empty(), nothing += s.brings_nothing();
    if (known == 0) return "";
    return fmt::format("{} of {} samples bring{} 0", nothing, samples.all.size(), nothing == 1 ? "s" : "");
}

std::string samples_text(const std::vector<TapValue>& values, const SampleShape& shape) {
    const Samples samples = samples_of(values, shape);
    const std::string nothing = nothing_brought(samples);
    if (nothing.empty()) return "";
    if (!samples.gathers) return "samples: what brings most comes first; " + nothing + "\n";
    std::vector<std::size_t> rows = by_contribution(samples, 0, samples.all.size());
    std::erase_if(rows, [&](std::size_t row) { return samples.all[row].brings_nothing(); });
    std::string text;
    if (!rows.empty()) {
        const SampleTable table = sample_table(samples, values, rows);
        std::vector<Column> columns;
        for (const std::string& head : table.head) columns.push_back({head, Align::right});
        text = "what each sample brings, largest first: weight visibility flux form (VRSM (3.2))\n" + format_table(columns, table.rows);
    }
    return text + nothing + fmt::format("\ntogether: {}\n", exact_text(samples.together));
}

}  // namespace plumb::cli
