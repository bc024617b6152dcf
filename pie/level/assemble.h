#pragma once
// The steps that make a Level out of a Bsp, in the order in which loadLevel takes them. Each fills its own part of the
// Level and reads only what the steps before it have filled.

#include "pie/level/bsp.h"
#include "pie/level/level.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pie::level {

struct AssemblyInput {
    const Bsp& bsp;
    const ShaderLibrary& shaders;
    const LoadOptions& options;
};

/// Entities of the BSP, and the light entities of the BSP or of the .map beside it.
[[nodiscard]] std::optional<Error> addEntities(Level& level, const Bsp& bsp, const std::string& levelName);
void addTree(Level& level, const Bsp& bsp);
void addModels(Level& level, const Bsp& bsp);
void addFogs(Level& level, const Bsp& bsp, const ShaderLibrary& shaders);
/// Shaders that surfaces use, vertices, triangles and the counts of both. `lightmaps` of the surfaces are those of the
/// file here; `addLightmaps` makes them indices into Level::lightmaps.
[[nodiscard]] std::optional<Error> addSurfaces(Level& level, const AssemblyInput& input);
void addLightmaps(Level& level, const AssemblyInput& input);
/// Names every picture and decodes those that a used shader needs.
void addTextures(Level& level, const LoadOptions& options);
void addDrawnStatistics(Level& level);

/// Whether free-for-all shows the model of this entity: it is of a class that has one and not kept for other games.
[[nodiscard]] bool showsItsModel(const Entity& entity);

} // namespace pie::level
