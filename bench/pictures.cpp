#include "bench/pictures.h"

#include "base/error.h"
#include "base/file.h"
#include "base/file_name.h"
#include "bench/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace dapple::bench {
namespace fs = std::filesystem;

std::vector<std::string> renderPictures(const std::string& folder, Workbench& workbench, const Plan& plan,
                                        const std::vector<PlannedPoint>& points) {
    std::vector<std::string> files;
    auto* gl = dynamic_cast<GlWorkbench*>(&workbench);
    if (!gl) return files;  // the fake workbench has nothing to show
    base::requireWritableFolder(folder);
    for (const auto& [id, spec, pruned] : points) {
        if (spec.technique == "bare") continue;
        std::string words = fs::path(spec.scene).stem().string();
        for (const std::string& word : {spec.view, spec.technique, spec.variant, plan.differing(spec)})
            if (!word.empty()) words += "_" + word;
        std::ranges::replace(words, ' ', '_');
        for (const char* what : {"shaded", "error"}) {
            files.push_back((fs::path(folder) / fmt::format("{}_{}_{}.png", base::fileName(words), id, what)).string());
            renderPicture(*gl, spec, what, files.back());
        }
    }
    return files;
}

}  // namespace dapple::bench
