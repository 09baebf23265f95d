#include "base/error.h"
#include "bench/gl_workbench.h"
#include "bench/stress.h"
#include "bench/verbs/verbs.h"
#include "scenegen/library.h"

#include <fmt/format.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>

namespace dapple::bench {
namespace {

constexpr const char* kKeys = "W A S D Q E move, drag turns, N/P technique, Tab view, Esc quits";

/// Flies `view` for `seconds` as keys and mouse ask; true if it moved.
bool fly(GLFWwindow* window, scenegen::View& view, double seconds, glm::dvec2& cursor) {
    const scenegen::View before = view;
    const auto pressed = [&](int key) { return glfwGetKey(window, key) == GLFW_PRESS ? 1.0 : 0.0; };
    const glm::dvec3 right = glm::normalize(glm::cross(view.forward, {0, 0, 1}));
    const double speed = seconds * (pressed(GLFW_KEY_LEFT_SHIFT) > 0 ? 30 : 6);
    view.eye += speed * (view.forward * (pressed(GLFW_KEY_W) - pressed(GLFW_KEY_S)) + right * (pressed(GLFW_KEY_D) - pressed(GLFW_KEY_A)) +
                         glm::dvec3(0, 0, 1) * (pressed(GLFW_KEY_E) - pressed(GLFW_KEY_Q)));
    glm::dvec2 now;
    glfwGetCursorPos(window, &now.x, &now.y);
    if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS) {
        const double yaw = std::atan2(view.forward.y, view.forward.x) - 0.004 * (now.x - cursor.x);
        const double pitch = std::clamp(std::asin(std::clamp(view.forward.z, -1.0, 1.0)) - 0.004 * (now.y - cursor.y), -1.5, 1.5);
        view.forward = {std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), std::sin(pitch)};
        view.up = {0, 0, 1};
    }
    cursor = now;
    return view.eye != before.eye || view.forward != before.forward;
}

/// True in the frame in which the key goes down.
bool tapped(GLFWwindow* window, int key, bool& held) {
    const bool down = glfwGetKey(window, key) == GLFW_PRESS;
    return std::exchange(held, down) != down && down;
}

void show(const std::string& sceneName, const std::string& firstTechnique, int frames) {
    constexpr int kWidth = 1280, kHeight = 800;
    const scenegen::Scene scene = scenegen::loadScene(sceneName);
    const auto refusal = [facts = scene.facts()](const shadow::TechniqueInfo& info) { return shadow::pruneReason(info, info.defaults, facts, {}); };
    if (const auto reason = refusal(shadow::technique(firstTechnique))) throw base::UsageError(fmt::format("{}: {}", firstTechnique, *reason));
    std::vector<shadow::TechniqueInfo> all;
    std::ranges::copy_if(shadow::techniques(), std::back_inserter(all), [&](const auto& info) { return !refusal(info); });
    size_t technique = 0;
    while (all[technique].name != firstTechnique) ++technique;
    const gl::Context context = gl::Context::window(kWidth, kHeight, "dapple view");
    GLFWwindow* window = context.handle();
    glfwSwapInterval(1);

    const gpuscene::GpuScene gpu(scene);
    scenegen::View view = scene.views.front();
    frame::Frame frame(gpu, view, kWidth, kHeight);
    auto renderer = std::make_unique<shadow::Renderer>(frame, all[technique], all[technique].defaults);
    GLuint source = 0;
    glCreateFramebuffers(1, &source);
    glNamedFramebufferTexture(source, GL_COLOR_ATTACHMENT0, frame.shaded().name(), 0);
    frame::PassObserver silent;
    bool next = false, previous = false, tab = false;
    size_t named = 0;
    glm::dvec2 cursor(0);
    double last = glfwGetTime();
    for (int drawn = 0; !glfwWindowShouldClose(window) && (frames == 0 || drawn < frames); ++drawn) {
        glfwPollEvents();
        if (glfwGetKey(window, GLFW_KEY_ESCAPE) == GLFW_PRESS) break;
        const double now = glfwGetTime(), seconds = now - std::exchange(last, now);
        bool moved = fly(window, view, seconds, cursor);
        if (tapped(window, GLFW_KEY_TAB, tab)) {
            view = scene.views[named = (named + 1) % scene.views.size()];
            moved = true;
        }
        if (moved) {
            frame.look(view);
            renderer->replan();
        }
        const int step = int(tapped(window, GLFW_KEY_N, next)) - int(tapped(window, GLFW_KEY_P, previous));
        if (step != 0) {
            technique = (technique + all.size() + size_t(step)) % all.size();
            renderer.reset();  // its maps go before the next one's come
            renderer = std::make_unique<shadow::Renderer>(frame, all[technique], all[technique].defaults);
        }
        renderer->render(silent);
        int w = 0, h = 0;
        glfwGetFramebufferSize(window, &w, &h);
        glBlitNamedFramebuffer(source, 0, 0, 0, kWidth, kHeight, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_LINEAR);
        glfwSwapBuffers(window);
        glfwSetWindowTitle(window, fmt::format("{} | {} | {:.1f} ms with swap | {}", scene.name, all[technique].name, 1e3 * seconds, kKeys).c_str());
    }
    glDeleteFramebuffers(1, &source);
    gl::checkErrors("the window's frames");
}

}  // namespace

void addView(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("view", fmt::format("Look around in a window: {}", kKeys));
    auto scene = std::make_shared<std::string>("forest-small");
    auto technique = std::make_shared<std::string>("cascaded");
    auto frames = std::make_shared<int>(0);
    verb->add_option("scene", *scene, "name of a scene or a file")->capture_default_str();
    verb->add_option("technique", *technique, "technique to begin with")->capture_default_str();
    verb->add_option("--frames", *frames, "close after this many frames; 0: stay open")->capture_default_str();
    verb->footer("Examples:\n  dapple view\n  dapple view forest-105 instanced");
    verb->callback([scene, technique, frames] { show(*scene, *technique, *frames); });
}

}  // namespace dapple::bench
