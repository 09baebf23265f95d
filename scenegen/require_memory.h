#pragma once

#include "base/config.h"

#include <string>

namespace dapple::scenegen {

/// Refuses what would only end in the kernel's killing the process: throws UsageError with file, line and key when
/// `count` times `bytesEach` is more than is free. `what` names it in the plural.
void requireMemory(const base::ConfigTable& table, const char* key, const std::string& what, double count,
                   size_t bytesEach);

}  // namespace dapple::scenegen
