// The one exception that means "the user can mend this": bad usage or bad input, exit code 2.
#pragma once

#include <stdexcept>
#include <string>

namespace plumb {

// what() is one line: the file, the place in it, and what was expected, as far as each is known.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
    InputError(const std::string& file, const std::string& place, const std::string& cause)
        : std::runtime_error(file + ": " + (place.empty() ? "" : place + ": ") + cause) {}
};

}  // namespace plumb
