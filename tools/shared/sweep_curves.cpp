// Which curves and points a sweep has: from the ranges that the stages' fields() give.
#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/nearest_known.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

namespace {

using Role = SweepRange::Role;

// --vary: the values of one parameter.
struct Asked {
    Variation variation;
    std::string place;
};

// As set_field() takes it: of an enumeration the word.
FieldValue field_value(const Field& field, double number) {
    if (!field.choices.empty()) return field.choices.at(std::size_t(number));
    if (std::holds_alternative<bool*>(field.value)) return number != 0;
    return number;
}

FieldValue value_of(const Field& field) {
    if (!field.choices.empty()) return field.choices.at(std::size_t(*std::get<int*>(field.value)));
    if (auto p = std::get_if<int*>(&field.value)) return double(**p);
    if (auto p = std::get_if<float*>(&field.value)) return double(**p);
    if (auto p = std::get_if<bool*>(&field.value)) return **p;
    if (auto p = std::get_if<std::string*>(&field.value)) return **p;
    return **std::get_if<glm::vec3*>(&field.value);
}

// As a person writes it: the value that a parameter takes, not the double that a float becomes.
std::string text_of(const FieldValue& value) {
    if (auto p = std::get_if<double>(&value)) return fmt::format("{}", *p);
    if (auto p = std::get_if<bool>(&value)) return *p ? "true" : "false";
    if (auto p = std::get_if<std::string>(&value)) return *p;
    const glm::vec3& v = std::get<glm::vec3>(value);
    return fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
}

Asked parse_vary(frame::Settings settings, const std::string& text) {
    const std::size_t equals = text.find('='), dot = text.substr(0, equals).find('.');
    if (equals == std::string::npos || dot == std::string::npos || dot == 0 || dot + 1 == equals ||
        equals + 1 == text.size())
        throw InputError(fmt::format("--vary {}: expected table.key=a,b,c, as in --vary rsm.samples=50,100", text));
    Asked asked{{text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), {}}, "--vary " + text.substr(0, equals)};
    std::vector<Field> fields = frame::table_fields(settings, asked.variation.table, asked.place);
    Field& field = find_field(fields, asked.variation.key, asked.place);
    std::string rest = text.substr(equals + 1) + ",";
    for (std::size_t comma; (comma = rest.find(',')) != std::string::npos; rest = rest.substr(comma + 1)) {
        const FieldValue value = parse_value(rest.substr(0, comma));
        set_field(field, value, asked.place);
        for (const FieldValue& before : asked.variation.values)
            if (text_of(before) == text_of(value))
                throw InputError(fmt::format("{}: {} stands there twice", asked.place, text_of(value)));
        asked.variation.values.push_back(value);
    }
    return asked;
}

// A parameter of a method, by its table.
struct Own : Field {
    std::string table;
};

// Tables whose parameters no other method reads: the one of the method's own name, and what else it has.
std::vector<std::string> tables_of(frame::Method method) {
    const std::string name = frame::method_name(method);
    const std::vector<std::string> tables = frame::method_tables();
    std::vector<std::string> own;
    if (std::find(tables.begin(), tables.end(), name) != tables.end()) own.push_back(name);
    if (method == frame::Method::probes) own.push_back("lod");
    return own;
}

bool has(const std::vector<std::string>& words, const std::string& word) { return std::find(words.begin(), words.end(), word) != words.end(); }

bool is_of_a_method(const std::string& table) {
    const std::vector<frame::MethodInfo>& all = frame::methods();
    return std::any_of(all.begin(), all.end(), [&](const frame::MethodInfo& m) { return has(tables_of(m.method), table); });
}

// Parameters that others name as their condition and that have a curve for each of their values: rsm.gather.
bool selects(const std::vector<Own>& fields, const Own& field) {
    return !field.choices.empty() && std::any_of(fields.begin(), fields.end(), [&](const Own& f) {
        return f.table == field.table && f.sweep.when == field.name;
    });
}

const Asked* find_asked(const std::vector<Asked>& asked, const std::string& table, const std::string& key) {
    for (const Asked& a : asked)
        if (a.variation.table == table && a.variation.key == key) return &a;
    return nullptr;
}

// One curve under construction: a method, and the words that its selectors have.
class Curves {
  public:
    Curves(const frame::Settings& settings, frame::Method method, const std::vector<Asked>& asked)
        : settings_(settings), method_(method), tables_(tables_of(method)), asked_(asked) {
        for (const std::string& table : tables_)
            for (const Field& field : frame::table_fields(settings_, table, table)) fields_.push_back({field, table});
    }

    std::vector<SweptMethod> all() {
        std::vector<SweptMethod> curves = {{frame::method_name(method_), method_, {}, {}}};
        for (const Own& f : fields_) {
            if (!selects(fields_, f)) continue;
            const Asked* asked = find_asked(asked_, f.table, f.name);
            std::vector<SweptMethod> chosen;
            for (const SweptMethod& curve : curves)
                for (const FieldValue& value : asked ? asked->variation.values : values(f)) {
                    chosen.push_back(curve);
                    chosen.back().name += "." + text_of(value);
                    chosen.back().fixed.push_back({f.table, f.name, value, ""});
                }
            curves = chosen;
        }
        std::vector<SweptMethod> result;
        for (const SweptMethod& curve : curves) add(curve, result);
        return result;
    }

  private:
    static std::vector<FieldValue> values(const Field& f) {
        std::vector<FieldValue> values;
        for (double number : f.sweep.values) values.push_back(field_value(f, number));
        return values;
    }

    // Whether the parameter changes anything on that curve. Sets what it takes.
    bool concerns(const Own& f, SweptMethod& curve) const {
        if (f.sweep.when.empty()) return true;
        const auto condition = std::find_if(fields_.begin(), fields_.end(), [&](const Own& other) {
            return other.table == f.table && other.name == f.sweep.when;
        });
        for (const Setting& s : curve.fixed)
            if (s.table == f.table && s.key == f.sweep.when) return text_of(s.value) == f.sweep.is;
        const FieldValue wanted = parse_value(f.sweep.is);
        if (text_of(value_of(*condition)) != f.sweep.is) curve.fixed.push_back({f.table, f.sweep.when, wanted, ""});
        return true;
    }

    void add(SweptMethod curve, std::vector<SweptMethod>& result) const {
        // What was asked for takes the place of all ranges of the curves that it concerns.
        for (const Asked& a : asked_) {
            const bool own = has(tables_, a.variation.table);
            if (!own && is_of_a_method(a.variation.table)) continue;
            if (own) {
                const auto f = std::find_if(fields_.begin(), fields_.end(), [&](const Own& field) {
                    return field.table == a.variation.table && field.name == a.variation.key;
                });
                if (selects(fields_, *f) || !concerns(*f, curve)) continue;
            }
            curve.varied.push_back(a.variation);
        }
        if (!curve.varied.empty()) return add_each(std::move(curve), result);
        for (const Own& f : fields_) {
            if (f.sweep.role != Role::along || f.sweep.values.empty() || !concerns(f, curve)) continue;
            curve.varied.push_back({f.table, f.name, values(f)});
        }
        result.push_back(curve);
        for (const Own& f : fields_) {
            SweptMethod other = curve;
            if (f.sweep.role != Role::curves || selects(fields_, f) || !concerns(f, other)) continue;
            for (const FieldValue& value : values(f)) {
                if (same(f, value)) continue;  // the scene's own: it has its curve
                result.push_back(other);
                result.back().name += fmt::format(", {} = {}", f.name, text_of(value));
                result.back().fixed.push_back({f.table, f.name, value, ""});
            }
        }
    }

    // The last of what varies runs along; of all others a curve for each combination of their values, so that none goes
    // back and forth.
    void add_each(SweptMethod curve, std::vector<SweptMethod>& result) const {
        const Variation along = curve.varied.back();
        std::vector<Variation> across = std::move(curve.varied);
        across.pop_back();
        curve.varied = {along};
        std::vector<SweptMethod> curves = {curve};
        for (const Variation& v : across) {
            std::vector<SweptMethod> more;
            for (const SweptMethod& one : curves)
                for (const FieldValue& value : v.values) {
                    more.push_back(one);
                    more.back().name += fmt::format(", {}{} = {}", has(tables_, v.table) ? "" : v.table + ".", v.key, text_of(value));
                    more.back().fixed.push_back({v.table, v.key, value, ""});
                }
            curves = std::move(more);
        }
        result.insert(result.end(), curves.begin(), curves.end());
    }

    static bool same(const Field& f, const FieldValue& value) {
        const auto number = std::get_if<double>(&value);
        const auto real = std::get_if<float*>(&f.value);
        if (number && real) return **real == float(*number);
        return text_of(value_of(f)) == text_of(value);
    }

    frame::Settings settings_;
    frame::Method method_;
    std::vector<std::string> tables_;
    const std::vector<Asked>& asked_;
    std::vector<Own> fields_;
};

}  // namespace

std::vector<SweptMethod> swept_methods(const frame::Settings& settings, const std::vector<std::string>& methods,
                                       const std::vector<std::string>& vary) {
    std::vector<Asked> asked;
    for (const std::string& text : vary) {
        asked.push_back(parse_vary(settings, text));
        const Variation& v = asked.back().variation;
        if (find_asked(asked, v.table, v.key) != &asked.back())
            throw InputError(fmt::format("{}: it is given twice", asked.back().place));
    }
    std::vector<SweptMethod> curves;
    std::vector<std::string> known;
    for (const frame::MethodInfo& info : frame::methods()) {
        known.push_back(info.name);
        for (const SweptMethod& curve : Curves(settings, info.method, asked).all()) {
            // Without what sets a further curve apart.
            const std::string name = curve.name.substr(0, curve.name.find(','));
            if (std::find(known.begin(), known.end(), name) == known.end()) known.push_back(name);
            const bool wanted = methods.empty() || std::any_of(methods.begin(), methods.end(), [&](const std::string& m) {
                return m == info.name || m == name || m == curve.name;
            });
            if (wanted) curves.push_back(curve);
        }
    }
    for (const std::string& m : methods)
        if (std::find(known.begin(), known.end(), m.substr(0, m.find(','))) == known.end())
            throw InputError(fmt::format("--method {}: unknown method{}", m, nearest_known(m, known)));
    if (curves.empty()) throw InputError("--method: no curve has that name");
    for (const Asked& a : asked) {
        auto is_it = [&](const auto& s) { return s.table == a.variation.table && s.key == a.variation.key; };
        const bool used = std::any_of(curves.begin(), curves.end(), [&](const SweptMethod& c) {
            return std::any_of(c.varied.begin(), c.varied.end(), is_it) ||
                   std::any_of(c.fixed.begin(), c.fixed.end(), is_it);
        });
        if (!used) throw InputError(a.place + ": it changes nothing on any curve that is swept");
    }
    return curves;
}

std::vector<SweptSettings> points_of(const SweptMethod& curve) {
    std::vector<SweptSettings> points = {{"", curve.fixed}};
    for (const Variation& v : curve.varied) {
        std::vector<SweptSettings> more;
        for (const SweptSettings& point : points)
            for (const FieldValue& value : v.values) {
                SweptSettings next = point;
                next.text += fmt::format("{}{}.{} = {}", next.text.empty() ? "" : ", ", v.table, v.key, text_of(value));
                next.changed.push_back({v.table, v.key, value, ""});
                more.push_back(next);
            }
        points = more;
    }
    return points;
}

frame::Settings apply(frame::Settings settings, frame::Method method, const std::vector<Setting>& changed) {
    settings.method = method;
    for (const Setting& s : changed) {
        const std::string place = s.table + "." + s.key;
        std::vector<Field> fields = frame::table_fields(settings, s.table, place);
        set_field(find_field(fields, s.key, place), s.value, place);
        if (s.table == "layout") raster::validate(settings.layout, place);
    }
    return settings;
}

}  // namespace plumb::cli
