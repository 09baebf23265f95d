#include "bench/pictures.h"

#include "base/error.h"
#include "base/file.h"
#include "bench/picture.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace dapple::bench {
namespace fs = std::filesystem;

std::vector<std::string> renderPictures(const std::string& folder, Workbench& workbench, const std::vector<PointSpec>& points) {
    std::vector<std::string> files;
    auto* gl = dynamic_cast<GlWorkbench*>(&workbench);
    if (!gl) return files;  // the fake workbench has nothing to show
    base::requireWritableFolder(folder);
    for (const PointSpec& spec : points) {
        if (spec.technique == "bare") continue;
        std::string stem = fs::path(spec.scene).stem().string() + "_" + (spec.view.empty() ? "" : spec.view + "_") + spec.technique;
        if (!spec.variant.empty()) {
            std::string variant = spec.variant;
            std::replace_if(variant.begin(), variant.end(), [](unsigned char c) { return !std::isalnum(c) && c != '.'; }, '-');
            stem += "_" + variant;
        }
        if (const auto size = spec.settings.find("size"); size != spec.settings.end()) stem += "_" + size->second;
        for (const char* what : {"shaded", "error"}) {
            files.push_back((fs::path(folder) / (stem + "_" + what + ".png")).string());
            renderPicture(*gl, spec, what, files.back());
        }
    }
    return files;
}

}  // namespace dapple::bench
