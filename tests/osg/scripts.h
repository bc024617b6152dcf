#pragma once
// Shader scripts that between them use everything a stage can do, and the looks they can be drawn in.

#include "osgPlugins/osgpie/material_program.h"

#include <string>
#include <vector>

namespace pie::test {

/// The shader "t/x" with this body.
[[nodiscard]] level::Shader parseScript(const std::string& body);
/// Bodies of scripts.
[[nodiscard]] std::vector<std::string> scriptCollection();
/// Every combination of light, textures, blending, colour space, time and fog.
[[nodiscard]] std::vector<osgpie::Look> allLooks();

} // namespace pie::test
