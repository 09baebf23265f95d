#pragma once

#include "bench/gl_workbench.h"

#include <filesystem>
#include <span>

namespace dapple::bench {

/// One kind of picture that `dapple render --what` makes.
struct PictureKind {
    std::string name, description;
    std::string values;  ///< what the numbers of its .exr mean; empty: there is none
};
std::span<const PictureKind> pictureKinds();

/// Renders one picture, .png (false colours) or .exr (the numbers), and beside it a .json with camera and light
/// matrices, suns, sizes and the meaning of the numbers. Throws UsageError: unknown kind or suffix, a kind that the technique does not have.
void renderPicture(GlWorkbench& workbench, const PointSpec& spec, const std::string& what, const std::filesystem::path& file);

}  // namespace dapple::bench
