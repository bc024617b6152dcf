#pragma once
// Levels made by tests, face by face. The builder keeps the file's conventions (clockwise fronts, relative mesh
// vertices, ranges per model), so a test says only what it is about.

#include "pie/level/bsp.h"
#include "pie/level/vfs.h"

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pie::test {

using Pairs = std::vector<std::pair<std::string, std::string>>;

class LevelBuilder {
public:
    /// Worldspawn with these keys.
    explicit LevelBuilder(const Pairs& worldspawn = {});

    /// Index of a shader lump entry; the same for the same name and flags.
    int shader(const std::string& name, std::int32_t surfaceFlags = 0, std::int32_t contentFlags = 1);
    void entity(const Pairs& pairs);
    /// Faces added from here on belong to a new submodel; returns its number, for the key "model" "*1".
    int submodel();
    /// A polygon whose corners run counter-clockwise seen from its front; texture coordinates are x, y of the corner
    /// over 64. Returns the face's number.
    int polygon(int shader, const std::vector<Vec3>& corners, int lightmap = -3);
    /// Control points row by row; the front is where du × dv points.
    int patch(int shader, int width, int height, const std::vector<Vec3>& controls, int lightmap = -3);
    /// Six walls of a box seen from inside, in the order -x +x -y +y -z +z.
    void room(const Vec3& lower, const Vec3& upper, const std::array<int, 6>& shaders, int lightmap = -3);
    /// An axis-aligned brush with sides -x +x -y +y -z +z; returns its number.
    int brush(int shader, const Vec3& lower, const Vec3& upper);
    void effect(const std::string& shader, int brush, int visibleSide);

    /// Bounds of the models, a tree of one node over all planes, one leaf with all faces of the world.
    [[nodiscard]] level::Bsp build() const;
    level::Bsp& raw() { return bsp_; }

private:
    level::Bsp bsp_;
};

/// Control points for `patch`: a grid in x and y with this pitch and these heights.
[[nodiscard]] std::vector<Vec3> controlGrid(int width, int height, float step,
                                            const std::function<float(int column, int row)>& z);
[[nodiscard]] level::Bytes toBytes(std::string_view text);
/// A level with these further files around it, all in memory.
[[nodiscard]] level::Location inMemory(const level::Bsp& bsp,
                                       std::vector<std::pair<std::string, level::Bytes>> files = {},
                                       const std::string& name = "maps/made.bsp");
/// An uncompressed 32-bit TGA; `pixel(x, y)` counts from the top. `topDown` sets the header's flag and stores the rows
/// that way.
[[nodiscard]] level::Bytes makeTga(int width, int height, const std::function<Rgba8(int, int)>& pixel,
                                   bool topDown = false);

} // namespace pie::test
