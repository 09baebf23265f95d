#pragma once

#include "bench/folder_lock.h"
#include "bench/run.h"

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

/// The folder of a run, and how a run survives being killed.
///
/// While it runs, rows are appended to metrics.csv.part and samples.csv.part, a whole comparison at a time, and
/// then one line of journal.part says how long both files are, with a hash of what was appended. A kill at any moment leaves at
/// worst bytes behind the lengths of the journal's last whole line: resuming cuts them off. finish() renames.
namespace dapple::bench {

/// What a run is of. A run goes on only under the same plan and back-end, and, unless mixed on purpose, from the same origin.
struct RunKey {
    std::string sweep, planHash, backend;
    std::string origin;  ///< originOf(): one line
};

class RunFolder {
public:
    /// Throws UsageError unless a run may be written there: no other process does, the place is writable, and empty or new
    /// unless `resume`. Creates nothing, so that it can be asked before anything else is known.
    static void check(const std::filesystem::path& folder, bool resume);

    /// Removes the files of a run of `sweep`, finished or not, and nothing else, so that check() passes if there was
    /// nothing else. Throws UsageError if the folder is not empty and holds no such run, or another process writes there.
    static void removeRun(const std::filesystem::path& folder, const std::string& sweep);

    /// Starts a run, or goes on with the one that the folder holds, and locks the folder. `comparisonOf`: comparison by point id.
    /// Throws UsageError if that run has another plan, back-end or origin, or if nothing in the folder can be resumed.
    RunFolder(const RunOptions& options, RunKey key, std::map<std::string, size_t> comparisonOf);

    const std::string& runId() const { return runId_; }      ///< 16 hex digits, kept when resumed
    const std::string& started() const { return started_; }  ///< UTC, ISO 8601
    int process() const { return process_; }                 ///< 0 for the first start, +1 for each resumption
    bool complete() const { return complete_; }              ///< the folder's run had been finished before
    bool done(size_t comparison) const { return done_.contains(comparison); }
    const std::set<std::string>& origins() const { return origins_; }  ///< more than one: a mixed run

    /// Rows of one finished comparison. On disk when it returns. Throws UsageError (full disk).
    void append(size_t comparison, const std::string& metricsRows, const std::string& samplesRows);
    /// Writes plan.csv, run.json and the manifest, and gives the files their final names.
    void finish(const std::string& planCsv, const std::string& runJson);

    std::filesystem::path metricsPath() const;  ///< metrics.csv, or its part while the run goes on

private:
    void startNew();
    void resumeJournal(bool mix);
    void resumeFinished(bool mix, bool retryFailed);
    void requireOrigin(const std::string& theirs, bool mix);
    void dropFailed();
    void inOrder();
    std::string header() const;

    std::filesystem::path folder_;
    RunKey key_;
    std::map<std::string, size_t> comparisonOf_;
    std::shared_ptr<FolderLock> lock_;
    std::string runId_, started_;
    int process_ = 0;
    bool complete_ = false;
    std::set<size_t> done_;
    std::vector<size_t> order_;  ///< comparisons as they stand in the files
    std::set<std::string> origins_;
};

/// Now, UTC, ISO 8601.
std::string utcNow();

}  // namespace dapple::bench
