#include "pie/brushes/placed_models.h"

#include "pie/level/names.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace pie::brushes {
namespace {

/// Roll about x, then pitch about y, then yaw about z.
glm::dmat3 rotation(const level::Entity& entity) {
    glm::dvec3 angles(0, entity.number("angle").value_or(0.0F), 0);
    if (const std::optional<Vec3> given = entity.vector("angles")) angles = glm::dvec3(*given);
    const auto turn = [](int axis, double degrees) {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        const double quarter = degrees / 90;
        const bool whole = quarter == std::round(quarter);
        double sine = std::sin(glm::radians(degrees));
        double cosine = std::cos(glm::radians(degrees));
        if (whole) sine = std::round(sine), cosine = std::round(cosine);
        glm::dmat3 matrix(1);
        matrix[u][u] = cosine;
        matrix[u][v] = sine;
        matrix[v][u] = -sine;
        matrix[v][v] = cosine;
        return matrix;
    };
    return turn(2, angles.y) * turn(1, angles.x) * turn(0, angles.z);
}

glm::dvec3 scaleOf(const level::Entity& entity) {
    glm::dvec3 scale(1);
    if (const std::optional<float> all = entity.number("modelscale"); all && *all != 0) scale = glm::dvec3(*all);
    if (const std::optional<Vec3> each = entity.vector("modelscale_vec"); each && *each != Vec3(0.0F))
        scale = glm::dvec3(*each);
    return scale;
}

int integer(const level::Entity& entity, const char* key, const char* other) {
    const double value = entity.number(key).value_or(entity.number(other).value_or(0.0F));
    return static_cast<int>(std::clamp(value, 0.0, 1e6));
}

/// Corners without a normal get the mean of the faces that meet at their place.
void addNormals(Part::Mesh& mesh) {
    const auto without = [](const ModelVertex& v) { return !(glm::length(v.normal) > 1e-6); };
    if (std::none_of(mesh.vertices.begin(), mesh.vertices.end(), without)) return;
    const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::map<glm::dvec3, glm::dvec3, decltype(less)> sums(less);
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        const auto corner = [&](std::size_t k) -> const glm::dvec3& {
            return mesh.vertices[mesh.indices[i + k]].position;
        };
        const glm::dvec3 normal = glm::cross(corner(1) - corner(0), corner(2) - corner(0));
        for (std::size_t k = 0; k < 3; ++k) sums.try_emplace(corner(k), 0.0).first->second += normal;
    }
    for (ModelVertex& vertex : mesh.vertices)
        if (without(vertex))
            if (const auto at = sums.find(vertex.position); at != sums.end()) vertex.normal = at->second;
}

/// "_remap…" "from;to": names that end in `from`, or all.
void remap(const level::Entity& entity, std::string& shader) {
    for (const auto& [key, value] : entity.pairs) {
        if (!level::startsWithNoCase(key, "_remap")) continue;
        const std::size_t middle = value.find(';');
        if (middle == std::string::npos) continue;
        const std::string_view from = std::string_view(value).substr(0, middle);
        if (from == "*" || level::endsWithNoCase(shader, from)) {
            shader = level::lower(std::string_view(value).substr(middle + 1));
            return;
        }
    }
}

} // namespace

const Model* ModelPlacer::find(const std::string& name, int frame, int line) {
    const auto [at, isNew] = known_.try_emplace(fmt::format("{} {}", level::lower(name), frame));
    if (isNew) {
        const auto warn = [&](const std::string& text) {
            warnings_.push_back(fmt::format("{}: line {}: {}; it is left out", fileName_, line, text));
        };
        Result<level::Bytes> bytes = files_.read(name);
        if (!bytes) {
            warn(fmt::format("the model '{}' is not there", name));
        } else if (Result<Model> model = readModel(*bytes, name, frame)) {
            at->second = std::move(*model);
        } else {
            warn("the model " + model.error().message());
        }
    }
    return at->second ? &*at->second : nullptr;
}

/// "surface,shader" a line.
std::map<std::string, std::string> ModelPlacer::skinOf(const std::string& model, int skin) const {
    std::map<std::string, std::string> shaders;
    const std::string name = fmt::format("{}_{}.skin", level::withoutExtension(model), skin);
    if (!files_.contains(name)) return shaders;
    const Result<level::Bytes> bytes = files_.read(name);
    if (!bytes) return shaders;
    std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    while (!text.empty()) {
        const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
        const std::string_view line = text.substr(0, end);
        if (const std::size_t comma = line.find(','); comma != std::string_view::npos)
            shaders[level::lower(line.substr(0, comma))] =
                level::lower(level::withoutExtension(line.substr(comma + 1)));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return shaders;
}

void ModelPlacer::add(const level::Entity& entity, const Model& model, const std::string& name, Part& part) {
    const glm::dmat3 turn = rotation(entity);
    const glm::dvec3 scale = scaleOf(entity);
    const glm::dvec3 origin(entity.vector("origin").value_or(Vec3(0.0F)));
    const std::map<std::string, std::string> skin = skinOf(name, integer(entity, "_skin", "skin"));
    const bool mirrored = scale.x * scale.y * scale.z < 0;
    for (const ModelSurface& surface : model) {
        std::string shader = surface.shader;
        if (const auto at = skin.find(level::lower(surface.name)); at != skin.end()) shader = at->second;
        remap(entity, shader);
        Part::Mesh mesh;
        mesh.shader = shaders_.find(shader);
        mesh.vertices = surface.vertices;
        mesh.indices = surface.indices;
        for (ModelVertex& vertex : mesh.vertices) {
            vertex.position = origin + turn * (scale * vertex.position);
            // Normals stay across what is stretched.
            vertex.normal = turn * (vertex.normal / scale);
        }
        if (mirrored)
            for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
                std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
        addNormals(mesh);
        for (const ModelVertex& vertex : mesh.vertices) mesh.bounds.extend(vertex.position);
        part.meshes.push_back(std::move(mesh));
    }
}

std::size_t ModelPlacer::place(const MapText& map, std::deque<Part>& parts) {
    std::size_t count = 0;
    for (const MapEntity& placed : map.entities) {
        const level::Entity& entity = placed.entity;
        if (!level::equalNoCase(entity.className(), "misc_model")) continue;
        const std::string name(entity.value("model"));
        if (name.empty()) {
            warnings_.push_back(fmt::format("{}: line {}: a misc_model names no model", fileName_, placed.line));
            continue;
        }
        const Model* model = find(name, integer(entity, "_frame", "frame"), placed.line);
        if (model == nullptr) continue;
        const std::string_view target = entity.value("target");
        auto part = parts.begin();
        if (!target.empty()) {
            const auto named = std::find_if(std::next(parts.begin()), parts.end(), [&](const Part& p) {
                return map.entities[p.entity].entity.value("targetname") == target;
            });
            if (named != parts.end()) part = named;
        }
        add(entity, *model, name, *part);
        ++count;
    }
    return count;
}

} // namespace pie::brushes
