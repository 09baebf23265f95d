#include "shadow/technique.h"

#include "measure/counters/pipeline.h"
#include "shadow/families.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace dapple::shadow {

double kernelRadius(const Settings& settings) {
    const std::string& filter = settings.at("filter");
    return filter == "nearest" ? 0 : filter == "pcf2" ? 0.5 : 1.5;
}

std::vector<std::string> samplingDefines(const Settings& settings) {
    const std::string& bias = settings.at("bias");
    const std::string& filter = settings.at("filter");
    GLint subpixelBits = 4;  // the least that GL promises
    glGetIntegerv(GL_SUBPIXEL_BITS, &subpixelBits);
    return {fmt::format("BIAS {}", bias == "constant" ? 0 : bias == "slope" ? 1 : 2),
            fmt::format("FILTER {}", filter == "nearest" ? 0 : filter == "pcf2" ? 1 : 2),
            fmt::format("KERNEL {:.1f}", kernelRadius(settings)), fmt::format("SNAP {:.7f}", std::exp2(-double(subpixelBits) - 1))};
}

void drawCasters(const gpuscene::GpuScene& scene, const gpuscene::DrawList& list, const glm::dmat4& lightClip,
                 const gl::Program& opaque, const gl::Program& alpha, measure::Ledger& tally) {
    setCasterClip(lightClip, opaque, alpha);
    drawCasters(scene, list, opaque, alpha, tally);
}

void setCasterClip(const glm::dmat4& lightClip, const gl::Program& opaque, const gl::Program& alpha) {
    for (const gl::Program* program : {&opaque, &alpha})
        if (program->name()) program->set("uLightClip", glm::mat4(lightClip));
}

void drawCasters(const gpuscene::GpuScene& scene, const gpuscene::DrawList& list, const gl::Program& opaque, const gl::Program& alpha, measure::Ledger& tally) {
    const auto draw = [&](const gl::Program& program, gpuscene::Bucket bucket, gpuscene::Attributes attributes) {
        if (!program.name()) return;
        program.use();
        const gpuscene::DrawCount count = scene.draw(list, bucket, attributes, program.name(), gpuscene::Faces::front, tally.counters != nullptr);
        tally.drawCalls += count.draws;
        tally.trianglesSubmitted += count.triangles;
    };
    draw(opaque, gpuscene::Bucket::opaque, gpuscene::Attributes::position);
    draw(alpha, gpuscene::Bucket::alphaTested, gpuscene::Attributes::positionUv);
}

void countMapFragments(const gpuscene::GpuScene& scene, const gpuscene::DrawList& list, const gl::Program& opaque, const gl::Program& alpha, measure::Ledger& tally) {
    if (!tally.counters) return;
    GLint depthFunc = GL_LESS;
    glGetIntegerv(GL_DEPTH_FUNC, &depthFunc);
    glDepthFunc(GL_ALWAYS);
    glDepthMask(GL_FALSE);
    tally.mapFragments += tally.counters->aside([&] {
        measure::Ledger ignored;
        drawCasters(scene, list, opaque, alpha, ignored);
    });
    glDepthMask(GL_TRUE);
    glDepthFunc(GLenum(depthFunc));
}

void countMapTexels(const gl::Texture& map, int layer, int x, int y, int side, measure::Ledger& tally) {
    if (!tally.counters) return;
    std::vector<float> depths(size_t(side) * size_t(side));
    glGetTextureSubImage(map.name(), 0, x, y, layer, side, side, 1, GL_DEPTH_COMPONENT, GL_FLOAT, GLsizei(depths.size() * sizeof(float)), depths.data());
    tally.mapTexelsFilled += size_t(std::ranges::count_if(depths, [](float depth) { return depth < 1; }));
}

std::unique_ptr<Technique> makeTechnique(frame::Frame& frame, const TechniqueInfo& info, const Settings& settings) {
    if (info.family == "map") return makeMap(frame, settings);
    if (info.family == "instanced") return makeInstanced(frame, settings);
    if (info.family == "volume") return makeVolume(frame, settings);
    throw std::logic_error("no maker for family " + info.family);
}

}  // namespace dapple::shadow
