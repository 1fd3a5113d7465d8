// Rows as a store keeps them: a bundle for each block of them.
#pragma once

#include "core/bundle.h"
#include "gi/radiosity/rows.h"

namespace plumb::radiosity {

// Lends what the block has.
Bundle bundle_of(const RowBlock& block);

// Throws InputError for a bundle that is no block `index` of the rows of `elements` elements.
RowBlock block_of(const Bundle& bundle, int elements, int index);

}  // namespace plumb::radiosity
