// Edits of SPIR-V that leave it valid: one change at one place, loops that end, and marks that tell what ran.
#pragma once

#include "tools/mutants/sites.h"

namespace plumb::mutants {

// The module with loops that end after so many turns of all loops of an invocation, and with reads beyond an image or a
// buffer that give garbage: a change can neither hang a device nor hide behind its robust access.
SpirvModule guarded(const SpirvModule& module, std::uint32_t most_turns);

// The module with that one change.
SpirvModule changed(const SpirvModule& module, const SpirvIndex& index, const Site& site);

// What a mark tells of a survivor.
enum class Mark : int {
    reached,  // the instruction ran
    differed, // the changed one gave another value than the original
};
// A module that writes garbage to all its outputs in invocations to which that happened. `differed` is the changed module
// where both values can be compared, else `reached`.
SpirvModule marked(const SpirvModule& module, const SpirvIndex& index, const Site& site, Mark mark);

}  // namespace plumb::mutants
