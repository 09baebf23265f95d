#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace dapple::base {

/// Finaliser of splitmix64 (Steele, Lea, Flood 2014): a bijection of 64 bits with full avalanche.
constexpr uint64_t mix64(uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/// Streaming 64-bit content hash. Same bytes in the same calls give the same value on every
/// little-endian machine. Not cryptographic: it names cache entries and points, it guards nothing.
class Hasher {
public:
    void bytes(const void* data, size_t size) {
        const auto* p = static_cast<const unsigned char*>(data);
        // The length first: no other split into calls absorbs the same words.
        state_ = mix64(state_ ^ uint64_t{size});
        for (; size >= 8; p += 8, size -= 8) {
            uint64_t word = 0;
            std::memcpy(&word, p, 8);
            state_ = mix64(state_ ^ word);
        }
        uint64_t tail = 0;
        if (size > 0) {
            std::memcpy(&tail, p, size);
            state_ = mix64(state_ ^ tail);
        }
    }
    template <class T>
        requires std::is_trivially_copyable_v<T>
    void value(const T& v) { bytes(&v, sizeof v); }
    template <class T>
        requires std::is_trivially_copyable_v<T>
    void array(std::span<const T> v) { bytes(v.data(), v.size_bytes()); }
    void text(std::string_view s) { bytes(s.data(), s.size()); }

    uint64_t digest() const { return mix64(state_); }

private:
    uint64_t state_ = 0x6461'7070'6c65'0001u;
};

/// 16 lower-case hexadecimal digits.
std::string hex16(uint64_t value);

}  // namespace dapple::base
