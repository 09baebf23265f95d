#pragma once

#include "measure/counters/ledger.h"

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace dapple::frame {

/// One step of a frame. Only execute() runs it, wrapped in debug label, clean GL state and measurements.
struct Pass {
    std::string name;                 ///< as in the `pass` column
    std::vector<std::string> reads;   ///< resources that an earlier pass of the frame, or an import, has written
    std::vector<std::string> writes;
    std::string why;                  ///< one line for `dapple list` and the JSON beside a picture
    std::string leftOut;              ///< not empty: the scene does not need this pass, for this reason
    std::function<void(measure::Ledger&)> record;  ///< issues the GL calls; state is reset around it
    bool asksOcclusion = false;       ///< runs occlusion queries of its own, beside which GL allows no other
};

/// The one seam around every pass.
class PassObserver {
public:
    virtual ~PassObserver() = default;
    virtual void beginPass(const Pass&) {}
    virtual void endPass(const Pass&, const measure::Ledger&) {}
    /// Counters of an untimed frame, for Ledger::counters; nullptr in a frame that runs as a timed one does.
    virtual measure::Counters* counters() { return nullptr; }
};

/// Names of the passes that run, in order.
std::vector<std::string> runningPasses(std::span<const Pass> passes);

/// Throws std::logic_error naming pass and resource if something is read before it is written. `imports`
/// are written outside the frame (a cached map). Left-out passes neither read nor write.
void check(std::span<const Pass> passes, std::span<const std::string> imports = {});

/// Runs the passes that are not left out, in order.
void execute(std::span<const Pass> passes, PassObserver& observer);

}  // namespace dapple::frame
