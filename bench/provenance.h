#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace dapple::bench {

/// Commit, whether the tree had changes, build type and compiler of this program. Commit and dirty are null
/// where there is neither a git checkout nor the file `commit` that a bundle carries (git describe --always --dirty).
nlohmann::ordered_json buildJson();

/// One line of JSON: what a run must not change half-way, or its rows are not comparable. Hash of this program, GL's renderer and
/// version, CPU. `identity` is Workbench::identityJson().
std::string originOf(const std::string& identity);

/// 16 hex digits over the names and bytes of all files in homeFolder()/shaders.
std::string shadersHash();

/// The arguments that this process was started with.
std::vector<std::string> commandLine();

}  // namespace dapple::bench
