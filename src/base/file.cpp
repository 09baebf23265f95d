#include "base/file.h"

#include "base/error.h"
#include "base/file_name.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

namespace dapple::base {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void failWrite(const fs::path& path, int error) {
    throw UsageError(fmt::format("cannot write {}: {}; name another place with -o", path.string(), std::strerror(error)));
}

void makeFolder(const fs::path& dir) {
    if (dir.empty()) return;
    std::error_code error;
    fs::create_directories(dir, error);
    std::error_code ignored;
    if (error && !fs::is_directory(dir, ignored)) failWrite(dir, error.value());
}

}  // namespace

void requireRegularFile(const fs::path& path) {
    std::error_code ignored;
    if (fs::is_other(path, ignored)) throw UsageError(fmt::format("{} is a pipe or a device, not a file", path.string()));
}

std::string readFile(const fs::path& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) throw UsageError(fmt::format("{} is a folder, not a file", path.string()));
    requireRegularFile(path);
    std::ifstream in(path, std::ios::binary);
    if (!in) throw UsageError(fmt::format("cannot read {}: {}", path.string(), std::strerror(errno)));
    noteInput(path);
    try {
        return {std::istreambuf_iterator<char>(in), {}};
    } catch (const std::ios_base::failure& e) {
        throw UsageError(fmt::format("cannot read {}: {}", path.string(), e.what()));
    }
}

void writeFile(const fs::path& path, std::string_view bytes) {
    makeFolder(path.parent_path());
    const fs::path temporary = path.string() + fmt::format(".{}.tmp", ::getpid());
    const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) failWrite(path, errno);
    int error = 0;
    for (size_t done = 0; done < bytes.size() && error == 0;) {
        const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
        if (n < 0 && errno != EINTR) error = errno;
        if (n > 0) done += static_cast<size_t>(n);
    }
    if (error == 0 && ::fsync(fd) != 0) error = errno;
    if (::close(fd) != 0 && error == 0) error = errno;
    if (error == 0 && ::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
    if (error != 0) {
        ::unlink(temporary.c_str());
        failWrite(path, error);
    }
}

void requireWritableFolder(const fs::path& dir) {
    makeFolder(dir);
    const fs::path probe = dir / fmt::format(".dapple-probe-{}", ::getpid());
    writeFile(probe, "x");
    fs::remove(probe);
}

fs::path homeFolder() {
    if (const char* home = std::getenv("DAPPLE_HOME")) return home;
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    for (fs::path dir = program.parent_path(); !error && dir != dir.root_path(); dir = dir.parent_path())
        if (fs::is_directory(dir / "shaders" / "passes")) return dir;
    return DAPPLE_SOURCE_DIR;
}

fs::path cacheFolder() {
    if (const char* cache = std::getenv("DAPPLE_CACHE")) return cache;
    return homeFolder() / "cache";
}

}  // namespace dapple::base
