#include "scenegen/import/file_access.h"

#include "base/error.h"
#include "base/file_name.h"

#include <fmt/format.h>

#include <algorithm>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

bool everythingAllowed = false;

}  // namespace

void allowOutside(bool allow) { everythingAllowed = allow; }

bool outsideAllowed() { return everythingAllowed; }

bool mayRead(const fs::path& folder, const fs::path& path) {
    base::noteInput(path);
    if (everythingAllowed) return true;
    std::error_code error;
    const fs::path root = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, error);
    if (error) return false;
    const fs::path target = fs::weakly_canonical(path, error);
    if (error) return false;
    return std::mismatch(root.begin(), root.end(), target.begin(), target.end()).first == root.end();
}

void requireInside(const fs::path& file, const fs::path& path) {
    if (!mayRead(file.parent_path(), path))
        throw base::UsageError(fmt::format("{}: asks for {}, which lies outside its folder; --allow-outside reads it all the same", file.string(), path.string()));
}

}  // namespace dapple::scenegen
