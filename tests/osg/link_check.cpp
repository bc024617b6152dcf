#include "tests/osg/link_check.h"

#include "tests/osg/offscreen.h"
#include "tests/osg/scene_reading.h"

#include <osg/GLExtensions>
#include <osg/Program>

#include <array>
#include <set>

namespace pie::test {
namespace {

std::string shaderLog(const osg::GLExtensions& gl, GLuint shader) {
    std::array<char, 4096> log{};
    gl.glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    return log.data();
}

/// A compiled shader, or 0 and the compiler's words.
GLuint compile(const osg::GLExtensions& gl, GLenum kind, const std::string& source, std::string& log) {
    const GLuint shader = gl.glCreateShader(kind);
    const char* text = source.c_str();
    gl.glShaderSource(shader, 1, &text, nullptr);
    gl.glCompileShader(shader);
    GLint compiled = 0;
    gl.glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled != 0) return shader;
    log = "does not compile: " + shaderLog(gl, shader);
    gl.glDeleteShader(shader);
    return 0;
}

std::string sourceOf(const osg::Program& program, osg::Shader::Type type) {
    for (unsigned i = 0; i < program.getNumShaders(); ++i)
        if (program.getShader(i)->getType() == type) return program.getShader(i)->getShaderSource();
    return {};
}

} // namespace

LinkCheck::LinkCheck() : context_(makeContext(16, 16)) {
    if (context_ && !(context_->realize() && context_->makeCurrent())) context_ = nullptr;
    if (context_) context_->getState()->initializeExtensionProcs();
}

LinkCheck::~LinkCheck() {
    if (!context_) return;
    context_->releaseContext();
    context_->close();
}

std::string LinkCheck::fault(const std::string& vertexSource, const std::string& fragmentSource) {
    const osg::GLExtensions& gl = *context_->getState()->get<osg::GLExtensions>();
    std::string log;
    const GLuint vertex = compile(gl, GL_VERTEX_SHADER, vertexSource, log);
    const GLuint fragment = vertex != 0 ? compile(gl, GL_FRAGMENT_SHADER, fragmentSource, log) : 0;
    if (fragment != 0) {
        const GLuint program = gl.glCreateProgram();
        gl.glAttachShader(program, vertex);
        gl.glAttachShader(program, fragment);
        gl.glLinkProgram(program);
        GLint linked = 0;
        gl.glGetProgramiv(program, GL_LINK_STATUS, &linked);
        std::array<char, 4096> text{};
        gl.glGetProgramInfoLog(program, static_cast<GLsizei>(text.size()), nullptr, text.data());
        if (linked == 0) log = std::string("does not link: ") + text.data();
        gl.glDeleteProgram(program);
        gl.glDeleteShader(fragment);
    }
    if (vertex != 0) gl.glDeleteShader(vertex);
    return log;
}

std::size_t LinkCheck::check(osg::Node& node, std::vector<std::string>& faults) {
    std::set<const osg::Program*> seen;
    for (const auto& state : stateSetsOf(node)) {
        const auto* program = dynamic_cast<const osg::Program*>(state->getAttribute(osg::StateAttribute::PROGRAM));
        if (!program || !seen.insert(program).second) continue;
        const std::string log =
            fault(sourceOf(*program, osg::Shader::VERTEX), sourceOf(*program, osg::Shader::FRAGMENT));
        if (!log.empty()) faults.push_back(program->getName() + ": " + log);
    }
    return seen.size();
}

} // namespace pie::test
