#pragma once

#include <filesystem>
#include <optional>

namespace dapple::scenegen {

/// What a scene file names (textures, buffers, material libraries, height maps) is read only from the file's own folder and
/// the folders below it: a scene from elsewhere must not read what is none of its business. Links are followed before the
/// test. `--allow-outside` lifts this for the whole process.
void allowOutside(bool allow);
bool outsideAllowed();

/// True if `path`, with all links and ".." resolved, lies in `folder` or below it, or if everything is allowed.
bool mayRead(const std::filesystem::path& folder, const std::filesystem::path& path);

/// Throws UsageError unless mayRead(); the message names `file`, which asks for `path`, and the option.
void requireInside(const std::filesystem::path& file, const std::filesystem::path& path);

}  // namespace dapple::scenegen
