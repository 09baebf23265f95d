#include "frame/pass.h"

#include "gl/objects.h"

#include <algorithm>
#include <stdexcept>

namespace dapple::frame {

std::vector<std::string> runningPasses(std::span<const Pass> passes) {
    std::vector<std::string> names;
    for (const Pass& pass : passes)
        if (pass.leftOut.empty()) names.push_back(pass.name);
    return names;
}

void check(std::span<const Pass> passes, std::span<const std::string> imports) {
    std::vector<std::string> written(imports.begin(), imports.end());
    for (const Pass& pass : passes) {
        if (!pass.leftOut.empty()) continue;
        for (const std::string& resource : pass.reads)
            if (std::find(written.begin(), written.end(), resource) == written.end())
                throw std::logic_error("pass " + pass.name + " reads " + resource + ", which no earlier pass writes");
        written.insert(written.end(), pass.writes.begin(), pass.writes.end());
    }
}

void execute(std::span<const Pass> passes, PassObserver& observer) {
    for (const Pass& pass : passes) {
        if (!pass.leftOut.empty()) continue;
        glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, pass.name.c_str());
        gl::resetState();
        measure::Ledger tally;
        tally.counters = observer.counters();
        observer.beginPass(pass);
        pass.record(tally);
        observer.endPass(pass, tally);
        glPopDebugGroup();
    }
    gl::resetState();
}

}  // namespace dapple::frame
