#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace toml { inline namespace v3 { class table; } }

namespace dapple::base {

/// One table of a TOML file, read strictly: every getter checks the type and the range, finish() rejects
/// keys that nobody asked for. All errors are UsageErrors of one line with file, line, key and the rule,
/// and name the nearest known key.
///
///     ConfigTable root = ConfigTable::parseFile(path);
///     const int trees = root.integer("trees", 100, 1, 100'000'000);
///     for (ConfigTable& t : root.tables("species")) …
///     root.finish();
class ConfigTable {
public:
    static ConfigTable parseFile(const std::filesystem::path& path);
    static ConfigTable parseText(std::string_view text, const std::string& name);
    ConfigTable(ConfigTable&&) noexcept;
    ~ConfigTable();

    /// Replaces or adds a value before anything is read: "ground.size=50", "species.0.triangles=900"; the value is
    /// TOML, or a text when it is not. Tables that the file leaves out are added, and so is the next one of an array:
    /// what is not known is refused by the getters and by finish(). Call it on a root table. Errors name the setting.
    void set(const std::string& setting);

    bool has(std::string_view key) const;
    std::vector<std::string> keys() const;  ///< in the file's order of lines

    // Getters: a missing key yields the default; the overloads without one require the key.
    std::string text(std::string_view key, std::string_view fallback);
    std::string text(std::string_view key);
    /// A file's path: a relative one counts from the folder of the file that says it, or, in a setting, from the working folder.
    std::filesystem::path path(std::string_view key);
    double number(std::string_view key, double fallback, double lo = -1e300, double hi = 1e300);  ///< finite
    double number(std::string_view key);
    int64_t integer(std::string_view key, int64_t fallback, int64_t lo, int64_t hi);
    bool boolean(std::string_view key, bool fallback);
    std::vector<double> numbers(std::string_view key, size_t count);  ///< array of `count` finite numbers (0 = any)
    /// A scalar or an array of scalars, each as text in its shortest form (axis values of a sweep).
    std::vector<std::string> values(std::string_view key);

    std::optional<ConfigTable> table(std::string_view key);
    std::vector<ConfigTable> tables(std::string_view key);  ///< array of tables; empty when missing

    /// Throws if the table holds a key that was never asked for.
    void finish() const;
    /// A UsageError "FILE:LINE: KEY: why" for a rule that this class does not know.
    [[noreturn]] void fail(std::string_view key, std::string_view why) const;

private:
    struct Impl;
    explicit ConfigTable(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace dapple::base
