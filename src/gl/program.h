#pragma once

#include "gl/objects.h"

#include <glm/glm.hpp>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace dapple::gl {

void deleteProgram(GLuint name);

/// A linked GLSL 4.50 program from files under shaders/. `#include "lib/x.glsl"` is resolved against
/// shaders/; `defines` ("ALPHA_TEST", "FILTER 2") become #define lines.
class Program {
public:
    Program() = default;
    /// Vertex and fragment stage; an empty `fragment` makes a depth-only program.
    /// Throws UsageError with file, line and the driver's log when a stage does not compile.
    Program(const std::string& vertex, const std::string& fragment, const std::vector<std::string>& defines = {});
    /// A compute shader alone. The same errors.
    static Program compute(const std::string& file, const std::vector<std::string>& defines = {});
    void use() const { glUseProgram(handle_.name()); }
    GLuint name() const { return handle_.name(); }

    // Uniforms by name; a name that the program does not use is ignored, as the compiler may drop it.
    void set(const char* uniform, int v) const;
    void set(const char* uniform, float v) const;
    void set(const char* uniform, const glm::vec2& v) const;
    void set(const char* uniform, const glm::vec3& v) const;
    void set(const char* uniform, const glm::dvec3& v) const;
    void set(const char* uniform, const glm::vec4& v) const;
    void set(const char* uniform, const glm::mat4& v) const;
    void set(const char* uniform, std::span<const glm::mat4> v) const;
    void set(const char* uniform, std::span<const glm::vec4> v) const;

private:
    using Stage = std::pair<GLenum, std::string>;
    Program(std::initializer_list<Stage> stages, const std::vector<std::string>& defines);
    GLint location(const char* uniform) const { return glGetUniformLocation(handle_.name(), uniform); }
    Handle<deleteProgram> handle_;
};

/// Hash of every shader's source under shaders/, for run.json.
uint64_t shaderTreeHash();

}  // namespace dapple::gl
