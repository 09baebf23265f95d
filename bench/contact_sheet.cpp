#include "bench/contact_sheet.h"

#include "gl/context.h"
#include "scenegen/texture_size.h"
#include "shadow/renderer.h"

#include <algorithm>
#include <cmath>

namespace dapple::bench {
namespace {
constexpr int kWidth = 640, kHeight = 480;
constexpr size_t kMostViews = 16;
}  // namespace

void writeContactSheet(scenegen::Scene scene, int device, const std::filesystem::path& file) {
    const gl::Context context = gl::Context::headless(device);
    scenegen::fitTextures(scene, gl::identify().maxTextureSize);
    const gpuscene::GpuScene gpu(scene);
    const int count = int(std::min(scene.views.size(), kMostViews)), columns = int(std::ceil(std::sqrt(double(count)))), rows = (count + columns - 1) / columns;
    base::Image8 sheet{columns * kWidth, rows * kHeight, 3, std::vector<uint8_t>(size_t(columns * kWidth) * size_t(rows * kHeight) * 3, 255)};
    frame::Frame frame(gpu, scene.views.front(), kWidth, kHeight);
    shadow::Settings settings = shadow::technique("cascaded").defaults;
    settings["size"] = "2048";
    shadow::Renderer renderer(frame, shadow::technique("cascaded"), settings);
    for (int i = 0; i < count; ++i) {
        frame.look(scene.views[size_t(i)]);
        frame::PassObserver silent;
        renderer.render(silent);
        const base::Image8 picture = frame.readShaded();
        for (int y = 0; y < kHeight; ++y)
            std::copy_n(picture.at(0, y), size_t(kWidth) * 3, sheet.at(i % columns * kWidth, i / columns * kHeight + y));
    }
    base::writePng(file, sheet);
}

}  // namespace dapple::bench
