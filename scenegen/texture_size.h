#pragma once

#include "scenegen/scene.h"

namespace dapple::scenegen {

/// Scales textures that are wider or higher than `most` texels down by a whole factor for each side, so that camera, maps and
/// reference all read the same texels. Each is a note of the scene, and a warning.
void fitTextures(Scene& scene, int most);

}  // namespace dapple::scenegen
