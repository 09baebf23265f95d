#include "truth/reference.h"

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"

#include <fmt/format.h>

#include <atomic>
#include <cstring>
#include <optional>
#include <span>

/// Entry: Header, then the labels, four to a byte, the first in the lowest bits; then the shares of light, floats, if there are any.
namespace dapple::truth {
namespace {

/// To be raised whenever trace() may give another label for the same input: old entries are then not found.
constexpr uint32_t kTracerVersion = 2;

struct Header {
    char magic[8] = {'d', 'a', 'p', 'p', 'l', 'e', 'G', '1'};
    uint64_t key = 0;
    int32_t width = 0, height = 0;
    uint64_t payloadHash = 0;
};
static_assert(sizeof(Header) == 32);

uint64_t keyOf(uint64_t sceneHash, const Receivers& receivers, const glm::dvec3& eye, const glm::dvec3& light) {
    base::Hasher h;
    h.value(kTracerVersion);
    h.value(sceneHash);
    h.value(receivers.width);
    h.value(receivers.height);
    h.array(std::span<const glm::vec3>(receivers.position));
    h.array(std::span<const glm::vec3>(receivers.normal));
    h.array(std::span<const uint8_t>(receivers.present));
    h.value(eye);
    h.value(light);
    return h.digest();
}

uint64_t hashOf(std::string_view bytes) {
    base::Hasher h;
    h.text(bytes);
    return h.digest();
}

std::string encode(const Reference& reference, uint64_t key) {
    std::string payload((reference.label.size() + 3) / 4, '\0');
    for (size_t i = 0; i < reference.label.size(); ++i)
        payload[i / 4] = char(uint8_t(payload[i / 4]) | (uint8_t(reference.label[i]) << (2 * (i % 4))));
    payload.append(reinterpret_cast<const char*>(reference.transmitted.data()), reference.transmitted.size() * sizeof(float));
    Header header;
    header.key = key;
    header.width = reference.width;
    header.height = reference.height;
    header.payloadHash = hashOf(payload);
    return std::string(reinterpret_cast<const char*>(&header), sizeof header) + payload;
}

/// Nothing if the bytes are not the entry of that key and size.
std::optional<Reference> decode(std::string_view bytes, uint64_t key, int width, int height) {
    const size_t pixels = size_t(width) * size_t(height);
    const size_t labels = (pixels + 3) / 4;
    const bool translucent = bytes.size() == sizeof(Header) + labels + pixels * sizeof(float);
    if (!translucent && bytes.size() != sizeof(Header) + labels) return std::nullopt;
    const std::string_view payload = bytes.substr(sizeof(Header));
    Header expected;
    expected.key = key;
    expected.width = width;
    expected.height = height;
    expected.payloadHash = hashOf(payload);
    if (std::memcmp(bytes.data(), &expected, sizeof expected) != 0) return std::nullopt;
    Reference reference{width, height, std::vector<Label>(pixels), std::vector<float>(translucent ? pixels : 0)};
    if (translucent) std::memcpy(reference.transmitted.data(), payload.data() + labels, pixels * sizeof(float));
    for (size_t i = 0; i < pixels; ++i) reference.label[i] = Label((uint8_t(payload[i / 4]) >> (2 * (i % 4))) & 3);
    return reference;
}

std::optional<Reference> readEntry(const std::filesystem::path& path, uint64_t key, int width, int height) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return std::nullopt;
    std::optional<Reference> reference;
    try {
        reference = decode(base::readFile(path), key, width, height);
    } catch (const base::UsageError&) {
        // Unreadable: no better than damaged.
    }
    if (!reference) base::logWarning(fmt::format("cached reference {} is damaged or unreadable; tracing it anew", path.string()));
    return reference;
}

}  // namespace

Reference cachedReference(const Tracer& tracer, uint64_t sceneHash, const Receivers& receivers, const glm::dvec3& eye,
                          const glm::dvec3& light, const std::filesystem::path& cacheFolder) {
    const uint64_t key = keyOf(sceneHash, receivers, eye, light);
    const std::filesystem::path path = cacheFolder / (base::hex16(key) + ".truth");
    if (std::optional<Reference> cached = readEntry(path, key, receivers.width, receivers.height)) return std::move(*cached);

    Reference reference = tracer.trace(receivers, eye, light);
    static std::atomic<bool> warned = false;
    try {
        base::writeFile(path, encode(reference, key));
    } catch (const base::UsageError& error) {
        if (!warned.exchange(true)) base::logWarning(fmt::format("references are not cached, each is traced anew: {}", error.what()));
    }
    return reference;
}

}  // namespace dapple::truth
