#include "bench/folder_lock.h"

#include "base/error.h"
#include "base/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <map>

namespace dapple::bench {
namespace fs = std::filesystem;
namespace {

std::map<std::string, std::weak_ptr<FolderLock>>& held() {
    static std::map<std::string, std::weak_ptr<FolderLock>> locks;
    return locks;
}

[[noreturn]] void refuse(const fs::path& file) {
    std::string holder = base::readFile(file);
    holder.erase(holder.find_last_not_of('\n') + 1);
    throw base::UsageError(fmt::format("{}: another process ({}) is writing a run there; wait for it, or name another folder with -o",
                                       file.parent_path().string(), holder.empty() ? "just started" : holder));
}

/// True once the lock is taken; false if another process has it. Throws UsageError where locks do not work.
bool tryLock(int fd, const fs::path& file) {
    if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return true;
    if (errno == EWOULDBLOCK) return false;
    throw base::UsageError(fmt::format("cannot lock {}: {}; name a folder on another disk with -o", file.string(), std::strerror(errno)));
}

/// The file may have been removed by its last holder between our open() and flock().
bool isStill(int fd, const fs::path& file) {
    struct stat open {}, named {};
    return ::fstat(fd, &open) == 0 && ::stat(file.c_str(), &named) == 0 && open.st_ino == named.st_ino && open.st_dev == named.st_dev;
}

}  // namespace

std::shared_ptr<FolderLock> FolderLock::hold(const fs::path& folder) {
    base::requireWritableFolder(folder);
    const std::string key = fs::canonical(folder).string();
    if (auto known = held()[key].lock()) return known;
    auto made = std::make_shared<FolderLock>(folder, key);
    held()[key] = made;
    return made;
}

FolderLock::FolderLock(const fs::path& folder, const std::string& key) : file_(folder / kFile), key_(key) {
    do {
        if (fd_ >= 0) ::close(fd_);
        fd_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
        if (fd_ < 0) throw base::UsageError(fmt::format("cannot write {}: {}; name another folder with -o", file_.string(), std::strerror(errno)));
        bool taken = false;
        try {
            taken = tryLock(fd_, file_);
            if (!taken) refuse(file_);
        } catch (...) {
            ::close(fd_);
            throw;
        }
    } while (!isStill(fd_, file_));
    std::array<char, 256> host{};
    ::gethostname(host.data(), host.size() - 1);
    const std::string holder = fmt::format("process {} on {}\n", ::getpid(), host.data());
    // Only a courtesy to whoever is refused: a disk that is full now fails the run a moment later.
    if (::ftruncate(fd_, 0) != 0 || ::pwrite(fd_, holder.data(), holder.size(), 0) < 0) return;
}

FolderLock::~FolderLock() {
    ::unlink(file_.c_str());
    ::close(fd_);
    held().erase(key_);
}

void FolderLock::requireFree(const fs::path& folder) {
    std::error_code error;
    if (const fs::path real = fs::canonical(folder, error); error || held()[real.string()].lock()) return;
    const fs::path file = folder / kFile;
    const int fd = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
    if (fd < 0) return;  // no lock file, or none that we may touch: check() finds out whether we may write there
    const bool isFree = ::flock(fd, LOCK_EX | LOCK_NB) == 0;
    ::close(fd);
    if (!isFree) refuse(file);
}

}  // namespace dapple::bench
