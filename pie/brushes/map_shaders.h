#pragma once
// The shaders of a map: what their scripts, or the names that editors give their tools, say about brushes.

#include "pie/level/bsp.h"
#include "pie/level/shader.h"
#include "pie/level/vfs.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace pie::brushes {

struct MapShader {
    level::Shader shader;
    bool origin = false;                             ///< marks the centre of a brush entity
    bool seals = false;                              ///< a structural brush of it keeps the void out
    bool hides = false;                              ///< any brush of it is solid and lets no light through
    bool kept = false;                               ///< its faces go into the level: drawn, sky, fog …
    std::int32_t surfaceFlags = 0, contentFlags = 0; ///< of the BSP file
};

class MapShaders {
public:
    MapShaders(const level::Vfs& files, const level::ShaderLibrary& library) : files_(files), library_(library) {}
    [[nodiscard]] std::uint32_t find(const std::string& name);
    [[nodiscard]] const MapShader& operator[](std::uint32_t number) const { return shaders_[number]; }
    [[nodiscard]] std::size_t size() const { return shaders_.size(); }
    /// Width and height of the picture that editors measure textures by: editor image, else the one named like the
    /// shader, else the first stage's, else the light image; 64 x 64 where there is none. Read when first asked for.
    [[nodiscard]] std::array<int, 2> size(std::uint32_t number);

private:
    const level::Vfs& files_;
    const level::ShaderLibrary& library_;
    std::vector<MapShader> shaders_;
    std::vector<std::array<int, 2>> sizes_;
    std::map<std::string, std::uint32_t, std::less<>> byName_;
};

} // namespace pie::brushes
