#include "bench/manifest.h"

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "bench/rows.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sodium.h>

#include <array>
#include <fstream>
#include <vector>

namespace dapple::bench {
namespace fs = std::filesystem;
namespace {

constexpr const char* kManifest = "manifest.json";
constexpr std::array<const char*, 4> kFiles{"plan.csv", "metrics.csv", "samples.csv", "run.json"};

std::string hex(const std::array<unsigned char, crypto_hash_sha256_BYTES>& digest) {
    std::string text;
    for (const unsigned char byte : digest) text += fmt::format("{:02x}", byte);
    return text;
}

[[noreturn]] void corrupt(const std::string& why) { throw base::Error(base::ExitCode::corrupt, why + "; run the sweep again"); }

}  // namespace

std::string sha256(std::string_view bytes) {
    std::array<unsigned char, crypto_hash_sha256_BYTES> digest{};
    crypto_hash_sha256(digest.data(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    return hex(digest);
}

std::string sha256OfFile(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw base::UsageError(fmt::format("cannot read {}", file.string()));
    crypto_hash_sha256_state state;
    crypto_hash_sha256_init(&state);
    std::vector<char> buffer(1 << 20);
    while (in.read(buffer.data(), std::streamsize(buffer.size())) || in.gcount() > 0)
        crypto_hash_sha256_update(&state, reinterpret_cast<const unsigned char*>(buffer.data()), size_t(in.gcount()));
    std::array<unsigned char, crypto_hash_sha256_BYTES> digest{};
    crypto_hash_sha256_final(&state, digest.data());
    return hex(digest);
}

void writeManifest(const fs::path& folder, const std::string& runId) {
    nlohmann::ordered_json json{{"schema", kSchema}, {"run_id", runId}};
    for (const char* name : kFiles) json["files"][name] = {{"bytes", fs::file_size(folder / name)}, {"sha256", sha256OfFile(folder / name)}};
    base::writeFile(folder / kManifest, json.dump(2) + "\n");
}

void verifyManifest(const fs::path& folder) {
    const fs::path path = folder / kManifest;
    if (!fs::exists(path)) {
        base::logWarning(fmt::format("{} has no {}: its files are read unchecked", folder.string(), kManifest));
        return;
    }
    const auto json = nlohmann::json::parse(base::readFile(path), nullptr, false);
    const auto files = json.is_object() ? json.find("files") : json.end();
    if (!json.is_object() || files == json.end() || !files->is_object()) corrupt(fmt::format("{} is damaged", path.string()));
    for (const char* name : kFiles) {
        const auto entry = files->find(name);
        if (entry == files->end() || !entry->is_object() || !entry->contains("sha256")) corrupt(fmt::format("{} is damaged: it lacks {}", path.string(), name));
        if (!fs::exists(folder / name)) corrupt(fmt::format("{} is missing", (folder / name).string()));
        if (entry->at("sha256") != sha256OfFile(folder / name))
            corrupt(fmt::format("{} is not what the run wrote: its SHA-256 differs from that in {}", (folder / name).string(), kManifest));
    }
}

}  // namespace dapple::bench
