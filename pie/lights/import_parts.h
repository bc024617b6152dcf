#pragma once
// The parts of importLights, one per source file. Internal to this folder.

#include "pie/lights/import.h"

namespace pie::lights::detail {

/// Components above 1 stay; negative and non-finite ones become 0. White when nothing is left.
[[nodiscard]] Rgb normalised(const Rgb& colour);
/// sRGB to linear, per channel.
[[nodiscard]] Rgb linearised(const Rgb& colour);

/// Whether the entity is a light of the level.
[[nodiscard]] bool isLight(const level::Entity& entity);
/// Adds the one light of an entity that is one.
void importEntity(const level::Level& level, const level::Entity& entity, const ImportOptions& options,
                  ImportedLights& result);
void importEntities(const level::Level& level, const ImportOptions& options, ImportedLights& result);
void importShaders(const level::Level& level, const ImportOptions& options, ImportedLights& result);
void importFallback(const level::Level& level, const scene::Scene& scene, ImportedLights& result);

/// The surface's triangles as convex planar polygons, counter-clockwise from the front: one polygon where they fit
/// together to one, else pairs and single triangles. Triangles without area are left out.
[[nodiscard]] std::vector<std::vector<Vec3>> convexPolygons(const level::Level& level, const level::Surface& surface);

void warnOnce(ImportedLights& result, const std::string& text);

} // namespace pie::lights::detail
