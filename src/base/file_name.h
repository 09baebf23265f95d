#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace dapple::base {

/// A name (of a scene, a view, a variant, a texture) as one part of a path: what stands behind the last "/" is kept, of
/// this letters, digits and . _ = + -, and all else becomes "-". A hash follows where something was lost, so that two
/// names never share a file. It has at most 80 characters, and no leading dot. bench/report/file_name.py does the same.
std::string fileName(std::string_view name);

/// Remembers that the user's file `path` is being read as input.
void noteInput(const std::filesystem::path& path);
/// All that noteInput() knows: a child process that reads for this one has to tell.
std::vector<std::string> notedInputs();
/// Throws UsageError if `path` is a file that noteInput() knows, by whatever path or link.
void requireNotAnInput(const std::filesystem::path& path);

}  // namespace dapple::base
