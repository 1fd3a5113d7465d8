#include <cstdio>

#include "core/isa.h"

int main() { std::printf("%s\n", plumb::isa_name(plumb::best_isa())); }
