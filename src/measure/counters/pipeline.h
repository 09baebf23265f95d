#pragma once

#include <epoxy/gl.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dapple::measure {

struct CounterValue {
    std::string_view metric;        ///< a name of metrics()
    std::optional<uint64_t> value;
    std::string missing;            ///< why there is no value
};

struct PassCounters {
    std::string pass;
    std::vector<CounterValue> values;  ///< one per metric, in a fixed order

    /// Nothing when the counter is missing. `metric` must be one of the values'.
    std::optional<uint64_t> value(std::string_view metric) const;
    /// Fragment shader invocations per sample that passed (llvmpipe: 16 per tiny triangle, though it covers 3
    /// samples). Nothing when either is missing or no sample passed.
    std::optional<double> overshade() const;
};

/// GL queries around the passes of an untimed frame: samples_passed, fragment_invocations,
/// vertex_invocations, primitives_submitted (ARB_pipeline_statistics_query). All are active at once, so that a
/// pass must not run a statistics query of its own, nor, unless it says so, an occlusion query: GL 4.5 (section 4.2) allows
/// one active query for SAMPLES_PASSED and the two ANY_SAMPLES_PASSED together.
/// Needs a current GL 4.5 context until it is destroyed.
class Counters {
public:
    Counters();
    ~Counters();
    Counters(const Counters&) = delete;
    Counters& operator=(const Counters&) = delete;

    /// `asksOcclusion`: the pass runs occlusion queries of its own; its samples_passed is missing for that reason.
    void begin(std::string_view pass, bool asksOcclusion = false);
    void end();
    /// Samples that `draw` passes, which no pass's counts hold. Waits for them. Between begin() and end(), or outside.
    uint64_t aside(const std::function<void()>& draw);
    /// Waits for all passes since the last call; their counts in the order of begin().
    std::vector<PassCounters> results();

private:
    struct Target {
        GLenum target;
        std::string_view metric;
        std::string missing;  ///< empty: supported
    };
    struct Pass {
        std::string name;
        bool asksOcclusion = false;
        bool ended = false;
        std::vector<std::vector<GLuint>> queries{};  ///< one set for each stretch between aside()s, parallel to targets_; 0 where missing
    };
    void open();   ///< a stretch of the last pass
    void close();
    static std::string missing(const Target& target, bool asksOcclusion);
    std::vector<Target> targets_;
    std::vector<Pass> passes_;
};

/// Free memory of the GPU in bytes as the driver tells it (NVX_gpu_memory_info, ATI_meminfo); nothing where it
/// does not. What a technique takes is the difference of two calls.
std::optional<uint64_t> driverFreeBytes();

}  // namespace dapple::measure
