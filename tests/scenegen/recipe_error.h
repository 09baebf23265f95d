#pragma once

#include "base/error.h"
#include "base/file.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace dapple::scenegen {

/// What a recipe that begins with a description and goes on with `text` is refused with.
inline std::string recipeError(const std::string& text) {
    // Tests of other programs run at the same time.
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / ("recipe-" + std::to_string(getpid()) + ".toml");
    base::writeFile(path, "description = \"x\"\n" + text);
    try {
        loadScene(path.string());
    } catch (const base::UsageError& e) {
        return e.what();
    }
    return "no error";
}

}  // namespace dapple::scenegen
