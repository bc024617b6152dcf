#pragma once
// What is drawn: the cells that a camera's frustum meets, as in the viewer, whatever hides them.

#include "pie/level/level.h"
#include "pie/scene/mesh.h"
#include "pie/scene/receivers.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace pietrade {

/// 90 degrees wide, 4:3.
struct Camera {
    pie::Vec3 eye{0.0F};
    float yaw = 0, pitch = 0; ///< degrees; pitch positive downwards
};

/// Whether any of the box may be in view.
[[nodiscard]] bool meets(const Camera& camera, const pie::Box& box);

struct View {
    std::vector<std::uint32_t> triangles; ///< Mesh::triangles, growing
    std::vector<std::uint32_t> receivers; ///< Receivers::points, growing, each once
};
/// Without a camera everything.
[[nodiscard]] View seen(const pie::scene::Mesh& mesh, const pie::level::Level& level,
                        const pie::scene::Receivers& receivers, const std::optional<Camera>& camera,
                        std::size_t cellTriangles);

} // namespace pietrade
