#include "base/error.h"
#include "base/terminal.h"
#include "bench/verbs/verbs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

namespace dapple::bench {
namespace {

constexpr size_t kNames = 30;  ///< columns left of the descriptions

/// CLI11's help, wrapped between words at the terminal's width.
class HelpFormatter final : public CLI::Formatter {
public:
    std::string make_description(const CLI::App* app) const override {
        return wrapped(Formatter::make_description(app));
    }
    std::string make_usage(const CLI::App* app, std::string name) const override {
        return base::wrapWords(Formatter::make_usage(app, std::move(name)), columns(), "       ");
    }
    std::string make_option(const CLI::Option* option, bool positional) const override {
        return entry(make_option_name(option, positional) + make_option_opts(option), make_option_desc(option));
    }
    std::string make_subcommand(const CLI::App* verb) const override {
        return entry(verb->get_name(), verb->get_description());
    }
    /// Examples stay commands that a shell takes.
    std::string make_footer(const CLI::App* app) const override {
        return base::wrapWords(Formatter::make_footer(app), columns(), "      ", " \\");
    }

private:
    static size_t columns() { return std::max<size_t>(base::terminalColumns(STDOUT_FILENO).value_or(100), 40); }
    static std::string wrapped(const std::string& text) { return base::wrapWords(text, columns()); }

    static std::string entry(const std::string& names, const std::string& description) {
        const size_t left = std::min(kNames, columns() / 3);
        const bool beside = base::textWidth(names) + 4 <= left;
        const std::string indent(left, ' '), head = "  " + names;
        const std::string text = base::wrapWords(indent + description, columns(), indent).substr(left);
        return head + (beside ? std::string(left - base::textWidth(head), ' ') : "\n" + indent) + text + "\n";
    }
};

void help(const CLI::App& app, const std::string& name) {
    const CLI::App* verb = findVerb(app, name);
    if (!name.empty() && !verb) throw base::UsageError(base::unknownName("verb", name, verbNames(app)));
    fmt::print("{}", app.get_formatter()->make_help(verb ? verb : &app, verb ? "dapple " + name : "dapple",
                                                    CLI::AppFormatMode::Normal));
}

}  // namespace

std::vector<std::string> verbNames(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* verb : app.get_subcommands(std::function<bool(const CLI::App*)>()))
        names.push_back(verb->get_name());
    return names;
}

const CLI::App* findVerb(const CLI::App& app, const std::string& name) {
    for (const CLI::App* verb : app.get_subcommands(std::function<bool(const CLI::App*)>()))
        if (verb->get_name() == name) return verb;
    return nullptr;
}

std::shared_ptr<CLI::FormatterBase> helpFormatter() { return std::make_shared<HelpFormatter>(); }

void addHelp(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("help", "Print this help, or that of a verb");
    auto name = std::make_shared<std::string>();
    verb->add_option("VERB", *name, "a verb of dapple");
    verb->footer("Examples:\n  dapple help\n  dapple help render");
    verb->callback([&app, name] { help(app, *name); });
}

}  // namespace dapple::bench
