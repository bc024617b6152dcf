#pragma once
// GLSL of programs that hold every view (Look::switchable): the uniforms pieView (a number of pie::engine::View),
// pieSplit (place of the divider, −1 left to 1 right) and pieExposure choose, ViewSwitch sets them. The vertex colour
// is our irradiance over the overbright range at an exposure of 1, or in View::Samples the colour to show; the
// secondary colour is the level's own light of the vertex over the same range.
//
// Defined for the rest of the program are
//   bool textured()             whether the view shows pictures, fog and glow
//   vec4 plain(vec4)            a texel, white where the view shows none
//   vec3 lightOf(vec3 baked)    the light to show, given what the level has baked
//   vec3 light()                the same on vertex-lit stages
//   vec3 ours()                 our light
//   vec3 looked(vec3, vec3 baked, bool lit)   the surface's colour in views that look inside; others leave it

#include <string>

namespace osgpie {

extern const char* const viewVaryings;
/// Ends the vertex shader's main().
extern const char* const viewVertexCode;
/// Behind the varyings of the fragment shader.
[[nodiscard]] std::string viewLight(float overbright);

} // namespace osgpie
