#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace dapple::base {

/// Throws UsageError for a pipe or a device, of which reading might never end. What is missing passes.
void requireRegularFile(const std::filesystem::path& path);

/// Whole file as bytes, which is an input from then on (noteInput() in file_name.h). Throws UsageError naming the path
/// when it is missing, a folder, a pipe, a device or unreadable.
std::string readFile(const std::filesystem::path& path);

/// Writes a file whole or not at all: temporary file beside it, fsync, rename. Creates parent folders.
/// Throws UsageError naming the path and the system's reason (full disk, read-only folder).
void writeFile(const std::filesystem::path& path, std::string_view bytes);

/// Throws UsageError unless `dir` exists or can be made, and a file can be written into it.
void requireWritableFolder(const std::filesystem::path& dir);

/// Folder that holds shaders/, scenegen/scenes/ and bench/ : $DAPPLE_HOME, else found from the place of
/// the running program (a relocated bundle), else the source tree it was built from.
std::filesystem::path homeFolder();

/// Git-ignored folder for fetched scenes and cached references: $DAPPLE_CACHE, else homeFolder()/cache.
std::filesystem::path cacheFolder();

}  // namespace dapple::base
