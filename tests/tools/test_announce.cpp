// How long a command says it takes.
#include "tools/shared/announce.h"

#include <catch2/catch.hpp>

using namespace plumb::cli;

TEST_CASE("announce: a time has one digit, from ten on steps of five, and the unit that suits it", "[tools]") {
    CHECK(about(21.4) == "about 20 s");
    CHECK(about(89) == "about 90 s");
    CHECK(about(90) == "about 2 minutes");
    CHECK(about(146) == "about 2 minutes");
    CHECK(about(1540) == "about 25 minutes");
    CHECK(about(5399) == "about 90 minutes");
    CHECK(about(5400) == "about 2 hours");
    CHECK(about(7200) == "about 2 hours");
    CHECK(about(36000) == "about 10 hours");
}
