#include "tests/brushes/make_map.h"

#include "pie/intersect/intersectors.h"
#include "pie/lights/import.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <cmath>

namespace pie::test {

std::string faceText(const glm::dvec3& normal, const glm::dvec3& point, const std::string& shader) {
    const glm::dvec3 n = glm::normalize(normal);
    const glm::dvec3 other = std::abs(n.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(other, n)) * 64.0;
    const glm::dvec3 v = glm::cross(n, u);
    // normal = (p0 - p1) x (p2 - p1)
    const auto triple = [](const glm::dvec3& p) { return fmt::format("( {:.17g} {:.17g} {:.17g} ) ", p.x, p.y, p.z); };
    return triple(point + u) + triple(point) + triple(point + v) + shader + " 0 0 0 0.5 0.5 0 0 0\n";
}

std::string boxText(const glm::dvec3& lower, const glm::dvec3& upper, const std::string& shader,
                    const glm::dmat3& rotation, const glm::dvec3& offset) {
    std::string text = "{\n";
    for (int axis = 0; axis < 3; ++axis)
        for (const bool high : {false, true}) {
            glm::dvec3 normal(0);
            normal[axis] = high ? 1 : -1;
            text += faceText(rotation * normal, rotation * (high ? upper : lower) + offset, shader);
        }
    return text + "}\n";
}

std::string roomText(const glm::dvec3& lower, const glm::dvec3& upper, double thick, const std::string& shader) {
    std::string text;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 low = lower - thick;
        glm::dvec3 high = upper + thick;
        low[axis] = upper[axis];
        text += boxText(low, high, shader);
        low[axis] = lower[axis] - thick;
        high[axis] = lower[axis];
        text += boxText(low, high, shader);
    }
    return text;
}

std::string entityText(const std::vector<std::pair<std::string, std::string>>& pairs, const std::string& brushes) {
    std::string text = "{\n";
    for (const auto& [key, value] : pairs) text += fmt::format("\"{}\" \"{}\"\n", key, value);
    return text + brushes + "}\n";
}

std::string levelText(const std::string& brushes, const glm::dvec3& inside) {
    const std::string at = fmt::format("{} {} {}", inside.x, inside.y, inside.z);
    return entityText({{"classname", "worldspawn"}}, brushes) +
           entityText({{"classname", "info_player_start"}, {"origin", at}}) +
           entityText({{"classname", "light"}, {"origin", at}, {"light", "300"}});
}

level::Location mapInMemory(const std::string& text, std::vector<std::pair<std::string, std::string>> files) {
    files.emplace_back("maps/made.map", text);
    std::vector<std::pair<std::string, level::Bytes>> stored;
    for (const auto& [name, content] : files) {
        const auto* first = reinterpret_cast<const std::byte*>(content.data());
        stored.emplace_back(name, level::Bytes(first, first + content.size()));
    }
    level::Location location;
    location.files.mountMemory("memory", std::move(stored));
    location.name = "maps/made.map";
    return location;
}

Result<level::Level> loadMapText(const std::string& text, std::vector<std::pair<std::string, std::string>> files) {
    return brushes::loadLevel(mapInMemory(text, std::move(files)));
}

photons::TraceCounts traceLevel(const level::Level& level, std::uint64_t count) {
    const auto scene = std::make_shared<const scene::Scene>(scene::makeScene(level));
    const lights::LightSet lights(lights::importLights(level, *scene).lights, scene);
    const auto intersector = intersect::makeIntersector(intersect::Kind::Embree, *scene, level.tree);
    const photons::PhotonTracer tracer(*scene, lights, *intersector, {});
    std::vector<photons::Photon> photons;
    return tracer.trace(0, count, photons);
}

} // namespace pie::test
