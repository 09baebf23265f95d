#include "scenegen/import/assimp_files.h"

#include "scenegen/import/file_access.h"

namespace dapple::scenegen {

bool AssimpFiles::Exists(const char* file) const {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) return false;
    if (mayRead(scene_.parent_path(), file)) return true;
    notes_.add("files outside the scene's folder are not read (--allow-outside reads them)", file);
    return false;
}

Assimp::IOStream* AssimpFiles::Open(const char* file, const char* mode) {
    // Readers write nothing; a name may come from the scene file.
    return mode[0] == 'r' && Exists(file) ? DefaultIOSystem::Open(file, mode) : nullptr;
}

}  // namespace dapple::scenegen
