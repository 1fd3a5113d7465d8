// What `plumb validate` makes of a manifest, run as its user does.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace plumb::foreign {

struct JudgedStage {
    std::string name, verdict, reason;
    std::int64_t pixels = 0, wrong = 0, ambiguous = 0;
    std::vector<std::string> causes;  // the first three of its diagnosis; none without one
};

struct Judged {
    bool passed = false;
    std::vector<JudgedStage> stages;

    std::int64_t wrong() const;
    const JudgedStage* first_wrong() const;  // null: none is
    std::string wrong_stages() const;        // "A: bounce, A: shadow"
};

// `more`: further words of the command.
Judged judge(const std::string& manifest, const std::vector<std::string>& more = {});

// Lines of "name: verdict, wrong of pixels", for messages.
std::string summary(const Judged& judged);

}  // namespace plumb::foreign
