#include "shadow/technique.h"

#include "shadow/families.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

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
        const gpuscene::DrawCount count = scene.draw(list, bucket, attributes, program.name());
        tally.drawCalls += count.draws;
        tally.trianglesSubmitted += count.triangles;
    };
    draw(opaque, gpuscene::Bucket::opaque, gpuscene::Attributes::position);
    draw(alpha, gpuscene::Bucket::alphaTested, gpuscene::Attributes::positionUv);
}

std::unique_ptr<Technique> makeTechnique(frame::Frame& frame, const TechniqueInfo& info, const Settings& settings) {
    if (info.family == "map") return makeMap(frame, settings);
    if (info.family == "instanced") return makeInstanced(frame, settings);
    if (info.family == "volume") return makeVolume(frame, settings);
    throw std::logic_error("no maker for family " + info.family);
}

}  // namespace dapple::shadow
