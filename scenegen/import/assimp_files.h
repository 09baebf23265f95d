#pragma once

#include "scenegen/import/notes.h"

#include <assimp/DefaultIOSystem.h>

#include <filesystem>

namespace dapple::scenegen {

/// The files that Assimp's readers may open: regular ones within the scene's folder (file_access.h). Others are as if they
/// did not exist, and are noted.
class AssimpFiles : public Assimp::DefaultIOSystem {
public:
    /// `notes` must outlive the importer that owns this.
    AssimpFiles(std::filesystem::path scene, Notes& notes) : scene_(std::move(scene)), notes_(notes) {}

    bool Exists(const char* file) const override;
    Assimp::IOStream* Open(const char* file, const char* mode) override;

private:
    std::filesystem::path scene_;
    Notes& notes_;
};

}  // namespace dapple::scenegen
