#include "pie/maps/snowball.h"

#include "pie/core/parallel.h"
#include "pie/maps/nearest.h"
#include "pie/sampling/directions.h"
#include "pie/sampling/halton.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pie::maps {
namespace {

constexpr std::size_t mostPhotons = std::size_t{1} << 26U;
constexpr std::size_t grain = 4096;

float wrap(double x) { return std::min(static_cast<float>(x - std::floor(x)), 0x1.fffffep-1F); }

std::uint64_t keyOf(const Vec3& p) {
    const std::uint64_t xy =
        (std::uint64_t{std::bit_cast<std::uint32_t>(p.x)} << 32U) ^ std::bit_cast<std::uint32_t>(p.y);
    return xy * 0x9e3779b97f4a7c15U ^ std::bit_cast<std::uint32_t>(p.z);
}

bool inside(const scene::Scene& scene, std::uint32_t triangle, const Vec3& point) {
    const Vec3& normal = scene.normals[triangle];
    for (int i = 0; i < 3; ++i) {
        const Vec3 a = scene.corner(triangle, i);
        const Vec3 b = scene.corner(triangle, (i + 1) % 3);
        if (!(glm::dot(glm::cross(b - a, point - a), normal) >= 0.0F)) return false;
    }
    return true;
}

} // namespace

void snowball(std::vector<photons::Photon>& photons, const scene::Scene& scene, unsigned size, float radius) {
    if (photons.empty()) return;
    const std::size_t most = std::max<std::size_t>(1, mostPhotons / photons.size());
    const std::size_t copies = std::min<std::size_t>(size, most);
    if (copies < 2 || !(radius > 0.0F)) return;
    std::vector<photons::Photon> all(photons.size() * copies);
    parallelChunks(photons.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            photons::Photon photon = photons[i];
            photon.flux /= static_cast<float>(copies);
            const Frame frame(scene.normals[photon.triangle]);
            const std::uint64_t key = keyOf(photon.position);
            const auto shiftX = static_cast<double>(sampling::hash01(key, 1));
            const auto shiftY = static_cast<double>(sampling::hash01(key, 2));
            for (std::size_t j = 0; j < copies; ++j) {
                photons::Photon copy = photon;
                copy.id = static_cast<std::uint32_t>(i * copies + j);
                if (j > 0) {
                    // The R2 lattice (Roberts 2018), shifted.
                    const Vec2 u(wrap(shiftX + static_cast<double>(j) * 0.7548776662466927),
                                 wrap(shiftY + static_cast<double>(j) * 0.5698402909980532));
                    const Vec2 disc = radius * sampling::concentricDisc(u);
                    const Vec3 moved = photon.position + disc.x * frame.tangent + disc.y * frame.bitangent;
                    if (inside(scene, photon.triangle, moved)) copy.position = moved;
                }
                all[i * copies + j] = copy;
            }
        }
    });
    photons = std::move(all);
}

} // namespace pie::maps
