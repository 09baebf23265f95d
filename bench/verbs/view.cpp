#include "base/error.h"
#include "bench/gl_workbench.h"
#include "bench/stress.h"
#include "bench/verbs/point_options.h"
#include "bench/verbs/verbs.h"

#include "scenegen/texture_size.h"

#include <fmt/format.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>

namespace dapple::bench {
namespace {

constexpr const char* kKeys = "W A S D Q E move, drag turns, N/P technique, Tab view, Esc quits";
constexpr double kTap = 0.05;  ///< seconds that a key counts as held which went down and up between two frames

/// What keys and mouse ask for. Key presses are collected by a callback: one that lies between two slow frames is not
/// lost.
class Input {
public:
    explicit Input(GLFWwindow* window) : window_(window) {
        glfwSetWindowUserPointer(window, this);
        glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
            if (action == GLFW_PRESS) static_cast<Input*>(glfwGetWindowUserPointer(w))->pressed_.push_back(key);
        });
        glfwGetCursorPos(window, &cursor_.x, &cursor_.y);
    }
    Input(const Input&) = delete;
    Input& operator=(const Input&) = delete;

    /// Takes in what has happened since the last frame, which took so many seconds.
    void poll(double seconds) {
        pressed_.clear();
        glfwPollEvents();
        seconds_ = seconds;
        glm::dvec2 now;
        glfwGetCursorPos(window_, &now.x, &now.y);
        const bool drags = glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
        dragged_ = drags ? now - cursor_ : glm::dvec2(0);
        cursor_ = now;
    }
    int taps(int key) const { return int(std::ranges::count(pressed_, key)); }

    /// Flies `view` as asked; true if it moved.
    bool fly(scenegen::View& view) const {
        const scenegen::View before = view;
        const glm::dvec3 right = glm::normalize(glm::cross(view.forward, {0, 0, 1}));
        const double speed = held(GLFW_KEY_LEFT_SHIFT) > 0 ? 30 : 6;  // metres per second
        view.eye += speed * (view.forward * (held(GLFW_KEY_W) - held(GLFW_KEY_S)) +
                             right * (held(GLFW_KEY_D) - held(GLFW_KEY_A)) +
                             glm::dvec3(0, 0, 1) * (held(GLFW_KEY_E) - held(GLFW_KEY_Q)));
        if (dragged_ != glm::dvec2(0)) {
            const double yaw = std::atan2(view.forward.y, view.forward.x) - 0.004 * dragged_.x;
            const double pitch =
                std::clamp(std::asin(std::clamp(view.forward.z, -1.0, 1.0)) - 0.004 * dragged_.y, -1.5, 1.5);
            view.forward = {std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), std::sin(pitch)};
            view.up = {0, 0, 1};
        }
        return view.eye != before.eye || view.forward != before.forward;
    }

private:
    /// Seconds of the last frame in which the key was down.
    double held(int key) const { return glfwGetKey(window_, key) == GLFW_PRESS ? seconds_ : kTap * taps(key); }

    GLFWwindow* window_;
    std::vector<int> pressed_;
    double seconds_ = 0;
    glm::dvec2 cursor_{0}, dragged_{0};
};

/// The techniques that the scene can have, each with those of the settings on the command line that it knows.
std::vector<std::pair<shadow::TechniqueInfo, shadow::Settings>> choices(const scenegen::Scene& scene,
                                                                        const PointSpec& first,
                                                                        const shadow::Settings& asked) {
    std::vector<std::pair<shadow::TechniqueInfo, shadow::Settings>> found;
    for (const shadow::TechniqueInfo& info : shadow::techniques()) {
        shadow::Settings own = asked;
        std::erase_if(own, [&](const auto& setting) { return !info.defaults.contains(setting.first); });
        own = shadow::resolve(info, own);
        const auto reason = shadow::pruneReason(info, own, scene.facts(), {});
        if (reason && info.name == first.technique) throw base::UsageError(fmt::format("{}: {}", info.name, *reason));
        if (!reason) found.emplace_back(info, own);
    }
    return found;
}

/// Shows a picture in the window as large as it fits, with black beside it where the window has another aspect.
void present(GLFWwindow* window, GLuint source, int width, int height) {
    int w = 0, h = 0;
    glfwGetFramebufferSize(window, &w, &h);
    const double scale = std::min(double(w) / width, double(h) / height);
    const int shownW = int(std::lround(scale * width)), shownH = int(std::lround(scale * height)), x = (w - shownW) / 2,
              y = (h - shownH) / 2;
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glDisable(GL_SCISSOR_TEST);
    const float black[4] = {0, 0, 0, 1};
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearBufferfv(GL_COLOR, 0, black);
    glBlitNamedFramebuffer(source, 0, 0, 0, width, height, x, y, x + shownW, y + shownH, GL_COLOR_BUFFER_BIT,
                           GL_LINEAR);
    glfwSwapBuffers(window);
}

void show(const PointOptions& options, int frames) {
    const PointSpec spec = options.spec();
    scenegen::Scene scene = loadScene(spec.scene, spec.sceneSettings, spec.stressCase);
    size_t named = spec.view.empty() ? 0 : scene.viewIndex(spec.view);
    const auto all = choices(scene, spec, options.overrides());
    size_t technique = 0;
    while (all[technique].first.name != spec.technique) ++technique;
    const gl::Context context = gl::Context::window(spec.width, spec.height, "dapple view");
    GLFWwindow* window = context.handle();
    glfwSwapInterval(1);

    scenegen::fitTextures(scene, gl::identify().maxTextureSize);
    const gpuscene::GpuScene gpu(scene);
    scenegen::View view = scene.views[named];
    frame::Frame frame(gpu, view, spec.width, spec.height);
    std::unique_ptr<shadow::Renderer> renderer;
    GLuint source = 0;
    glCreateFramebuffers(1, &source);
    glNamedFramebufferTexture(source, GL_COLOR_ATTACHMENT0, frame.shaded().name(), 0);
    frame::PassObserver silent;
    Input input(window);
    double last = glfwGetTime();
    for (int drawn = 0; !glfwWindowShouldClose(window) && (frames == 0 || drawn < frames); ++drawn) {
        const double now = glfwGetTime(), seconds = now - std::exchange(last, now);
        input.poll(seconds);
        if (input.taps(GLFW_KEY_ESCAPE) > 0) break;
        bool moved = input.fly(view);
        if (const int taps = input.taps(GLFW_KEY_TAB); taps > 0) {
            view = scene.views[named = (named + size_t(taps)) % scene.views.size()];
            moved = true;
        }
        if (moved) frame.look(view);
        const int step = input.taps(GLFW_KEY_N) - input.taps(GLFW_KEY_P), count = int(all.size());
        if (!renderer || step != 0) {
            technique = size_t(((int(technique) + step) % count + count) % count);
            renderer.reset();  // its maps go before the next one's come
            renderer = std::make_unique<shadow::Renderer>(frame, all[technique].first, all[technique].second);
        } else if (moved) {
            renderer->replan();
        }
        renderer->render(silent);
        present(window, source, spec.width, spec.height);
        glfwSetWindowTitle(window, fmt::format("{} | {} | {} | {:.1f} ms with swap | {}", scene.name,
                                               all[technique].first.name, scene.views[named].name, 1e3 * seconds, kKeys)
                                       .c_str());
    }
    glDeleteFramebuffers(1, &source);
    gl::checkErrors("the window's frames");
}

}  // namespace

void addView(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("view", fmt::format("Look around in a window: {}", kKeys));
    auto options = std::make_shared<PointOptions>();
    options->scene = "forest-small";
    options->technique = "cascaded";
    options->resolution = "1280x800";
    options->addTo(*verb);
    auto frames = std::make_shared<int>(0);
    verb->add_option("--frames", *frames, "close after this many frames; 0: stay open")->capture_default_str();
    verb->footer(
        "Examples:\n  dapple view\n  dapple view forest-105 instanced -a size=1024 --view walk1\n  dapple view "
        "city-vienna -s scale=0.1 -r 800x600");
    verb->callback([&app, options, frames] {
        requireGl(globalOptions(app), "view");
        show(*options, *frames);
    });
}

}  // namespace dapple::bench
