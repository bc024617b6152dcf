#include "pie/brushes/model_formats.h"
#include "pie/level/byte_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace pie::brushes {
namespace {

constexpr std::size_t nameLength = 64;
constexpr std::int32_t mostItems = 1 << 20;

/// A reader at an offset that the file names.
level::ByteReader at(std::span<const std::byte> bytes, std::size_t base, std::int32_t offset, const std::string& what) {
    if (offset < 0 || base + static_cast<std::size_t>(offset) > bytes.size())
        throw level::Damage(what, fmt::format("starts at byte {}, behind the end", offset));
    return level::ByteReader(bytes.subspan(base + static_cast<std::size_t>(offset)));
}

/// Two angles of a byte each, in 256ths of a turn: from the z axis, and about it.
glm::dvec3 normalOf(std::uint16_t code) {
    constexpr double step = 2 * std::numbers::pi / 256;
    const double fromZ = step * (code & 255U);
    const double aboutZ = step * (code >> 8U);
    return {std::cos(aboutZ) * std::sin(fromZ), std::sin(aboutZ) * std::sin(fromZ), std::cos(fromZ)};
}

struct Counts {
    std::int32_t frames = 0, shaders = 0, vertices = 0, triangles = 0;
    std::int32_t trianglesAt = 0, shadersAt = 0, textureAt = 0, verticesAt = 0, end = 0;
};

ModelSurface readSurface(std::span<const std::byte> bytes, std::size_t base, int frame, Counts& counts) {
    level::ByteReader header(bytes.subspan(base));
    const auto magic = header.name(4);
    ModelSurface surface;
    surface.name = header.name(nameLength);
    const std::string what = fmt::format("surface '{}'", surface.name);
    if (magic != "IDP3") throw level::Damage(what, "does not start with IDP3");
    header.integer(); // flags
    for (std::int32_t* field :
         {&counts.frames, &counts.shaders, &counts.vertices, &counts.triangles, &counts.trianglesAt, &counts.shadersAt,
          &counts.textureAt, &counts.verticesAt, &counts.end})
        *field = header.integer();
    for (const std::int32_t count : {counts.frames, counts.shaders, counts.vertices, counts.triangles})
        if (count < 0 || count > mostItems) throw level::Damage(what, fmt::format("holds {} items", count));
    if (counts.shaders > 0) surface.shader = at(bytes, base, counts.shadersAt, what).name(nameLength);
    level::ByteReader triangles = at(bytes, base, counts.trianglesAt, what);
    for (std::int32_t i = 0; i < counts.triangles; ++i) {
        // The file's are clockwise.
        const auto a = static_cast<std::uint32_t>(triangles.integer());
        const auto b = static_cast<std::uint32_t>(triangles.integer());
        const auto c = static_cast<std::uint32_t>(triangles.integer());
        for (const std::uint32_t corner : {a, c, b}) surface.indices.push_back(corner);
    }
    level::ByteReader texture = at(bytes, base, counts.textureAt, what);
    constexpr std::int64_t vertexSize = 8;
    const std::int64_t shown = std::clamp(frame, 0, std::max(0, counts.frames - 1));
    const std::int64_t start = counts.verticesAt + shown * counts.vertices * vertexSize;
    if (start > static_cast<std::int64_t>(bytes.size())) throw level::Damage(what, "ends too early");
    level::ByteReader vertices = at(bytes, base, static_cast<std::int32_t>(start), what);
    for (std::int32_t i = 0; i < counts.vertices; ++i) {
        ModelVertex vertex;
        vertex.texture = glm::dvec2(texture.vec2());
        for (int axis = 0; axis < 3; ++axis) vertex.position[axis] = vertices.read<std::int16_t>() / 64.0;
        vertex.normal = normalOf(vertices.read<std::uint16_t>());
        surface.vertices.push_back(vertex);
    }
    return surface;
}

} // namespace

Model readMd3(std::span<const std::byte> bytes, int frame) {
    level::ByteReader header(bytes);
    header.name(4);
    constexpr std::int32_t version = 15;
    if (const std::int32_t found = header.integer(); found != version)
        throw level::Damage("", fmt::format("is version {} of MD3, only {} is read", found, version));
    header.name(nameLength);
    for (int i = 0; i < 3; ++i) header.integer(); // flags, frames, tags
    const std::int32_t count = header.integer();
    header.integer(); // skins
    header.integer(); // where frames are
    header.integer(); // where tags are
    const std::int32_t first = header.integer();
    Model model;
    std::size_t base = 0;
    for (std::int32_t i = 0; i < count; ++i) {
        Counts counts;
        const std::int32_t step = i == 0 ? first : 0;
        static_cast<void>(at(bytes, base, step, fmt::format("surface {}", i)));
        base += static_cast<std::size_t>(step);
        model.push_back(readSurface(bytes, base, frame, counts));
        // Every surface says where it ends: nothing is read twice.
        if (counts.end <= 0 || base + static_cast<std::size_t>(counts.end) > bytes.size())
            throw level::Damage(fmt::format("surface {}", i),
                                fmt::format("ends {} bytes behind its start", counts.end));
        base += static_cast<std::size_t>(counts.end);
    }
    return model;
}

} // namespace pie::brushes
