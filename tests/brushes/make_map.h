#pragma once
// Map text made by tests, brush by brush.

#include "pie/brushes/brush.h"
#include "pie/brushes/load.h"
#include "pie/photons/tracer.h"

#include <glm/mat3x3.hpp>

#include <string>
#include <vector>

namespace pie::test {

/// A face of plain Quake 3 form: the plane with this outward normal through this point.
[[nodiscard]] std::string faceText(const glm::dvec3& normal, const glm::dvec3& point,
                                   const std::string& shader = "t/wall");
/// Six faces, turned by `rotation` about the origin, then moved.
[[nodiscard]] std::string boxText(const glm::dvec3& lower, const glm::dvec3& upper,
                                  const std::string& shader = "t/wall", const glm::dmat3& rotation = glm::dmat3(1),
                                  const glm::dvec3& offset = glm::dvec3(0));
/// Six walls, `thick` units, around the box; sealed at the corners.
[[nodiscard]] std::string roomText(const glm::dvec3& lower, const glm::dvec3& upper, double thick = 16,
                                   const std::string& shader = "t/wall");
[[nodiscard]] std::string entityText(const std::vector<std::pair<std::string, std::string>>& pairs,
                                     const std::string& brushes = "");
/// worldspawn with these brushes, a player start and a light at `inside`.
[[nodiscard]] std::string levelText(const std::string& brushes, const glm::dvec3& inside);

[[nodiscard]] level::Location mapInMemory(const std::string& text,
                                          std::vector<std::pair<std::string, std::string>> files = {});
[[nodiscard]] Result<level::Level> loadMapText(const std::string& text,
                                               std::vector<std::pair<std::string, std::string>> files = {});

/// Photons of the level's own lights, traced with default settings.
[[nodiscard]] photons::TraceCounts traceLevel(const level::Level& level, std::uint64_t count);

} // namespace pie::test
