#pragma once

#include <filesystem>
#include <set>
#include <string>

/// The folder of a run, and how a run survives being killed.
///
/// While it runs, rows are appended to metrics.csv.part and samples.csv.part, a whole comparison at a time, and
/// then one line of journal.part says how long both files are. A kill at any moment leaves at worst bytes
/// behind the lengths of the journal's last whole line: resuming cuts them off. finish() renames.
namespace dapple::bench {

class RunFolder {
public:
    /// Throws UsageError unless a run may be written there: the place must be writable, and empty or new
    /// unless `resume`. Creates nothing, so that it can be asked before anything else is known.
    static void check(const std::filesystem::path& folder, bool resume);

    /// Removes the files of a run of `sweep`, finished or not, and nothing else, so that check() passes if there was
    /// nothing else. Throws UsageError if the folder is not empty and holds no such run.
    static void removeRun(const std::filesystem::path& folder, const std::string& sweep);

    /// Starts a run, or goes on with the one that the folder holds. Throws UsageError if that one has another
    /// plan or back-end, or if nothing in the folder can be resumed.
    RunFolder(std::filesystem::path folder, const std::string& sweep, const std::string& planHash, const std::string& backend, bool resume);

    const std::string& runId() const { return runId_; }      ///< 16 hex digits, kept when resumed
    const std::string& started() const { return started_; }  ///< UTC, ISO 8601
    int process() const { return process_; }                 ///< 0 for the first start, +1 for each resumption
    bool complete() const { return complete_; }              ///< the folder's run had been finished before
    bool done(size_t comparison) const { return done_.contains(comparison); }

    /// Rows of one finished comparison. On disk when it returns. Throws UsageError (full disk).
    void append(size_t comparison, const std::string& metricsRows, const std::string& samplesRows);
    /// Writes run.json and gives the files their final names.
    void finish(const std::string& runJson);

    std::filesystem::path metricsPath() const;  ///< metrics.csv, or its part while the run goes on

private:
    void startNew();
    void resumeJournal();

    std::filesystem::path folder_;
    std::string sweep_, planHash_, backend_;
    std::string runId_, started_;
    int process_ = 0;
    bool complete_ = false;
    std::set<size_t> done_;
};

/// Now, UTC, ISO 8601.
std::string utcNow();

}  // namespace dapple::bench
