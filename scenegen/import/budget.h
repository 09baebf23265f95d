#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>

namespace dapple::scenegen {

/// What reading one file may cost. A small file must not ask for a large machine: a few bytes can stand for gigabytes.
struct Limits {
    size_t nodes = 4'000'000;           ///< of the node graph, each path to a node counted
    size_t triangles = 200'000'000;     ///< stored, before instancing
    size_t instances = 20'000'000;
    size_t texels = 1u << 28;           ///< of all textures together
    size_t bytes = size_t(2) << 30;     ///< of one array that the file asks for
    double seconds = 8;                 ///< and one more for each MB of the file
};

/// Adds up what reading one file costs. Each call throws UsageError, naming the file, the amount and the limit, as soon as a
/// limit is passed; call it before memory is asked for.
class Budget {
public:
    explicit Budget(std::filesystem::path file, const Limits& limits = {});

    void nodes(size_t more);
    void triangles(size_t more);
    void instances(size_t more);
    void texels(size_t width, size_t height);
    void bytes(size_t ofOneArray) const;
    void time() const;

    const std::filesystem::path& file() const { return file_; }
    double seconds() const { return seconds_; }

private:
    void spend(size_t& spent, size_t more, size_t limit, const char* what);

    std::filesystem::path file_;
    Limits limits_;
    double seconds_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    size_t nodes_ = 0, triangles_ = 0, instances_ = 0, texels_ = 0;
};

}  // namespace dapple::scenegen
