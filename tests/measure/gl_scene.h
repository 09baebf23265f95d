#pragma once

#include "gl/context.h"
#include "gl/objects.h"
#include "gl/program.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace dapple::measure {

/// A context, an R32F target of 1024 × 1024 and a program whose triangles come from gl_VertexID alone.
class GlScene : public ::testing::Test {
protected:
    static constexpr int kSize = 1024;

    GlScene() : context_(gl::Context::headless()), target_(GL_R32F, kSize, kSize), depth_(GL_DEPTH_COMPONENT32F, kSize, kSize) {
        const std::array<const gl::Texture*, 1> colours{&target_};
        framebuffer_ = gl::makeFramebuffer(colours, &depth_);
        vertexArray_ = gl::makeVertexArray();
        gl::resetState();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        glBindVertexArray(vertexArray_.name());
        glViewport(0, 0, kSize, kSize);
        glClear(GL_DEPTH_BUFFER_BIT);
    }
    ~GlScene() override { EXPECT_NO_THROW(gl::checkErrors("test")); }

    /// `vertex` and `fragment`: bodies of main().
    static gl::Handle<gl::deleteProgram> program(const std::string& vertex, const std::string& fragment) {
        gl::Handle<gl::deleteProgram> handle(glCreateProgram());
        const auto attach = [&](GLenum stage, const std::string& source) {
            const std::string whole = "#version 450 core\n" + source;
            const char* text = whole.c_str();
            const GLuint shader = glCreateShader(stage);
            glShaderSource(shader, 1, &text, nullptr);
            glCompileShader(shader);
            glAttachShader(handle.name(), shader);
            glDeleteShader(shader);
        };
        attach(GL_VERTEX_SHADER, "void main() {" + vertex + "}");
        attach(GL_FRAGMENT_SHADER, "layout(location = 0) out float value; void main() {" + fragment + "}");
        glLinkProgram(handle.name());
        GLint linked = GL_FALSE;
        glGetProgramiv(handle.name(), GL_LINK_STATUS, &linked);
        EXPECT_TRUE(linked);
        return handle;
    }
    /// Two triangles that cover the target exactly.
    static constexpr const char* kQuad =
        "vec2 c[6] = vec2[](vec2(0), vec2(1, 0), vec2(1), vec2(0), vec2(1), vec2(0, 1));"
        "gl_Position = vec4(c[gl_VertexID] * 2.0 - 1.0, 0.5, 1);";

    gl::Context context_;
    gl::Texture target_, depth_;
    gl::Framebuffer framebuffer_;
    gl::VertexArray vertexArray_;
};

}  // namespace dapple::measure
