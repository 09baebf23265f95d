#include "base/webp.h"

#include "base/error.h"

#include <fmt/format.h>
#include <webp/decode.h>

#include <algorithm>
#include <string_view>

namespace dapple::base {

// RFC 9649, section 2.4.
bool isWebp(std::span<const uint8_t> b) {
    const std::string_view riff = "RIFF", webp = "WEBP";
    return b.size() >= 12 && std::equal(riff.begin(), riff.end(), b.begin()) && std::equal(webp.begin(), webp.end(), b.begin() + 8);
}

Image8 decodeWebp(std::span<const uint8_t> bytes, const std::string& name) {
    Image8 image;
    if (!WebPGetInfo(bytes.data(), bytes.size(), &image.width, &image.height)) throw UsageError(fmt::format("{}: damaged WebP image", name));
    image.texels.resize(size_t(image.width) * size_t(image.height) * 4);
    if (!WebPDecodeRGBAInto(bytes.data(), bytes.size(), image.texels.data(), image.texels.size(), image.width * 4))
        throw UsageError(fmt::format("{}: damaged WebP image", name));
    return image;
}

}  // namespace dapple::base
