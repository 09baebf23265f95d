#pragma once

#include "base/child.h"
#include "scenegen/scene.h"

namespace dapple::scenegen {

/// A scene from one process of this program to another of the same build: no format for files.
void put(base::Child::Output& out, const Scene& scene);
Scene getScene(base::Child& child);

/// The same of the files that were read for it.
void put(base::Child::Output& out, const std::vector<std::string>& files);
std::vector<std::string> getFiles(base::Child& child);

}  // namespace dapple::scenegen
