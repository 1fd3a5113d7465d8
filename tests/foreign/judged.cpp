#include "tests/foreign/judged.h"

#include <fmt/format.h>

#include <stdexcept>

#include "tests/program/program.h"

namespace plumb::foreign {

namespace {

using program::Json;

constexpr std::size_t most_causes = 3;

std::vector<std::string> causes_of(const Json& stage) {
    std::vector<std::string> out;
    const auto diagnosis = stage.find("diagnosis");
    if (diagnosis == stage.end() || !diagnosis->is_object()) return out;
    for (const Json& cause : diagnosis->at("causes"))
        if (out.size() < most_causes) out.push_back(cause.at("with"));
    return out;
}

}  // namespace

std::int64_t Judged::wrong() const {
    std::int64_t n = 0;
    for (const JudgedStage& s : stages) n += s.wrong;
    return n;
}

const JudgedStage* Judged::first_wrong() const {
    for (const JudgedStage& s : stages)
        if (s.wrong > 0) return &s;
    return nullptr;
}

std::string Judged::wrong_stages() const {
    std::string text;
    for (const JudgedStage& s : stages)
        if (s.wrong > 0) text += (text.empty() ? "" : ", ") + s.name;
    return text;
}

Judged judge(const std::string& manifest, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"validate", manifest, "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const program::Result r = program::run(words);
    if (r.exit != 0 && r.exit != 1) throw std::runtime_error(r.err);
    const Json report = Json::parse(r.out);
    Judged out;
    out.passed = report.at("passed");
    for (const Json& s : report.at("stages"))
        out.stages.push_back({s.at("name"), s.at("verdict"), s.at("reason"), s.at("pixels"), s.at("counts").at("wrong"),
                              s.at("counts").at("ambiguous"), causes_of(s)});
    return out;
}

std::string summary(const Judged& judged) {
    std::string text;
    for (const JudgedStage& s : judged.stages)
        text += fmt::format("{}: {}, {} wrong and {} ambiguous of {} pixels{}\n", s.name, s.verdict, s.wrong,
                            s.ambiguous, s.pixels, s.reason.empty() ? "" : ": " + s.reason);
    return text;
}

}  // namespace plumb::foreign
