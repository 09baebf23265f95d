#include "base/config.h"

#include "base/error.h"
#include "base/file.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <utility>

namespace dapple::base {

struct ConfigTable::Impl {
    std::shared_ptr<toml::table> document;  // keeps `table` alive
    const toml::table* table;
    std::string file;
    mutable std::set<std::string, std::less<>> asked;

    const toml::node* find(std::string_view key) const {
        asked.emplace(key);
        return table->get(key);
    }
    std::string where(const toml::node* node) const {
        if (node && node->source().path && *node->source().path != file) return *node->source().path;
        const auto line = node ? node->source().begin.line : table->source().begin.line;
        return line > 0 ? fmt::format("{}:{}", file, line) : file;
    }
    [[noreturn]] void fail(const toml::node* node, std::string_view key, std::string_view why) const {
        throw UsageError(fmt::format("{}: {}: {}", where(node), key, why));
    }
    double finite(const toml::node* node, std::string_view key, double lo, double hi) const {
        const auto value = node->value<double>();
        if (!value || !(node->is_floating_point() || node->is_integer())) fail(node, key, "must be a number");
        if (!std::isfinite(*value)) fail(node, key, "must be finite");
        if (*value < lo || *value > hi) fail(node, key, fmt::format("{} is outside {} … {}", *value, lo, hi));
        return *value;
    }
    std::string scalarText(const toml::node& node, std::string_view key) const {
        if (const auto* s = node.as_string()) return s->get();
        if (const auto* i = node.as_integer()) return fmt::format("{}", i->get());
        if (const auto* b = node.as_boolean()) return b->get() ? "true" : "false";
        if (const auto* d = node.as_floating_point(); d && std::isfinite(d->get())) return fmt::format("{}", d->get());
        fail(&node, key, "must be a text, a finite number or a boolean");
    }
    ConfigTable child(const toml::table* t) const {
        return ConfigTable(std::make_unique<Impl>(Impl{document, t, file, {}}));
    }
};

namespace {

std::optional<size_t> indexOf(const std::string& step) {
    if (step.empty() || step.size() > 8 || step.find_first_not_of("0123456789") != std::string::npos) return {};
    return std::stoul(step);
}

/// What `step` names below a node: a key, or an index of an array of tables. What is missing is made, a table or an
/// array of tables, so that a setting can reach what the file leaves out; finish() rejects it where nobody asks for it.
/// nullptr: the node has nothing below it, or the index leaves a gap.
toml::node* below(toml::node& node, const std::string& step, bool wantsArray, const std::string& source) {
    toml::table made = toml::parse(wantsArray ? "v = []" : "v = {}", source);
    if (toml::table* table = node.as_table()) {
        if (!table->contains(step)) made.get("v")->visit([&](auto& empty) { table->insert(step, std::move(empty)); });
        return table->get(step);
    }
    toml::array* array = node.as_array();
    const std::optional<size_t> index = indexOf(step);
    if (!array || !index || *index > array->size()) return nullptr;
    if (*index == array->size()) made.get("v")->visit([&](auto& empty) { array->push_back(std::move(empty)); });
    return array->get(*index);
}

}  // namespace

ConfigTable::ConfigTable(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ConfigTable::ConfigTable(ConfigTable&&) noexcept = default;
ConfigTable::~ConfigTable() = default;

ConfigTable ConfigTable::parseFile(const std::filesystem::path& path) { return parseText(readFile(path), path.string()); }

ConfigTable ConfigTable::parseText(std::string_view text, const std::string& name) {
    try {
        auto document = std::make_shared<toml::table>(toml::parse(text, name));
        const toml::table* root = document.get();
        return ConfigTable(std::make_unique<Impl>(Impl{std::move(document), root, name, {}}));
    } catch (const toml::parse_error& e) {
        throw UsageError(fmt::format("{}:{}: not valid TOML: {}", name, e.source().begin.line, e.description()));
    }
}

void ConfigTable::set(const std::string& setting) {
    const size_t equals = setting.find('=');
    if (equals == 0 || equals == std::string::npos) throw UsageError(fmt::format("setting '{}': must be key=value", setting));
    const std::string name = fmt::format("setting '{}'", setting), value = setting.substr(equals + 1);
    toml::table parsed;
    try {
        parsed = toml::parse("v = " + value, name);
    } catch (const toml::parse_error&) {
        toml::table text;
        text.insert("v", value);
        std::ostringstream quoted;
        quoted << text;
        parsed = toml::parse(quoted.str(), name);
    }

    std::vector<std::string> steps;
    std::istringstream path(setting.substr(0, equals));
    for (std::string step; std::getline(path, step, '.');) steps.push_back(step);
    toml::node* node = impl_->document.get();
    for (size_t i = 0; i + 1 < steps.size() && node; ++i)
        node = below(*node, steps[i], i + 2 < steps.size() && indexOf(steps[i + 1]), name);
    toml::table* table = node ? node->as_table() : nullptr;
    if (!table) throw UsageError(fmt::format("{}: '{}' is not within a table of {}", name, steps.back(), impl_->file));
    parsed.get("v")->visit([&](auto& leaf) { table->insert_or_assign(steps.back(), std::move(leaf)); });
}

bool ConfigTable::has(std::string_view key) const { return impl_->find(key) != nullptr; }

std::vector<std::string> ConfigTable::keys() const {
    std::vector<std::pair<uint32_t, std::string>> byLine;
    for (const auto& [key, node] : *impl_->table) byLine.emplace_back(node.source().begin.line, std::string(key.str()));
    std::stable_sort(byLine.begin(), byLine.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string> keys;
    for (auto& [line, key] : byLine) keys.push_back(std::move(key));
    return keys;
}

std::string ConfigTable::text(std::string_view key, std::string_view fallback) {
    return impl_->find(key) ? text(key) : std::string(fallback);
}

std::string ConfigTable::text(std::string_view key) {
    const toml::node* node = impl_->find(key);
    if (!node) fail(key, "is required");
    const auto* value = node->as_string();
    if (!value) fail(key, "must be a text");
    return value->get();
}

std::filesystem::path ConfigTable::path(std::string_view key) {
    const std::filesystem::path given = text(key);
    const auto& source = impl_->find(key)->source().path;
    return source && *source != impl_->file ? given : std::filesystem::path(impl_->file).parent_path() / given;
}

double ConfigTable::number(std::string_view key, double fallback, double lo, double hi) {
    const toml::node* node = impl_->find(key);
    return node ? impl_->finite(node, key, lo, hi) : fallback;
}

double ConfigTable::number(std::string_view key) {
    const toml::node* node = impl_->find(key);
    if (!node) fail(key, "is required");
    return impl_->finite(node, key, -1e300, 1e300);
}

int64_t ConfigTable::integer(std::string_view key, int64_t fallback, int64_t lo, int64_t hi) {
    const toml::node* node = impl_->find(key);
    if (!node) return fallback;
    const auto* value = node->as_integer();
    if (!value) fail(key, "must be a whole number");
    if (value->get() < lo || value->get() > hi) fail(key, fmt::format("{} is outside {} … {}", value->get(), lo, hi));
    return value->get();
}

bool ConfigTable::boolean(std::string_view key, bool fallback) {
    const toml::node* node = impl_->find(key);
    if (!node) return fallback;
    const auto* value = node->as_boolean();
    if (!value) fail(key, "must be true or false");
    return value->get();
}

std::vector<double> ConfigTable::numbers(std::string_view key, size_t count) {
    const toml::node* node = impl_->find(key);
    const toml::array* array = node ? node->as_array() : nullptr;
    if (!array || (count != 0 && array->size() != count))
        fail(key, count ? fmt::format("must be an array of {} numbers", count) : "must be an array of numbers");
    std::vector<double> result;
    for (const toml::node& item : *array) result.push_back(impl_->finite(&item, key, -1e300, 1e300));
    return result;
}

std::vector<std::string> ConfigTable::values(std::string_view key) {
    const toml::node* node = impl_->find(key);
    if (!node) fail(key, "is required");
    if (node->is_table()) fail(key, "must be a value or an array of values");
    std::vector<std::string> result;
    if (const auto* array = node->as_array()) {
        for (const toml::node& item : *array) result.push_back(impl_->scalarText(item, key));
        if (result.empty()) fail(key, "must not be empty");
    } else {
        result.push_back(impl_->scalarText(*node, key));
    }
    return result;
}

std::optional<ConfigTable> ConfigTable::table(std::string_view key) {
    const toml::node* node = impl_->find(key);
    if (!node) return std::nullopt;
    if (!node->is_table()) fail(key, "must be a table");
    return impl_->child(node->as_table());
}

std::vector<ConfigTable> ConfigTable::tables(std::string_view key) {
    std::vector<ConfigTable> result;
    const toml::node* node = impl_->find(key);
    if (!node) return result;
    const auto* array = node->as_array();
    if (!array || !node->is_array_of_tables()) fail(key, "must be an array of tables ([[" + std::string(key) + "]])");
    for (const toml::node& item : *array) result.push_back(impl_->child(item.as_table()));
    return result;
}

void ConfigTable::finish() const {
    const std::vector<std::string> known(impl_->asked.begin(), impl_->asked.end());
    for (const std::string& key : keys())
        if (!impl_->asked.contains(key))
            throw UsageError(fmt::format("{}: {}", impl_->where(impl_->table->get(key)), unknownName("key", key, known)));
}

void ConfigTable::fail(std::string_view key, std::string_view why) const { impl_->fail(impl_->table->get(key), key, why); }

}  // namespace dapple::base
