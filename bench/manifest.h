#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace dapple::bench {

/// 64 lower-case hexadecimal digits.
std::string sha256(std::string_view bytes);
/// The same of a file. Throws UsageError if it cannot be read.
std::string sha256OfFile(const std::filesystem::path& file);

/// manifest.json of a finished run: size and SHA-256 of its files, so that a bit that flips later is noticed.
void writeManifest(const std::filesystem::path& folder, const std::string& runId);

/// Everyone who reads the files of a finished run asks this first. Throws Error (exit 4) naming the file that is missing or is
/// not what the run wrote. A run without a manifest is read with a warning.
void verifyManifest(const std::filesystem::path& folder);

}  // namespace dapple::bench
