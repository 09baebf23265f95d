#include "scenegen/import/file_kind.h"

#include "base/config.h"
#include "base/error.h"
#include "base/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

constexpr uintmax_t kLargestToml = 1 << 20;  // bytes; what is larger is no recipe under another extension

std::string lowerExtension(const fs::path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return extension;
}

/// By the keys that only one of the two has, a sidecar's first; nothing when there are none.
std::optional<FileKind> kindOfToml(const fs::path& file) {
    static const std::set<std::string> ofSidecars{"up", "unit", "textures", "drop", "receivers", "cell", "copy"};
    static const std::set<std::string> ofRecipes{
        "description", "seed",     "origin", "trees", "spacing", "selfThinning", "scale", "time",      "radius", "further_sun",
        "ground",      "clearing", "terrain", "species", "wind", "primitive",    "city",  "courtyard", "path"};
    const std::vector<std::string> keys = base::ConfigTable::parseFile(file).keys();
    const auto has = [&](const std::set<std::string>& known) {
        return std::any_of(keys.begin(), keys.end(), [&](const std::string& key) { return known.contains(key); });
    };
    if (has(ofSidecars)) return FileKind::sidecar;
    if (has(ofRecipes)) return FileKind::recipe;
    return {};
}

/// A file beside a missing one whose name differs in the extension or in two letters at most.
std::string similarFile(const fs::path& file) {
    std::vector<std::string> names;
    std::error_code error;
    const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
        if (it->is_regular_file(error) && it->path().stem() == file.stem()) return it->path().filename().string();
        names.push_back(it->path().filename().string());
    }
    return base::nearestName(file.filename().string(), names);
}

}  // namespace

FileKind fileKind(const fs::path& file) {
    std::error_code error;
    if (!fs::exists(file, error)) {
        const std::string similar = similarFile(file);
        const std::string hint = similar.empty() ? "" : fmt::format("; did you mean '{}'?", similar);
        throw base::UsageError(fmt::format("{}: no such file{}", file.string(), hint));
    }
    if (fs::is_directory(file, error)) throw base::UsageError(file.string() + ": is a folder, not a scene");
    base::requireRegularFile(file);
    const std::string extension = lowerExtension(file);
    // Without a key that tells, it is a recipe with its description missing, and refused as such.
    if (extension == ".toml") return kindOfToml(file).value_or(FileKind::recipe);
    for (const char* known : {".geojson", ".geojsonl", ".geojsons", ".json"})
        if (extension == known) return FileKind::footprints;
    if (fs::file_size(file, error) > kLargestToml) return FileKind::scene;
    try {
        if (kindOfToml(file) == FileKind::recipe) return FileKind::recipe;
    } catch (const base::UsageError&) {
        // No TOML: the usual case.
    }
    return FileKind::scene;
}

bool hasSidecar(const fs::path& file) {
    const fs::path toml = fs::path(file).replace_extension(".toml");
    return toml != file && fs::exists(toml) && kindOfToml(toml).value_or(FileKind::sidecar) == FileKind::sidecar;
}

}  // namespace dapple::scenegen
