#pragma once

#include "scenegen/scene.h"

#include <vector>

namespace dapple::scenegen {

/// What a small picture of a scene shows, as shares of its pixels.
struct Sight {
    double casters = 0;   ///< steep surfaces of shadow casters, as of trees and houses
    double shadowed = 0;  ///< flat surfaces that face the sun and lie in shadow
    double lit = 0;       ///< flat surfaces that face the sun and lie in its light
    double near = 0;      ///< steep surfaces right before the eye
    double sky = 0;

    /// How much there is to see for somebody who compares shadows: casters, and light beside shadow, with no wall before the eye.
    double score() const;
};

/// Draws pictures of 64 × 48 pixels on the CPU, to choose views by what they see. Alpha is ignored. Large scenes are thinned out: a
/// picture costs at most some million triangles.
class QuickRender {
public:
    explicit QuickRender(const Scene& scene);
    Sight look(const View& view) const;

private:
    struct Item {
        glm::vec3 lo, hi;      ///< box, metres from Scene::origin
        uint32_t first, count; ///< of corners_, three a triangle
        bool caster;
    };
    void addItem(const Scene& scene, const Instance& instance, size_t stride);
    void drawSunMap(const Scene& scene);
    bool inShadow(const glm::vec3& p, float cosine) const;

    std::vector<glm::vec3> corners_;  ///< metres from Scene::origin
    std::vector<Item> items_;
    glm::vec3 toSun_{0, 0, 1};
    glm::mat4 sunFromWorld_{1};       ///< x, y: texels; z: metres towards the sun
    float sunTexel_ = 1;              ///< metres
    std::vector<float> sunMap_;       ///< greatest z per texel
};

}  // namespace dapple::scenegen
