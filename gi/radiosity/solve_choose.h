// Which solver a system is for.
#pragma once

#include "gi/radiosity/solve.h"

namespace plumb::radiosity {

struct TransportFacts {
    int count = 0;
    std::int64_t row_bytes = 0;      // of all rows as they are kept; 0: not known
    double seconds_per_product = 0;  // measured; 0: from row_bytes. Said, never decided by: the choice is the same anywhere
    double largest_reflectance = 0;  // 0..1
    Radius radius;                   // where products is 0, the largest reflectance stands for it
    double tolerance = 1e-4;
    std::int64_t most_bytes = std::int64_t(1) << 29;  // for a direct solve
};

struct Recommendation {
    Solver solver = Solver::passes;
    double products = 0;  // with all rows, expected
    double seconds = 0;   // 0: nothing is known of a product's time
    std::string reason;   // one line
};

// Throws InputError for a reflectance out of 0..1, and for a radius that is proven to be 1 or more.
Recommendation recommend(const TransportFacts& facts);

// Passes from black until the relative error is `tolerance`: ln(tolerance) / ln(radius), and at least one.
double passes_expected(double radius, double tolerance);
// Of the largest radius, and whether it was bounded by the reflectance alone.
double krylov_products_expected(double radius, double tolerance);

// For recommend(), of a system. Throws InputError that names an element where no light is lost.
TransportFacts facts_of(const System& system, const Transport& transport, const RunOptions& options = {});

}  // namespace plumb::radiosity
