#pragma once

#include <cstddef>

namespace dapple::base {

/// Bytes that this process may still take: the least of what the machine has free, its control group leaves it (as on a
/// cluster or in CI) and its own limit allows.
size_t availableMemory();

}  // namespace dapple::base
