// What a reader goes without. A file that lacks something is read all the same, with a default in its place: the notes
// say so, one line a kind. Where the user is strict, the first of them refuses the file. Private to io/.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::io {

class Findings {
  public:
    explicit Findings(bool strict) : strict_(strict) {}

    // `cause` is what is wrong in that line (0: in no line), `instead` what is done about it. Of a kind the first is kept
    // and the others are counted. Throws InputError where strict.
    void add(std::string_view kind, const std::string& path, std::int64_t line, const std::string& cause,
             const std::string& instead);
    // True where `kind` has been found already and only a count is wanted: spares the making of its texts.
    bool counted(std::string_view kind);

    // A line for each kind, in the order in which they were found.
    std::vector<std::string> notes() const;

  private:
    struct Kind {
        std::string name, text;
        std::int64_t more = 0;
    };
    std::vector<Kind> kinds_;
    bool strict_;
};

}  // namespace plumb::io
