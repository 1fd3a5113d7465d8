// Many changes of a twin in one module, which is compiled once: a dispatch says which of them its invocations make.
#pragma once

#include <functional>

#include "tools/mutants/editor.h"

namespace plumb::mutants {

// A change of the instruction at one place, made by an Editor: it may put others in front of it.
struct PlacedChange {
    std::size_t at = 0;
    std::function<void(Editor&)> edit;
};

// Whether what the instruction makes and what the changed one makes can both be computed, and one of them chosen.
bool is_selectable(const SpirvModule& module, const SpirvIndex& index, std::size_t at);

// The compute module in which invocations whose z is n, from 1, make the change changes[n - 1]; others none. All changes
// are selectable ones of different instructions; nothing may read z.
SpirvModule selectable(const SpirvModule& module, const SpirvIndex& index, const std::vector<PlacedChange>& changes);

}  // namespace plumb::mutants
