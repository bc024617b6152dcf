#include "pie/brushes/map_parts.h"

#include "pie/level/names.h"

#include <fmt/format.h>

#include <utility>

namespace pie::brushes {
namespace {

/// What the shaders of its faces make of a brush.
void classify(Brush& brush, MapShaders& shaders) {
    brush.hides = true;
    // As in the level compiler the first side says whether a brush of several shaders keeps the void out.
    brush.structural = shaders[shaders.find(brush.text->faces.front().shader)].seals;
    constexpr std::int32_t detail = 0x8000000;
    for (Side& side : brush.sides) {
        const FaceText& text = brush.text->faces[side.face];
        side.shader = shaders.find(text.shader);
        const MapShader& shader = shaders[side.shader];
        brush.hides = brush.hides && shader.hides;
        brush.origin = brush.origin || shader.origin;
        brush.structural = brush.structural && (text.contents & detail) == 0 && shader.shader.parms.structural;
    }
    brush.hides = brush.hides || brush.structural;
}

} // namespace

Bounds boundsOf(const PatchText& patch) {
    Bounds bounds;
    for (const PatchText::Control& control : patch.controls) bounds.extend(control.position);
    return bounds;
}

Bounds Part::bounds() const {
    Bounds all;
    const auto add = [&](const Bounds& bounds) {
        all.extend(bounds.lower);
        all.extend(bounds.upper);
    };
    for (const Brush& brush : brushes) add(brush.bounds);
    for (const Curve& curve : patches) add(boundsOf(*curve.text));
    for (const Mesh& mesh : meshes) add(mesh.bounds);
    return all;
}

bool isGroup(const level::Entity& entity) { return level::equalNoCase(entity.className(), "func_group"); }

MapParts gatherParts(const MapText& map, const std::string& fileName, PlaneSet& planes, MapShaders& shaders,
                     std::vector<std::string>& warnings) {
    MapParts gathered;
    std::deque<Part>& parts = gathered.parts;
    const auto warn = [&](int line, const std::string& text) {
        warnings.push_back(fmt::format("{}: line {}: {}", fileName, line, text));
    };
    for (std::size_t i = 0; i < map.entities.size(); ++i) {
        const MapEntity& entity = map.entities[i];
        if (entity.brushes.empty() && entity.patches.empty()) continue;
        const bool ofWorld = level::equalNoCase(entity.entity.className(), "worldspawn") || isGroup(entity.entity);
        if (parts.empty()) {
            parts.emplace_back(); // the world, wherever it stands in the file
            if (!ofWorld) warn(entity.line, "a brush entity stands before worldspawn");
        }
        Part& part = ofWorld ? parts.front() : parts.emplace_back();
        part.entity = i;
        for (const BrushText& text : entity.brushes) {
            std::string reason;
            std::optional<Brush> brush = makeBrush(text, planes, reason);
            if (!brush) {
                warn(text.line, "the brush " + reason + "; it is left out");
                continue;
            }
            classify(*brush, shaders);
            ++gathered.brushes;
            part.brushes.push_back(std::move(*brush));
        }
        for (const PatchText& patch : entity.patches) part.patches.push_back({&patch, shaders.find(patch.shader)});
        gathered.patches += entity.patches.size();
        Bounds middle;
        for (const Brush& brush : part.brushes)
            if (brush.origin) middle.extend(brush.bounds.lower), middle.extend(brush.bounds.upper);
        if (!ofWorld) {
            if (!middle.empty())
                part.origin = 0.5 * (middle.lower + middle.upper);
            else if (const std::optional<Vec3> given = entity.entity.vector("origin"))
                part.origin = glm::dvec3(*given); // its brushes stand where the text says; the game adds this
        }
        std::erase_if(part.brushes, [](const Brush& brush) { return brush.origin; });
    }
    return gathered;
}

} // namespace pie::brushes
