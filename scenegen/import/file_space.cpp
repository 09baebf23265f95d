#include "scenegen/import/file_space.h"

#include <assimp/scene.h>

#include <cmath>

namespace dapple::scenegen {
namespace {

/// FBX says which axis points up, to the front and to the right, each with a sign, and the centimetres per unit.
FileSpace fbxSpace(const aiScene& scene) {
    int axis[3] = {0, 2, 1}, sign[3] = {1, 1, 1};  // right, front, up
    double centimetres = 1;
    if (const aiMetadata* data = scene.mMetaData) {
        const char* names[3] = {"CoordAxis", "FrontAxis", "UpAxis"};
        for (int i = 0; i < 3; ++i) {
            int32_t value = 0;
            if (data->Get(names[i], value) && value >= 0 && value <= 2) axis[i] = value;
            if (data->Get(std::string(names[i]) + "Sign", value)) sign[i] = value < 0 ? -1 : 1;
        }
        double factor = 0;
        float single = 0;
        if (!data->Get("UnitScaleFactor", factor) && data->Get("UnitScaleFactor", single)) factor = double(single);
        if (std::isfinite(factor) && factor > 0) centimetres = factor;
    }
    if (axis[0] == axis[1] || axis[1] == axis[2] || axis[0] == axis[2]) return {FileSpace('y').axes, centimetres / 100};
    glm::dmat3 axes(0);  // columns: where the file's axes go; its right to x, its front to -y, its up to z
    axes[axis[0]].x = sign[0];
    axes[axis[1]].y = -sign[1];
    axes[axis[2]].z = sign[2];
    return {axes, centimetres / 100};
}

}  // namespace

FileSpace spaceOf(const aiScene& scene, const std::filesystem::path& file) {
    const std::string extension = lowerExtension(file);
    if (extension == ".fbx") return fbxSpace(scene);
    return extension == ".blend" || extension == ".stl" || extension == ".ply" ? 'z' : 'y';
}

}  // namespace dapple::scenegen
