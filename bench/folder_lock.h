#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace dapple::bench {

/// Keeps every other process from writing a run into a folder. While it is held, the folder has a file `lock.part` that
/// names the holder; a killed holder leaves that file behind, but no lock.
class FolderLock {
public:
    /// Creates the folder. Throws UsageError, naming the holder, if another process writes there. Does not wait. This process
    /// may hold a folder several times; the lock ends with the last holder.
    static std::shared_ptr<FolderLock> hold(const std::filesystem::path& folder);

    /// Throws as hold(), and leaves nothing behind.
    static void requireFree(const std::filesystem::path& folder);

    static constexpr const char* kFile = "lock.part";

    FolderLock(const std::filesystem::path& folder, const std::string& key);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    std::filesystem::path file_;
    std::string key_;  ///< the folder's canonical path
    int fd_ = -1;
};

}  // namespace dapple::bench
