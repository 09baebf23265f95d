#pragma once

#include "base/log.h"

#include <map>
#include <string>
#include <vector>

namespace dapple::scenegen {

/// What a file asks for and its reader does not do. Equal requests are counted, so that each kind is one warning and one line
/// of `dapple scene --stats`. What must not be left out is refused instead.
class Notes {
public:
    /// `what` is a sentence without full stop that names the request and what happens instead: "morph targets are ignored".
    /// `example` names where it was met first: a node, a material, a line.
    void add(const std::string& what, const std::string& example = {}, size_t count = 1);
    /// Adds what another reader has noted.
    void add(const Notes& other);

    /// "morph targets are ignored (3 times, first: 'flag')", in the order in which each was first met. Control characters are escaped.
    std::vector<std::string> lines() const;

    struct Entry {
        std::string what, example;
        size_t count = 0;
    };
    const std::vector<Entry>& entries() const { return entries_; }

private:
    std::vector<Entry> entries_;
    std::map<std::string, size_t> index_;
};

using base::printable;

}  // namespace dapple::scenegen
