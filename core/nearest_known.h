// What is said of a name that nobody knows: the nearest one, or all that there are.
#pragma once

#include <string>
#include <vector>

namespace plumb {

// The end of the sentence that refuses `name`. Where candidates are near, "; the nearest known one is 'x'": one begins with
// the other, of two characters or more, or the edit distance (a character put in, left out or another in its place, or two
// neighbours exchanged; case aside) is at most a third of the longer one, or 1. Else what there is, "; known: a, b, c"; of more
// than a dozen the nearest, "and 5 more". Nothing where there is none. `quotes` opens and closes the nearest one.
std::string nearest_known(const std::string& name, const std::vector<std::string>& candidates, const char* quotes = "''");

}  // namespace plumb
