#include "pie/brushes/model.h"

#include "pie/brushes/model_formats.h"
#include "pie/level/byte_reader.h"
#include "pie/level/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pie::brushes {
namespace {

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

void check(Model& model) {
    for (ModelSurface& surface : model) {
        for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
            ModelVertex& vertex = surface.vertices[i];
            if (!finite(vertex.position))
                throw level::Damage(fmt::format("surface {}, vertex {}", surface.shader, i),
                                    "a position is not finite");
            if (!finite(vertex.normal)) vertex.normal = glm::dvec3(0);
            if (!std::isfinite(vertex.texture.x) || !std::isfinite(vertex.texture.y)) vertex.texture = glm::dvec2(0);
        }
        for (std::size_t i = 0; i < surface.indices.size(); ++i)
            if (surface.indices[i] >= surface.vertices.size())
                throw level::Damage(fmt::format("surface {}, triangle {}", surface.shader, i / 3),
                                    fmt::format("names vertex {} of {}", surface.indices[i], surface.vertices.size()));
        std::replace(surface.shader.begin(), surface.shader.end(), '\\', '/');
        surface.shader = level::lower(level::withoutExtension(surface.shader));
    }
    std::erase_if(model, [](const ModelSurface& surface) { return surface.indices.empty(); });
}

} // namespace

Result<Model> readModel(std::span<const std::byte> bytes, const std::string& fileName, int frame) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    try {
        Model model;
        if (text.starts_with("IDP3"))
            model = readMd3(bytes, frame);
        else if (text.starts_with("*3DSMAX") || level::endsWithNoCase(fileName, ".ase"))
            model = readAse(text);
        else if (level::endsWithNoCase(fileName, ".obj"))
            model = readObj(text);
        else
            return Error{fileName, "", "is no model that is read here", "use .md3, .ase or .obj"};
        check(model);
        return model;
    } catch (const level::Damage& damage) {
        // Names in a damaged file may hold anything.
        std::string place = damage.place;
        std::string reason = damage.what();
        const auto isControl = [](char c) { return static_cast<unsigned char>(c) < ' '; };
        std::replace_if(place.begin(), place.end(), isControl, '?');
        std::replace_if(reason.begin(), reason.end(), isControl, '?');
        return Error{fileName, place, reason, ""};
    }
}

} // namespace pie::brushes
