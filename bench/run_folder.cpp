#include "bench/run_folder.h"

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "bench/csv.h"
#include "bench/rows.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <sstream>

namespace dapple::bench {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMetrics = "metrics.csv";
constexpr const char* kSamples = "samples.csv";
constexpr const char* kJournal = "journal.part";

fs::path partOf(const fs::path& folder, const char* name) { return folder / (std::string(name) + ".part"); }

/// Appends and waits for the disk.
void appendDurably(const fs::path& path, std::string_view bytes) {
    const auto fail = [&](int error) {
        throw base::UsageError(fmt::format("cannot write {}: {}; mend that and go on with --resume", path.string(), std::strerror(error)));
    };
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (fd < 0) fail(errno);
    int error = 0;
    while (!bytes.empty() && error == 0) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n > 0) bytes.remove_prefix(static_cast<size_t>(n));
        else if (n < 0 && errno != EINTR) error = errno;
    }
    if (error == 0 && ::fsync(fd) != 0) error = errno;
    if (::close(fd) != 0 && error == 0) error = errno;
    if (error != 0) fail(error);
}

uintmax_t sizeOf(const fs::path& path) {
    std::error_code missing;
    const uintmax_t size = fs::file_size(path, missing);
    return missing ? 0 : size;
}

std::string freshId(const std::string& planHash) {
    base::Hasher hasher;
    hasher.text(planHash);
    hasher.value(std::chrono::system_clock::now().time_since_epoch().count());
    hasher.value(::getpid());
    return base::hex16(hasher.digest());
}

void requireSame(const fs::path& folder, const std::string& what, const std::string& theirs, const std::string& ours) {
    if (theirs != ours)
        throw base::UsageError(fmt::format("{} holds a run with another {} ({}, now {}); resume it with the same sweep and options, or name another folder with -o",
                                           folder.string(), what, theirs, ours));
}

}  // namespace

std::string utcNow() {
    return fmt::format("{:%FT%TZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

void RunFolder::check(const fs::path& folder, bool resume) {
    std::error_code error;
    if (fs::exists(folder, error) && !fs::is_directory(folder, error))
        throw base::UsageError(fmt::format("{} is a file; name a folder with -o", folder.string()));
    if (!resume && fs::is_directory(folder, error) && !fs::is_empty(folder, error))
        throw base::UsageError(fmt::format("{} is not empty; go on with --resume, or name another folder with -o", folder.string()));
    fs::path existing = fs::absolute(folder).lexically_normal();
    while (!fs::exists(existing, error) && existing.has_relative_path()) existing = existing.parent_path();
    base::requireWritableFolder(existing);
}

void RunFolder::removeRun(const fs::path& folder, const std::string& sweep) {
    if (!fs::is_directory(folder) || fs::is_empty(folder)) return;
    std::string found;
    if (fs::exists(folder / kJournal)) {
        std::istringstream journal(base::readFile(folder / kJournal));
        std::getline(journal, found);
        found.erase(0, found.rfind(' ') + 1);
    } else if (fs::exists(folder / "run.json")) {
        const auto json = nlohmann::json::parse(base::readFile(folder / "run.json"), nullptr, false);
        if (json.is_object()) found = json.value("sweep", "");
    }
    if (found != sweep)
        throw base::UsageError(fmt::format("{} is not empty and holds no run of sweep '{}' to replace; name another folder with -o", folder.string(), sweep));
    for (const std::string& name : {std::string(kMetrics), std::string(kSamples), partOf("", kMetrics).string(), partOf("", kSamples).string(),
                                    std::string("plan.csv"), std::string("run.json"), std::string(kJournal)})
        fs::remove(folder / name);
}

RunFolder::RunFolder(fs::path folder, const std::string& sweep, const std::string& planHash, const std::string& backend, bool resume)
    : folder_(std::move(folder)), sweep_(sweep), planHash_(planHash), backend_(backend) {
    check(folder_, resume);
    base::requireWritableFolder(folder_);
    if (fs::exists(folder_ / kJournal)) {
        resumeJournal();
        return;
    }
    if (fs::exists(folder_ / "run.json")) {
        const auto json = nlohmann::json::parse(base::readFile(folder_ / "run.json"), nullptr, false);
        if (!json.is_object() || !json.contains("plan_hash"))
            throw base::Error(base::ExitCode::corrupt, fmt::format("{} is damaged; remove the folder and run again", (folder_ / "run.json").string()));
        requireSame(folder_, "plan", json.value("plan_hash", ""), planHash);
        requireSame(folder_, "timer back-end", json.value("backend", ""), backend);
        runId_ = json.value("run_id", "");
        complete_ = true;
        return;
    }
    // A kill between making the folder and the journal's first line leaves plan.csv at most.
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
        if (entry.path().filename() != "plan.csv" && entry.path().extension() != ".part" && entry.path().extension() != ".tmp")
            throw base::UsageError(fmt::format("{} is not empty and holds no run to resume; name another folder with -o", folder_.string()));
    startNew();
}

void RunFolder::startNew() {
    runId_ = freshId(planHash_);
    started_ = utcNow();
    base::writeFile(partOf(folder_, kMetrics), csvRow(kMetricsColumns));
    base::writeFile(partOf(folder_, kSamples), csvRow(kSamplesColumns));
    base::writeFile(folder_ / kJournal, fmt::format("run {} {} {} {} {}\n", runId_, planHash_, backend_, started_, sweep_));
}

void RunFolder::resumeJournal() {
    // A kill between two renames of finish() leaves one file under its final name.
    for (const char* name : {kMetrics, kSamples})
        if (!fs::exists(partOf(folder_, name)) && fs::exists(folder_ / name)) fs::rename(folder_ / name, partOf(folder_, name));

    std::string text = base::readFile(folder_ / kJournal);
    text.resize(text.rfind('\n') + 1);  // npos + 1 = 0: a torn line was not finished
    std::istringstream lines(text);
    std::string line, word, theirPlan, theirBackend;
    std::getline(lines, line);
    if (!(std::istringstream(line) >> word >> runId_ >> theirPlan >> theirBackend >> started_) || word != "run")
        throw base::Error(base::ExitCode::corrupt, fmt::format("{} is damaged; remove the folder and run again", (folder_ / kJournal).string()));
    requireSame(folder_, "plan", theirPlan, planHash_);
    requireSame(folder_, "timer back-end", theirBackend, backend_);

    uintmax_t metricsEnd = csvRow(kMetricsColumns).size(), samplesEnd = csvRow(kSamplesColumns).size();
    const uintmax_t metricsSize = sizeOf(partOf(folder_, kMetrics)), samplesSize = sizeOf(partOf(folder_, kSamples));
    if (metricsSize < metricsEnd || samplesSize < samplesEnd) return startNew();
    std::string kept = text.substr(0, line.size() + 1);
    while (std::getline(lines, line)) {
        std::istringstream words(line);
        size_t comparison = 0;
        uintmax_t metrics = 0, samples = 0;
        words >> word;
        if (word == "resumed") ++process_;
        else if (word == "done" && words >> comparison >> metrics >> samples && metrics <= metricsSize && samples <= samplesSize) {
            done_.insert(comparison);
            metricsEnd = metrics;
            samplesEnd = samples;
        } else break;  // what follows a damaged line cannot be trusted
        kept += line + "\n";
    }
    fs::resize_file(partOf(folder_, kMetrics), metricsEnd);
    fs::resize_file(partOf(folder_, kSamples), samplesEnd);
    ++process_;
    base::writeFile(folder_ / kJournal, kept + fmt::format("resumed {}\n", utcNow()));
}

void RunFolder::append(size_t comparison, const std::string& metricsRows, const std::string& samplesRows) {
    appendDurably(partOf(folder_, kMetrics), metricsRows);
    appendDurably(partOf(folder_, kSamples), samplesRows);
    appendDurably(folder_ / kJournal, fmt::format("done {} {} {}\n", comparison, sizeOf(partOf(folder_, kMetrics)), sizeOf(partOf(folder_, kSamples))));
    done_.insert(comparison);
}

void RunFolder::finish(const std::string& runJson) {
    base::writeFile(folder_ / "run.json", runJson);
    fs::rename(partOf(folder_, kSamples), folder_ / kSamples);
    fs::rename(partOf(folder_, kMetrics), folder_ / kMetrics);
    fs::remove(folder_ / kJournal);
    complete_ = true;
}

fs::path RunFolder::metricsPath() const { return complete_ ? folder_ / kMetrics : partOf(folder_, kMetrics); }

}  // namespace dapple::bench
