#include "base/file_name.h"

#include "base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <mutex>
#include <set>

namespace dapple::base {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMostCharacters = 80;

/// FNV-1a (Fowler, Noll, Vo): short enough to be written twice, here and in Python.
uint32_t shortHash(std::string_view text) {
    uint32_t hash = 2166136261u;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
    return hash;
}

struct Inputs {
    std::mutex mutex;
    std::set<fs::path> paths;
};
Inputs& inputs() {
    static Inputs known;
    return known;
}

}  // namespace

std::string fileName(std::string_view name) {
    const std::string_view legal = "._=+-";
    std::string part;
    for (const char c : name.substr(name.rfind('/') + 1)) {
        const bool kept = std::isalnum(static_cast<unsigned char>(c)) != 0 && static_cast<unsigned char>(c) < 128;
        if (kept || legal.find(c) != std::string_view::npos) part += c;
        else if (!part.ends_with('-')) part += '-';
    }
    if (part.empty() || part.front() == '.' || part.front() == '-') part.insert(0, "_");
    if (part == name && part.size() <= kMostCharacters) return part;
    part.resize(std::min(part.size(), kMostCharacters - 9));
    return fmt::format("{}-{:08x}", part, shortHash(name));
}

void noteInput(const fs::path& path) {
    const std::scoped_lock lock(inputs().mutex);
    inputs().paths.insert(path);
}

std::vector<std::string> notedInputs() {
    const std::scoped_lock lock(inputs().mutex);
    return {inputs().paths.begin(), inputs().paths.end()};
}

void requireNotAnInput(const fs::path& path) {
    const std::scoped_lock lock(inputs().mutex);
    for (const fs::path& input : inputs().paths) {
        std::error_code error;
        if (fs::equivalent(path, input, error))
            throw UsageError(
                fmt::format("{} is an input{} and would be replaced by what is written; name another file with -o",
                            path.string(), path == input ? "" : fmt::format(" ({})", input.string())));
    }
}

}  // namespace dapple::base
