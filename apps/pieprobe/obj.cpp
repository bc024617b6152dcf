#include "apps/pieprobe/obj.h"

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

namespace pieprobe {
namespace {

using pie::Error;
using pie::Result;
using pie::Rgb;
using pie::Vec3;

bool isSky(std::string name) {
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    return name.rfind("sky", 0) == 0;
}

void addLines(const std::string& text, std::vector<std::string>& lines) {
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);)
        if (!line.empty()) lines.push_back(line);
}

pie::scene::Material materialOf(const tinyobj::material_t& from, const ObjOptions& options,
                                std::vector<std::string>& warnings) {
    pie::scene::Material material;
    material.twoSided = options.twoSided;
    if (isSky(from.name)) {
        material.interaction = pie::scene::Interaction::Sky;
        material.reflectance = Rgb(0.0F);
        return material;
    }
    for (int c = 0; c < 3; ++c) {
        const float kd = from.diffuse[c];
        material.reflectance[c] = std::isfinite(kd) ? std::clamp(kd, 0.0F, options.maxReflectance) : 0.0F;
    }
    const Rgb given(from.diffuse[0], from.diffuse[1], from.diffuse[2]);
    if (material.reflectance != given)
        warnings.push_back(
            fmt::format("material {}: Kd {:g} {:g} {:g} counts as {:g} {:g} {:g} (max_reflectance is {:g})", from.name,
                        given.x, given.y, given.z, material.reflectance.x, material.reflectance.y,
                        material.reflectance.z, options.maxReflectance));
    if (from.emission[0] > 0 || from.emission[1] > 0 || from.emission[2] > 0)
        warnings.push_back(fmt::format("material {}: Ke is not read (lights: --light \"area …\")", from.name));
    return material;
}

} // namespace

Result<ObjScene> readObj(const std::filesystem::path& file, const ObjOptions& options) {
    const auto error = [&](const std::string& place, const std::string& reason) {
        return Error{file.string(), place, reason, ""};
    };
    if (!std::filesystem::is_regular_file(file)) return error("", "no such file");
    tinyobj::ObjReaderConfig config;
    config.vertex_color = false;
    tinyobj::ObjReader reader;
    if (!reader.ParseFromFile(file.string(), config)) {
        std::vector<std::string> lines;
        addLines(reader.Error(), lines);
        return error("", lines.empty() ? "is not a Wavefront .obj" : lines.front());
    }
    ObjScene result;
    addLines(reader.Warning(), result.warnings);
    std::vector<pie::scene::Material> materials;
    for (const tinyobj::material_t& material : reader.GetMaterials())
        materials.push_back(materialOf(material, options, result.warnings));
    const auto plain = static_cast<std::uint32_t>(materials.size());
    materials.emplace_back().twoSided = options.twoSided; // of faces without one
    const std::vector<float>& vertices = reader.GetAttrib().vertices;
    std::vector<Vec3> corners;
    std::vector<std::uint32_t> materialOf;
    std::size_t without = 0;
    for (const tinyobj::shape_t& shape : reader.GetShapes()) {
        for (std::size_t f = 0; f < shape.mesh.num_face_vertices.size(); ++f) {
            const int material = shape.mesh.material_ids[f];
            const bool known = material >= 0 && static_cast<std::size_t>(material) < plain;
            if (!known) ++without;
            materialOf.push_back(known ? static_cast<std::uint32_t>(material) : plain);
            for (std::size_t i = 3 * f; i < 3 * f + 3; ++i) {
                const int vertex = shape.mesh.indices[i].vertex_index;
                const auto at = static_cast<std::size_t>(std::max(vertex, 0)) * 3;
                if (vertex < 0 || at + 2 >= vertices.size())
                    return error(fmt::format("{}, face {}", shape.name, f),
                                 fmt::format("there is no vertex {}", vertex + 1));
                corners.emplace_back(vertices[at], vertices[at + 1], vertices[at + 2]);
                if (!std::isfinite(vertices[at]) || !std::isfinite(vertices[at + 1]) ||
                    !std::isfinite(vertices[at + 2]))
                    return error(fmt::format("vertex {}", vertex + 1), "is not finite");
            }
        }
    }
    if (corners.empty()) return error("", "holds no faces");
    if (without > 0) result.warnings.push_back(fmt::format("{} triangles have no material and reflect 0.5", without));
    result.scene = pie::scene::makeScene(corners, materialOf, std::move(materials));
    return result;
}

} // namespace pieprobe
