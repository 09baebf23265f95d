#include "scenegen/import/notes.h"

#include <fmt/format.h>

namespace dapple::scenegen {

void Notes::add(const std::string& what, const std::string& example, size_t count) {
    const auto [it, isNew] = index_.emplace(what, entries_.size());
    if (isNew) entries_.push_back({what, example, 0});
    entries_[it->second].count += count;
}

void Notes::add(const Notes& other) {
    for (const Entry& entry : other.entries_) add(entry.what, entry.example, entry.count);
}

std::vector<std::string> Notes::lines() const {
    std::vector<std::string> lines;
    for (const Entry& entry : entries_) {
        std::string line = printable(entry.what);
        const std::string first = entry.example.empty() ? "" : fmt::format("first: '{}'", printable(entry.example));
        if (entry.count > 1 && !first.empty()) line += fmt::format(" ({} times, {})", entry.count, first);
        else if (entry.count > 1) line += fmt::format(" ({} times)", entry.count);
        else if (!first.empty()) line += fmt::format(" ('{}')", printable(entry.example));
        lines.push_back(std::move(line));
    }
    return lines;
}

}  // namespace dapple::scenegen
