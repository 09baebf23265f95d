#pragma once

#include "base/image.h"

namespace dapple::base {

bool isWebp(std::span<const uint8_t> bytes);

/// RGBA. Throws UsageError, with `name`, when the bytes are damaged.
Image8 decodeWebp(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace dapple::base
