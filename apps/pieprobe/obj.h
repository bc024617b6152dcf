#pragma once
// A Wavefront .obj as a scene: Kd of its materials is the diffuse reflectance.

#include "pie/core/result.h"
#include "pie/scene/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace pieprobe {

struct ObjOptions {
    float maxReflectance = 0.95F; ///< larger Kd count as this, with a warning
    bool twoSided = false;        ///< all surfaces reflect and receive on both sides
};
struct ObjScene {
    pie::scene::Scene scene;
    std::vector<std::string> warnings; ///< one line each
};
/// Polygons become triangles, fronts are counter-clockwise. Materials whose name starts with "sky" are sky surfaces;
/// faces without material reflect half. Damaged files are an error.
[[nodiscard]] pie::Result<ObjScene> readObj(const std::filesystem::path& file, const ObjOptions& options);

} // namespace pieprobe
