#pragma once
// The .map text that level editors write (TrenchBroom, NetRadiant, GtkRadiant): entities of "key" "value" lines, with
// brushes and patches between them. Brush faces come in three forms: the first one of Quake 3 with shift, rotation and
// scale; Valve 220 with two texture axes; and brush primitives ("brushDef") with a texture matrix.

#include "pie/core/result.h"
#include "pie/level/entities.h"

#include <glm/mat2x3.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace pie::brushes {

/// Texture axes follow from the face's direction: shift in texels, rotation in degrees, units per texel.
struct ShiftedTexture {
    std::array<double, 2> shift{};
    double rotate = 0;
    std::array<double, 2> scale{1, 1};
};
/// Valve 220: texel = dot(axis, p) / scale + shift.
struct AxisTexture {
    std::array<glm::dvec3, 2> axes{};
    std::array<double, 2> shift{}, scale{1, 1};
};
/// Brush primitives: texture coordinate = row · (dot(X, p), dot(Y, p), 1) with the face's own axes X and Y.
struct MatrixTexture {
    std::array<glm::dvec3, 2> rows{};
};
using TextureText = std::variant<ShiftedTexture, AxisTexture, MatrixTexture>;

struct FaceText {
    std::array<glm::dvec3, 3> points{}; ///< clockwise seen from outside the brush
    std::string shader;                 ///< with "textures/" in front
    TextureText texture;
    std::int32_t contents = 0;
};
struct BrushText {
    std::vector<FaceText> faces;
    int line = 0;
};
struct PatchText {
    struct Control {
        glm::dvec3 position{0};
        std::array<double, 2> texture{};
    };
    std::string shader;
    int width = 0, height = 0;
    std::vector<Control> controls; ///< row by row: `height` rows of `width`
    std::int32_t contents = 0;
    int line = 0;

    [[nodiscard]] const Control& at(int column, int row) const { return controls[place(column, row)]; }
    [[nodiscard]] Control& at(int column, int row) { return controls[place(column, row)]; }

private:
    [[nodiscard]] std::size_t place(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
    }
};
struct MapEntity {
    level::Entity entity;
    std::vector<BrushText> brushes;
    std::vector<PatchText> patches;
    int line = 0;
};
struct MapText {
    std::vector<MapEntity> entities;   ///< worldspawn and whatever the file holds, in its order
    std::vector<std::string> problems; ///< one line each, with line and column; what they are about was left out
};

/// Reads as much as can be understood: a brush with a fault is left out and reported. An Error only where no entity is
/// left.
[[nodiscard]] Result<MapText> parseMap(std::string_view text, const std::string& fileName);

} // namespace pie::brushes
