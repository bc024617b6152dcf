#pragma once
// Compiles and links GLSL in a real OpenGL context.

#include <osg/GraphicsContext>
#include <osg/Node>

#include <string>
#include <vector>

namespace pie::test {

class LinkCheck {
public:
    LinkCheck();
    ~LinkCheck();
    LinkCheck(const LinkCheck&) = delete;
    LinkCheck& operator=(const LinkCheck&) = delete;
    /// False where there is no OpenGL.
    [[nodiscard]] bool ready() const { return context_.valid(); }
    /// What the compiler or linker says; empty when the program links.
    [[nodiscard]] std::string fault(const std::string& vertexSource, const std::string& fragmentSource);
    /// Programs below the node that were met, each once; faults are added to `faults` as "name: log".
    std::size_t check(osg::Node& node, std::vector<std::string>& faults);

private:
    osg::ref_ptr<osg::GraphicsContext> context_;
};

} // namespace pie::test
