#include "base/error.h"
#include "bench/picture.h"
#include "bench/stress.h"
#include "bench/sweep.h"
#include "bench/verbs/verbs.h"
#include "scenegen/import/import.h"
#include "scenegen/library.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

namespace dapple::bench {
namespace {

using Names = std::vector<std::string>;

// Each script asks the program for what may stand at the cursor, and offers files where it says nothing.
constexpr const char* kBash = R"(_dapple() {
    local line=${COMP_LINE:0:COMP_POINT} words found
    read -ra words <<< "$line"
    [[ $line != *' ' ]] || words+=("")
    mapfile -t found < <("${words[0]/#\~/$HOME}" completion words -- "${words[@]:1}" 2> /dev/null)
    local typed=${words[-1]}
    # Bash takes what follows the last = for a word of its own.
    [[ $typed != *=* ]] || found=("${found[@]#"${typed%=*}="}")
    COMPREPLY=("${found[@]}")
    [[ ${#found[@]} -ne 1 || ${found[0]} != *= ]] || compopt -o nospace
}
complete -o default -F _dapple dapple ./dapple
)";
constexpr const char* kZsh = R"(#compdef dapple ./dapple
_dapple() {
    local -a found
    found=("${(@f)$("${words[1]/#\~/$HOME}" completion words -- "${(@)words[2,CURRENT]}" 2> /dev/null)}")
    if [[ -z $found ]]; then _files; return; fi
    compadd -S '' -- ${(M)found:#*=}
    compadd -- ${found:#*=}
}
compdef _dapple dapple ./dapple
)";
constexpr const char* kFish = R"(function __dapple_words
    set -l words (commandline -opc)
    $words[1] completion words -- $words[2..] (commandline -ct) 2> /dev/null
end
complete -c dapple -a '(__dapple_words)'
)";
const std::map<std::string, std::string> kShells{{"bash", kBash}, {"zsh", kZsh}, {"fish", kFish}};

template <class Items>
Names namesOf(const Items& items) {
    Names names;
    for (const auto& item : items) names.push_back(item.name);
    return names;
}

Names sceneNames() {
    Names names = namesOf(scenegen::listScenes());
    for (const scenegen::SceneEntry& scene : scenegen::listRealScenes()) names.push_back(scene.name);
    return names;
}

/// "size=", …; after the = the axis's values.
Names assignments(const std::string& typed) {
    const size_t equals = typed.find('=');
    Names found;
    for (const shadow::Axis& axis : shadow::axes()) {
        if (equals == std::string::npos) found.push_back(axis.name + "=");
        else if (axis.name == typed.substr(0, equals))
            for (const shadow::Axis::Value& value : axis.values) found.push_back(axis.name + "=" + value.name);
    }
    return found;
}

/// What may stand for an option or a positional of that name; nothing where it is a file or a number.
Names valuesOf(const CLI::App& app, const std::string& name, const std::string& typed) {
    const std::map<std::string, std::function<Names()>> known{
        {"scene", sceneNames},
        {"technique", [] { return namesOf(shadow::techniques()); }},
        {"SWEEP", [] { return namesOf(listSweeps()); }},
        {"what", listNames},
        {"VERB", [&] { return verbNames(app); }},
        {"SHELL", [] { return Names{"bash", "fish", "zsh"}; }},
        {"--axis", [&] { return assignments(typed); }},
        {"--what", [] { return namesOf(pictureKinds()); }},
        {"--stress", [] { return namesOf(stressCases()); }},
        {"--backend", [] { return Names(timerNames().begin(), timerNames().end()); }}};
    const auto found = known.find(name);
    return found == known.end() ? Names{} : found->second();
}

const CLI::Option* optionOf(const CLI::App& level, const std::string& word) {
    for (const CLI::Option* option : level.get_options())
        if (word.starts_with("-") && option->check_name(word)) return option;
    return nullptr;
}

/// What may stand in place of the last word.
Names candidates(const CLI::App& app, const Names& words) {
    const CLI::App* verb = nullptr;
    const CLI::Option* open = nullptr;  // waits for its value
    size_t positional = 0;
    for (size_t i = 0; i + 1 < words.size(); ++i) {
        const CLI::Option* option = verb ? optionOf(*verb, words[i]) : nullptr;
        if (!option) option = optionOf(app, words[i]);
        if (open) open = nullptr;
        else if (option) open = option->get_type_size() > 0 ? option : nullptr;
        else if (verb) ++positional;
        else if (!words[i].starts_with("-")) verb = findVerb(app, words[i]);
    }
    const std::string& typed = words.back();
    if (open) return valuesOf(app, open->get_name(), typed);
    Names names;
    if (typed.starts_with("-")) {
        for (const CLI::App* level : {verb ? verb : &app, &app})
            for (const CLI::Option* option : level->get_options())
                for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
        return names;
    }
    if (!verb) return valuesOf(app, "VERB", typed);
    for (const CLI::Option* option : verb->get_options())
        if (option->get_positional() && positional-- == 0) return valuesOf(app, option->get_name(true), typed);
    return {};
}

void complete(const CLI::App& app, const std::string& shell, const Names& words) {
    if (const auto script = kShells.find(shell); script != kShells.end() && words.empty()) {
        fmt::print("{}", script->second);
        return;
    }
    if (shell != "words" || words.empty())
        throw base::UsageError(base::unknownName("shell", shell, Names{"bash", "fish", "zsh"}));
    Names found = candidates(app, words);
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    for (const std::string& name : found)
        if (name.starts_with(words.back())) fmt::print("{}\n", name);
}

}  // namespace

void addCompletion(CLI::App& app) {
    CLI::App* verb = app.add_subcommand(
        "completion", "Print a script that lets a shell complete verbs, options, scenes, techniques, sweeps and axes");
    auto shell = std::make_shared<std::string>();
    auto words = std::make_shared<Names>();
    verb->add_option("SHELL", *shell, "bash, fish or zsh")->required();
    verb->add_option("WORDS", *words, "for the scripts: SHELL is `words`, and the last word is to be completed")
        ->group("");
    verb->footer("Examples:\n  source <(dapple completion bash)\n  dapple completion zsh > ~/.zfunc/_dapple\n"
                 "  dapple completion fish > ~/.config/fish/completions/dapple.fish");
    verb->callback([&app, shell, words] { complete(app, *shell, *words); });
}

}  // namespace dapple::bench
