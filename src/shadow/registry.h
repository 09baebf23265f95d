#pragma once

#include "scenegen/scene.h"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dapple::shadow {

/// Axis name → value as text, in canonical form (as the axis writes it). Ordered, so that it hashes.
using Settings = std::map<std::string, std::string>;

/// One independent choice: a list of named values, a whole number in [lo, hi], or either.
struct Axis {
    struct Value {
        std::string name, description;
    };
    std::string name;
    std::string description;      ///< with the unit where it has one
    std::vector<Value> values;    ///< empty: a whole number
    long lo = 0, hi = 0;          ///< equal: a named value

    bool takesNumbers() const { return lo < hi; }

    /// Canonical text of a value. Throws UsageError: unknown value (with the nearest) or out of range.
    std::string canonical(const std::string& value) const;
};

/// A named technique: a family, the axes it has and their defaults (its preset).
struct TechniqueInfo {
    std::string name;
    std::string family;       ///< baseline, map, instanced, volume
    std::string description;  ///< with the paper
    Settings defaults;        ///< exactly the axes that the technique has
    int version = 1;          ///< raised when its pixels or passes are redefined; part of every point's id
};

std::span<const TechniqueInfo> techniques();
std::span<const Axis> axes();

/// By name; UsageError with the nearest known name.
const TechniqueInfo& technique(const std::string& name);
const Axis& axis(const std::string& name);

/// The technique's defaults overridden by `overrides`, canonical. UsageError for an axis that the
/// technique does not have or a value that the axis does not know.
Settings resolve(const TechniqueInfo& technique, const Settings& overrides);

/// Limits that a point is checked against before anything is allocated.
struct Limits {
    long maxTextureSize = 16384;
    long maxArrayLayers = 2048;
};

/// The rule by which this product of axes is not worth or not able to run on such a scene, as one
/// sentence; nothing if it should run. Points so dropped stay in the plan with this reason.
std::optional<std::string> pruneReason(const TechniqueInfo& technique, const Settings& settings,
                                       const scenegen::Facts& facts, const Limits& limits);

}  // namespace dapple::shadow
