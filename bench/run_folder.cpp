#include "bench/run_folder.h"

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "bench/csv.h"
#include "bench/manifest.h"
#include "bench/rows.h"
#include "bench/run_rows.h"
#include "measure/flags.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <algorithm>
#include <regex>
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

std::string hashOf(std::string_view bytes) {
    base::Hasher hasher;
    hasher.text(bytes);
    return base::hex16(hasher.digest());
}

void requireSame(const fs::path& folder, const std::string& what, const std::string& theirs, const std::string& ours) {
    if (theirs != ours)
        throw base::UsageError(fmt::format("{} holds a run with another {} ({}, now {}); resume it with the same sweep and options, or name another folder with -o",
                                           folder.string(), what, theirs, ours));
}

/// What a kill leaves behind in a folder: files that were being written, and the probes of requireWritableFolder().
bool isLeftover(const fs::path& file) {
    static const std::regex kTemporary(R"(.*\.\d+\.tmp|\.dapple-probe-\d+)");
    return std::regex_match(file.filename().string(), kTemporary);
}

/// Whoever holds the folder's lock knows that nobody is writing these.
void sweepLeftovers(const fs::path& folder) {
    for (const fs::path& place : {folder, folder / "pictures"}) {
        if (!fs::is_directory(place)) continue;
        for (const fs::directory_entry& entry : std::vector<fs::directory_entry>(fs::directory_iterator(place), {}))
            if (isLeftover(entry.path())) fs::remove(entry.path());
    }
}

bool isEmptyButForLeftovers(const fs::path& folder) {
    return std::all_of(fs::directory_iterator(folder), {}, [](const fs::directory_entry& entry) {
        return isLeftover(entry.path()) || entry.path().filename() == FolderLock::kFile;
    });
}

nlohmann::ordered_json readRunJson(const fs::path& folder) {
    auto json = nlohmann::ordered_json::parse(base::readFile(folder / "run.json"), nullptr, false);
    const bool whole = json.is_object() && json.contains("plan_hash") && json["plan_hash"].is_string();
    if (!whole) throw base::Error(base::ExitCode::corrupt, fmt::format("{} is damaged; remove the folder and run again", (folder / "run.json").string()));
    return json;
}

}  // namespace

std::string utcNow() {
    return fmt::format("{:%FT%TZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

void RunFolder::check(const fs::path& folder, bool resume) {
    std::error_code error;
    if (fs::exists(folder, error) && !fs::is_directory(folder, error))
        throw base::UsageError(fmt::format("{} is a file; name a folder with -o", folder.string()));
    FolderLock::requireFree(folder);
    if (!resume && fs::is_directory(folder, error) && !isEmptyButForLeftovers(folder))
        throw base::UsageError(fmt::format("{} is not empty; go on with --resume, or name another folder with -o", folder.string()));
    fs::path existing = fs::absolute(folder).lexically_normal();
    while (!fs::exists(existing, error) && existing.has_relative_path()) existing = existing.parent_path();
    base::requireWritableFolder(existing);
}

void RunFolder::removeRun(const fs::path& folder, const std::string& sweep) {
    if (!fs::is_directory(folder)) return;
    const auto lock = FolderLock::hold(folder);
    sweepLeftovers(folder);
    if (isEmptyButForLeftovers(folder)) return;
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
                                    std::string("plan.csv"), std::string("run.json"), std::string("manifest.json"), std::string(kJournal)})
        fs::remove(folder / name);
}

RunFolder::RunFolder(const RunOptions& options, RunKey key, std::map<std::string, size_t> comparisonOf)
    : folder_(options.folder), key_(std::move(key)), comparisonOf_(std::move(comparisonOf)) {
    check(folder_, options.resume);
    lock_ = FolderLock::hold(folder_);
    sweepLeftovers(folder_);
    if (fs::exists(folder_ / kJournal)) {
        resumeJournal(options.mix);
        if (options.retryFailed) dropFailed();
        return;
    }
    if (fs::exists(folder_ / "run.json")) {
        resumeFinished(options.mix, options.retryFailed);
        return;
    }
    // A kill between making the folder and the journal's first line leaves plan.csv at most.
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
        if (entry.path().filename() != "plan.csv" && entry.path().extension() != ".part")
            throw base::UsageError(fmt::format("{} is not empty and holds no run to resume; name another folder with -o", folder_.string()));
    startNew();
}

std::string RunFolder::header() const {
    std::string text = fmt::format("run {} {} {} {} {}\n", runId_, key_.planHash, key_.backend, started_, key_.sweep);
    for (const std::string& origin : origins_) text += fmt::format("origin {}\n", origin);
    return text;
}

void RunFolder::startNew() {
    runId_ = freshId(key_.planHash);
    started_ = utcNow();
    origins_ = {key_.origin};
    base::writeFile(partOf(folder_, kMetrics), csvRow(kMetricsColumns));
    base::writeFile(partOf(folder_, kSamples), csvRow(kSamplesColumns));
    base::writeFile(folder_ / kJournal, header());
}

void RunFolder::requireOrigin(const std::string& theirs, bool mix) {
    if (theirs != key_.origin && !mix)
        throw base::UsageError(fmt::format("{} holds a run of another program or machine ({}, now {}); resume it with that one, name another folder "
                                           "with -o, or add --mix: then every row is flagged", folder_.string(), theirs, key_.origin));
    origins_.insert(theirs);
}

void RunFolder::resumeFinished(bool mix, bool retryFailed) {
    const auto json = readRunJson(folder_);
    verifyManifest(folder_);
    requireSame(folder_, "plan", json.value("plan_hash", ""), key_.planHash);
    requireSame(folder_, "timer back-end", json.value("backend", ""), key_.backend);
    runId_ = json.value("run_id", "");
    started_ = json.value("start", "");
    process_ = json.value("processes", 1) - 1;
    complete_ = true;
    if (!retryFailed || failedComparisons(folder_ / kMetrics, comparisonOf_).empty()) return;

    for (const auto& origin : json.value("origins", nlohmann::ordered_json::array())) requireOrigin(origin.dump(), mix);
    fs::copy_file(folder_ / kMetrics, partOf(folder_, kMetrics), fs::copy_options::overwrite_existing);
    fs::copy_file(folder_ / kSamples, partOf(folder_, kSamples), fs::copy_options::overwrite_existing);
    ++process_;
    complete_ = false;
    dropFailed();
    for (const char* name : {kMetrics, kSamples, "run.json", "manifest.json"}) fs::remove(folder_ / name);
}

void RunFolder::resumeJournal(bool mix) {
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
    requireSame(folder_, "plan", theirPlan, key_.planHash);
    requireSame(folder_, "timer back-end", theirBackend, key_.backend);

    const std::string metrics = base::readFile(partOf(folder_, kMetrics)), samples = base::readFile(partOf(folder_, kSamples));
    size_t metricsEnd = csvRow(kMetricsColumns).size(), samplesEnd = csvRow(kSamplesColumns).size();
    if (metrics.size() < metricsEnd || samples.size() < samplesEnd) return startNew();
    std::string kept = text.substr(0, line.size() + 1);
    while (std::getline(lines, line)) {
        std::istringstream words(line);
        size_t comparison = 0, metricsTo = 0, samplesTo = 0;
        std::string hash;
        words >> word;
        if (word == "origin") requireOrigin(line.substr(word.size() + 1), mix);
        else if (word == "resumed") ++process_;
        else if (word == "done" && words >> comparison >> metricsTo >> samplesTo >> hash && metricsTo >= metricsEnd && metricsTo <= metrics.size() &&
                 samplesTo >= samplesEnd && samplesTo <= samples.size() &&
                 hash == hashOf(metrics.substr(metricsEnd, metricsTo - metricsEnd) + samples.substr(samplesEnd, samplesTo - samplesEnd))) {
            done_.insert(comparison);
            order_.push_back(comparison);
            metricsEnd = metricsTo;
            samplesEnd = samplesTo;
        } else {  // what follows a damaged line cannot be trusted
            base::logWarning(fmt::format("{}: rows from comparison {} on are torn or damaged and are measured again", folder_.string(), done_.size()));
            break;
        }
        kept += line + "\n";
    }
    fs::resize_file(partOf(folder_, kMetrics), metricsEnd);
    fs::resize_file(partOf(folder_, kSamples), samplesEnd);
    ++process_;
    kept += fmt::format("resumed {}\n", utcNow());
    if (origins_.insert(key_.origin).second) kept += fmt::format("origin {}\n", key_.origin);
    base::writeFile(folder_ / kJournal, kept);
}

void RunFolder::dropFailed() {
    const std::set<size_t> failed = failedComparisons(partOf(folder_, kMetrics), comparisonOf_);
    const auto metrics = rowsByComparison(partOf(folder_, kMetrics), comparisonOf_), samples = rowsByComparison(partOf(folder_, kSamples), comparisonOf_);
    origins_.insert(key_.origin);
    done_.clear();
    order_.clear();
    std::string metricsText = csvRow(kMetricsColumns), samplesText = csvRow(kSamplesColumns), journal = header();
    for (int i = 0; i < process_; ++i) journal += fmt::format("resumed {}\n", utcNow());
    for (const auto& [comparison, rows] : metrics) {
        if (failed.contains(comparison)) continue;
        const auto itsSamples = samples.find(comparison);
        const std::string more = itsSamples == samples.end() ? "" : itsSamples->second;
        metricsText += rows;
        samplesText += more;
        journal += fmt::format("done {} {} {} {}\n", comparison, metricsText.size(), samplesText.size(), hashOf(rows + more));
        done_.insert(comparison);
        order_.push_back(comparison);
    }
    // A kill between these leaves a journal whose hashes tell that the rows are others: they are measured again.
    base::writeFile(partOf(folder_, kMetrics), metricsText);
    base::writeFile(partOf(folder_, kSamples), samplesText);
    base::writeFile(folder_ / kJournal, journal);
}

void RunFolder::append(size_t comparison, const std::string& metricsRows, const std::string& samplesRows) {
    appendDurably(partOf(folder_, kMetrics), metricsRows);
    appendDurably(partOf(folder_, kSamples), samplesRows);
    appendDurably(folder_ / kJournal, fmt::format("done {} {} {} {}\n", comparison, sizeOf(partOf(folder_, kMetrics)),
                                                  sizeOf(partOf(folder_, kSamples)), hashOf(metricsRows + samplesRows)));
    done_.insert(comparison);
    order_.push_back(comparison);
}

/// Rows in the plan's order, with a flag on each where the run is mixed.
void RunFolder::inOrder() {
    const std::string flag = origins_.size() > 1 ? std::string(measure::flag::kMixed) : "";
    if (flag.empty() && std::is_sorted(order_.begin(), order_.end())) return;
    for (const auto& [name, columns] : {std::pair(kMetrics, csvRow(kMetricsColumns)), std::pair(kSamples, csvRow(kSamplesColumns))}) {
        std::string text = columns;
        for (const auto& [comparison, rows] : rowsByComparison(partOf(folder_, name), comparisonOf_, flag)) text += rows;
        base::writeFile(folder_ / name, text);
        fs::remove(partOf(folder_, name));
    }
}

void RunFolder::finish(const std::string& planCsv, const std::string& runJson) {
    base::writeFile(folder_ / "plan.csv", planCsv);
    base::writeFile(folder_ / "run.json", runJson);
    inOrder();
    for (const char* name : {kSamples, kMetrics})
        if (fs::exists(partOf(folder_, name))) fs::rename(partOf(folder_, name), folder_ / name);
    writeManifest(folder_, runId_);
    fs::remove(folder_ / kJournal);
    complete_ = true;
}

fs::path RunFolder::metricsPath() const { return complete_ ? folder_ / kMetrics : partOf(folder_, kMetrics); }

}  // namespace dapple::bench
