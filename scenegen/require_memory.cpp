#include "scenegen/require_memory.h"

#include "base/memory.h"

#include <fmt/format.h>

namespace dapple::scenegen {

void requireMemory(const base::ConfigTable& table, const char* key, const std::string& what, double count,
                   size_t bytesEach) {
    const double needed = count * double(bytesEach), free = double(base::availableMemory()), gib = double(1 << 30);
    if (needed > free)
        table.fail(key, fmt::format("{} need about {:.1f} GiB while they are made, and {:.1f} GiB are free: "
                                    "ask for fewer", what, needed / gib, free / gib));
}

}  // namespace dapple::scenegen
