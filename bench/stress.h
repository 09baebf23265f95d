#pragma once

#include "scenegen/scene.h"

#include <span>
#include <string>

/// The stiff cases of the stability sweep: a scene as it is, pushed to where shadow techniques break.
namespace dapple::bench {

struct StressCase {
    std::string name;
    std::string description;
    void (*apply)(scenegen::Scene&);  ///< changes the sun, every view, the origin or what casts
};

std::span<const StressCase> stressCases();

/// scenegen::loadScene() of a name or file, pushed to a case where one is named, without what then can stand nowhere.
scenegen::Scene loadScene(const std::string& nameOrFile, const std::vector<std::string>& settings,
                          const std::string& stressCase);

/// Throws UsageError naming the nearest known case.
const StressCase& stressCase(const std::string& name);

}  // namespace dapple::bench
