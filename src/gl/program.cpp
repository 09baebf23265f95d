#include "gl/program.h"

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "gl/address_space.h"

#include <fmt/format.h>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>

namespace dapple::gl {
namespace fs = std::filesystem;
namespace {

struct Source {
    std::string text;
    std::vector<std::string> files;  // index = GLSL source-string number in #line
};

/// Appends `file` with its includes expanded, each once, and #line directives that keep the log's lines true.
void append(Source& source, const std::string& file) {
    if (std::find(source.files.begin(), source.files.end(), file) != source.files.end()) return;
    const size_t number = source.files.size();
    source.files.push_back(file);
    std::istringstream in(base::readFile(base::homeFolder() / "shaders" / file));
    source.text += fmt::format("#line 1 {}\n", number);
    int lineNumber = 0;
    for (std::string line; std::getline(in, line);) {
        ++lineNumber;
        if (line.starts_with("#include \"")) {
            append(source, line.substr(10, line.rfind('"') - 10));
            source.text += fmt::format("#line {} {}\n", lineNumber + 1, number);
        } else {
            source.text += line + '\n';
        }
    }
}

/// The driver's log as one line, its source-string numbers ("1:3(7): " of Mesa, "1(3) : " of NVIDIA) as file and line.
std::string readableLog(const std::string& log, const std::vector<std::string>& files) {
    static const std::regex kPlace(R"(^(\d+)(?::(\d+)\(\d+\)|\((\d+)\)) ?: ?)");
    std::string result;
    std::istringstream in(log);
    for (std::string line; std::getline(in, line);) {
        if (line.empty()) continue;
        if (!result.empty()) result += "; ";
        std::smatch match;
        if (std::regex_search(line, match, kPlace) && std::stoul(match[1]) < files.size()) {
            result += fmt::format("shaders/{}:{}: ", files[std::stoul(match[1])], match[2].matched ? match[2].str() : match[3].str());
            line = match.suffix();
        }
        result += line;
    }
    return result;
}

/// The driver's log of a shader or a program; `get` is glGetShaderInfoLog or glGetProgramInfoLog.
std::string infoLog(void (*get)(GLuint, GLsizei, GLsizei*, GLchar*), GLuint name) {
    std::string log(4096, '\0');
    GLsizei length = 0;
    get(name, GLsizei(log.size()), &length, log.data());
    log.resize(size_t(length));
    return log;
}

GLuint compile(GLenum stage, const std::string& file, const std::vector<std::string>& defines) {
    Source source{"#version 450 core\n", {}};
    for (const std::string& define : defines) source.text += "#define " + define + '\n';
    append(source, file);
    const GLuint shader = glCreateShader(stage);
    const char* text = source.text.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint ok = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        const std::string log = infoLog(glGetShaderInfoLog, shader);
        glDeleteShader(shader);
        throw base::UsageError(fmt::format("shaders/{} does not compile: {}", file, readableLog(log, source.files)));
    }
    return shader;
}

}  // namespace

void deleteProgram(GLuint name) { if (!leaveObjects()) glDeleteProgram(name); }

Program::Program(const std::string& vertex, const std::string& fragment, const std::vector<std::string>& defines)
    : Program({{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}}, defines) {}

Program Program::compute(const std::string& file, const std::vector<std::string>& defines) {
    return Program({{GL_COMPUTE_SHADER, file}}, defines);
}

Program::Program(std::initializer_list<Stage> stages, const std::vector<std::string>& defines) {
    const GLuint program = glCreateProgram();
    handle_ = Handle<deleteProgram>(program);
    std::string names;
    for (const auto& [stage, file] : stages) {
        if (file.empty()) continue;
        const GLuint shader = compile(stage, file, defines);
        glAttachShader(program, shader);
        glDeleteShader(shader);  // freed with the program
        names += (names.empty() ? "shaders/" : " and shaders/") + file;
    }
    glLinkProgram(program);
    GLint ok = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    if (!ok) throw base::UsageError(fmt::format("{} do not link: {}", names, readableLog(infoLog(glGetProgramInfoLog, program), {})));
}

void Program::set(const char* u, int v) const { glProgramUniform1i(name(), location(u), v); }
void Program::set(const char* u, float v) const { glProgramUniform1f(name(), location(u), v); }
void Program::set(const char* u, const glm::vec2& v) const { glProgramUniform2fv(name(), location(u), 1, glm::value_ptr(v)); }
void Program::set(const char* u, const glm::vec3& v) const { glProgramUniform3fv(name(), location(u), 1, glm::value_ptr(v)); }
void Program::set(const char* u, const glm::dvec3& v) const { glProgramUniform3dv(name(), location(u), 1, glm::value_ptr(v)); }
void Program::set(const char* u, const glm::vec4& v) const { glProgramUniform4fv(name(), location(u), 1, glm::value_ptr(v)); }
void Program::set(const char* u, const glm::mat4& v) const {
    glProgramUniformMatrix4fv(name(), location(u), 1, GL_FALSE, glm::value_ptr(v));
}
void Program::set(const char* u, std::span<const glm::mat4> v) const {
    if (!v.empty()) glProgramUniformMatrix4fv(name(), location(u), GLsizei(v.size()), GL_FALSE, glm::value_ptr(v[0]));
}
void Program::set(const char* u, std::span<const glm::vec4> v) const {
    if (!v.empty()) glProgramUniform4fv(name(), location(u), GLsizei(v.size()), glm::value_ptr(v[0]));
}

uint64_t shaderTreeHash() {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(base::homeFolder() / "shaders"))
        if (entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    base::Hasher hasher;
    for (const fs::path& file : files) hasher.text(base::readFile(file));
    return hasher.digest();
}

}  // namespace dapple::gl
