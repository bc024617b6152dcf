#include "apps/pietrade/view.h"

#include "pie/scene/cells.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

namespace pietrade {

using pie::Vec3;

bool meets(const Camera& camera, const pie::Box& box) {
    if (box.empty()) return false;
    constexpr float degrees = std::numbers::pi_v<float> / 180;
    const float yaw = camera.yaw * degrees;
    const float pitch = camera.pitch * degrees;
    const Vec3 forward(std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), -std::sin(pitch));
    const Vec3 right(std::sin(yaw), -std::cos(yaw), 0.0F);
    const Vec3 up = glm::cross(right, forward);
    constexpr float wide = 1;     // tangent of half the width
    constexpr float high = 0.75F; // and height
    const std::array<Vec3, 5> inward{forward, wide * forward + right, wide * forward - right, high * forward + up,
                                     high * forward - up};
    return std::all_of(inward.begin(), inward.end(), [&](const Vec3& n) {
        Vec3 farthest = box.lower;
        for (int i = 0; i < 3; ++i)
            if (n[i] > 0.0F) farthest[i] = box.upper[i];
        return glm::dot(farthest - camera.eye, n) >= 0.0F;
    });
}

View seen(const pie::scene::Mesh& mesh, const pie::level::Level& level, const pie::scene::Receivers& receivers,
          const std::optional<Camera>& camera, std::size_t cellTriangles) {
    View view;
    const std::function<void(const pie::scene::CellNode&)> walk = [&](const pie::scene::CellNode& node) {
        for (const pie::scene::CellNode& child : node.children) walk(child);
        pie::Box box;
        for (const std::uint32_t t : node.triangles)
            for (const std::uint32_t v : mesh.triangles[t].vertices) box.extend(mesh.vertices[v].position);
        if (!camera || meets(*camera, box))
            view.triangles.insert(view.triangles.end(), node.triangles.begin(), node.triangles.end());
    };
    walk(pie::scene::makeCells(mesh, level, cellTriangles));
    std::sort(view.triangles.begin(), view.triangles.end());
    std::vector<bool> in(receivers.points.size(), false);
    for (const std::uint32_t t : view.triangles)
        for (const std::uint32_t v : mesh.triangles[t].vertices)
            if (receivers.ofVertex[v] != pie::scene::noReceiver) in[receivers.ofVertex[v]] = true;
    for (std::uint32_t r = 0; r < in.size(); ++r)
        if (in[r]) view.receivers.push_back(r);
    return view;
}

} // namespace pietrade
