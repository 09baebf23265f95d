#pragma once

#include "frame/frame.h"

namespace dapple::frame {

/// The scene's local lights, added to the shaded picture without shadows. A scene without them has no buffer and no
/// program, and leaves the pass out.
class Lamps {
public:
    explicit Lamps(Frame& frame);
    Pass pass();

private:
    void draw(measure::Ledger& tally);

    Frame& frame_;
    gl::Program program_;
    gl::Buffer buffer_;
    gl::VertexArray noAttributes_;
};

}  // namespace dapple::frame
