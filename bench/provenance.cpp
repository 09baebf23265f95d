#include "bench/provenance.h"

#include "base/file.h"
#include "base/hash.h"
#include "bench/manifest.h"
#include "bench/process.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <vector>

namespace dapple::bench {
namespace fs = std::filesystem;

nlohmann::ordered_json buildJson() {
    nlohmann::ordered_json json;
    const fs::path home = base::homeFolder();
    const auto trimmed = [](std::string text) {
        text.erase(text.find_last_not_of(" \n") + 1);
        return text;
    };
    std::string commit, changes;
    if (fs::exists(home / "commit")) {
        commit = trimmed(base::readFile(home / "commit"));
        json["commit"] = commit.substr(0, commit.find("-dirty"));
        json["dirty"] = commit.ends_with("-dirty");
    } else if (fs::exists(home / ".git") && runProgram({"git", "-C", home.string(), "rev-parse", "HEAD"}, &commit) == 0) {
        json["commit"] = trimmed(commit);
        const bool known = runProgram({"git", "-C", home.string(), "status", "--porcelain", "--untracked-files=no"}, &changes) == 0;
        json["dirty"] = known ? nlohmann::ordered_json(!changes.empty()) : nlohmann::ordered_json(nullptr);
    } else {
        json["commit"] = nullptr;
        json["dirty"] = nullptr;
    }
#ifdef NDEBUG
    json["type"] = "release";
#else
    json["type"] = "debug";
#endif
    json["compiler"] = __VERSION__;
    return json;
}

std::string originOf(const std::string& identity) {
    static const std::string program = sha256OfFile("/proc/self/exe").substr(0, 16);
    const auto machine = nlohmann::json::parse(identity);
    nlohmann::ordered_json origin{{"program", program}, {"shaders", shadersHash()}};
    for (const char* key : {"driver_class", "gl_renderer", "gl_version"})
        if (machine.contains(key)) origin[key] = machine[key];
    std::istringstream cpus(base::readFile("/proc/cpuinfo"));
    for (std::string line; std::getline(cpus, line);)
        if (line.starts_with("model name")) {
            origin["cpu"] = line.substr(line.find(':') + 2);
            break;
        }
    return origin.dump();
}

std::string shadersHash() {
    const fs::path folder = base::homeFolder() / "shaders";
    std::vector<fs::path> files;
    std::error_code missing;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, missing))
        if (entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    base::Hasher hasher;
    for (const fs::path& file : files) {
        hasher.text(fs::relative(file, folder).string());
        hasher.text(base::readFile(file));
    }
    return base::hex16(hasher.digest());
}

std::vector<std::string> commandLine() {
    std::istringstream text(base::readFile("/proc/self/cmdline"));
    std::vector<std::string> arguments;
    for (std::string argument; std::getline(text, argument, '\0');) arguments.push_back(argument);
    return arguments;
}

}  // namespace dapple::bench
