#include "tests/support/cornell.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <random>

namespace pie::test {
namespace {

enum Paint : std::uint32_t { White, Red, Green };
struct Named {
    const char* name;
    Rgb reflectance;
};
const std::array<Named, 3> paints{Named{"white", {0.725F, 0.71F, 0.68F}}, Named{"red", {0.63F, 0.065F, 0.05F}},
                                  Named{"green", {0.14F, 0.45F, 0.091F}}};

struct Quad {
    std::array<Vec3, 4> corners;
    Paint paint;
};

constexpr std::size_t wallCount = 5;
constexpr float height = 548.8F;

std::array<Quad, wallCount> walls() {
    return {Quad{{Vec3(552.8F, 0.0F, 0.0F), {0.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 559.2F}, {549.6F, 0.0F, 559.2F}}, White},
            Quad{{Vec3(556.0F, height, 0.0F), {556.0F, height, 559.2F}, {0.0F, height, 559.2F}, {0.0F, height, 0.0F}},
                 White},
            Quad{{Vec3(549.6F, 0.0F, 559.2F), {0.0F, 0.0F, 559.2F}, {0.0F, height, 559.2F}, {556.0F, height, 559.2F}},
                 White},
            Quad{{Vec3(0.0F, 0.0F, 559.2F), {0.0F, 0.0F, 0.0F}, {0.0F, height, 0.0F}, {0.0F, height, 559.2F}}, Green},
            Quad{{Vec3(552.8F, 0.0F, 0.0F), {549.6F, 0.0F, 559.2F}, {556.0F, height, 559.2F}, {556.0F, height, 0.0F}},
                 Red}};
}

struct Block {
    float top;
    std::array<Vec2, 4> outline; ///< x and z
};
const std::array<Block, 2> blocks{
    Block{165.0F, {Vec2(130.0F, 65.0F), {82.0F, 225.0F}, {240.0F, 272.0F}, {290.0F, 114.0F}}},
    Block{330.0F, {Vec2(423.0F, 247.0F), {265.0F, 296.0F}, {314.0F, 456.0F}, {472.0F, 406.0F}}}};

Vec3 normalOf(const Quad& quad) {
    return glm::normalize(glm::cross(quad.corners[2] - quad.corners[0], quad.corners[3] - quad.corners[1]));
}
Vec3 middleOf(const Quad& quad) {
    return 0.25F * (quad.corners[0] + quad.corners[1] + quad.corners[2] + quad.corners[3]);
}
/// Turned so that its front looks along `way`.
Quad facing(Quad quad, const Vec3& way) {
    if (glm::dot(normalOf(quad), way) < 0.0F) std::reverse(quad.corners.begin(), quad.corners.end());
    return quad;
}

std::vector<Quad> quads() {
    std::vector<Quad> result;
    const Vec3 centre(278.0F, 274.4F, 279.6F);
    for (const Quad& wall : walls()) result.push_back(facing(wall, centre - middleOf(wall)));
    for (const Block& block : blocks) {
        const auto at = [&](std::size_t i, float y) { return Vec3(block.outline[i % 4].x, y, block.outline[i % 4].y); };
        const Quad top{{at(0, block.top), at(1, block.top), at(2, block.top), at(3, block.top)}, White};
        result.push_back(facing(top, {0.0F, 1.0F, 0.0F}));
        Vec3 inside = middleOf(top);
        inside.y *= 0.5F;
        for (std::size_t i = 0; i < 4; ++i) {
            const Quad side{{at(i, 0.0F), at(i + 1, 0.0F), at(i + 1, block.top), at(i, block.top)}, White};
            result.push_back(facing(side, middleOf(side) - inside));
        }
    }
    return result;
}

bool underBlock(const Vec3& p) {
    if (p.y > 1.0F) return false;
    return std::any_of(blocks.begin(), blocks.end(), [&](const Block& block) {
        bool left = true;
        bool right = true;
        for (std::size_t i = 0; i < 4; ++i) {
            const Vec2 a = block.outline[i];
            const Vec2 side = block.outline[(i + 1) % 4] - a;
            const Vec2 to = Vec2(p.x, p.z) - a;
            (side.x * to.y - side.y * to.x < 0.0F ? left : right) = false;
        }
        return left || right;
    });
}

constexpr int cuts = 10;

std::vector<scene::Receiver> wallVertices(bool edges) {
    std::vector<scene::Receiver> result;
    const auto all = quads();
    for (std::size_t w = 0; w < wallCount; ++w) {
        const auto& c = all[w].corners;
        const Vec3 normal = normalOf(all[w]);
        for (int i = 0; i <= cuts; ++i)
            for (int j = 0; j <= cuts; ++j) {
                if ((i == 0 || j == 0 || i == cuts || j == cuts) != edges) continue;
                const float s = static_cast<float>(i) / cuts;
                const float t = static_cast<float>(j) / cuts;
                const Vec3 at = (1 - s) * ((1 - t) * c[0] + t * c[3]) + s * ((1 - t) * c[1] + t * c[2]);
                if (underBlock(at)) continue;
                scene::Receiver receiver{at, normal, at, false};
                if (edges) receiver.inset += glm::normalize(middleOf(all[w]) - at);
                result.push_back(receiver);
            }
    }
    return result;
}

} // namespace

scene::Scene cornellScene() {
    std::vector<scene::Material> materials(paints.size());
    for (std::size_t i = 0; i < paints.size(); ++i) materials[i].reflectance = paints[i].reflectance;
    std::vector<Vec3> corners;
    std::vector<std::uint32_t> materialOf;
    for (const Quad& quad : quads())
        for (const std::size_t second : {1U, 2U}) {
            corners.insert(corners.end(), {quad.corners[0], quad.corners[second], quad.corners[second + 1]});
            materialOf.push_back(quad.paint);
        }
    return scene::makeScene(corners, materialOf, std::move(materials));
}

std::filesystem::path writeCornell(const std::filesystem::path& folder) {
    std::ofstream mtl(folder / "cornell.mtl");
    for (const Named& paint : paints)
        mtl << fmt::format("newmtl {}\nKd {} {} {}\n", paint.name, paint.reflectance.x, paint.reflectance.y,
                           paint.reflectance.z);
    std::ofstream obj(folder / "cornell.obj");
    obj << "# The Cornell box, millimetres, y up, front open\nmtllib cornell.mtl\n";
    for (const Quad& quad : quads()) {
        for (const Vec3& v : quad.corners) obj << fmt::format("v {} {} {}\n", v.x, v.y, v.z);
        obj << fmt::format("usemtl {}\nf -4 -3 -2 -1\n", paints[quad.paint].name);
    }
    return folder / "cornell.obj";
}

std::vector<scene::Receiver> cornellPoints(std::size_t count, unsigned seed) {
    const auto all = quads();
    std::vector<double> areas;
    for (const Quad& quad : all)
        areas.push_back(
            double{glm::length(glm::cross(quad.corners[2] - quad.corners[0], quad.corners[3] - quad.corners[1]))});
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<float>(random() >> 8U) * 0x1p-24F; };
    double total = 0;
    for (const double area : areas) total += area;
    std::vector<scene::Receiver> result;
    while (result.size() < count) {
        double rest = total * static_cast<double>(unit());
        std::size_t q = 0;
        while (q + 1 < all.size() && rest >= areas[q]) rest -= areas[q++];
        const auto& c = all[q].corners;
        const float s = unit();
        const float t = unit();
        const Vec3 at = (1 - s) * ((1 - t) * c[0] + t * c[3]) + s * ((1 - t) * c[1] + t * c[2]);
        if (!underBlock(at) || q >= wallCount) result.push_back({at, normalOf(all[q]), at, false});
    }
    return result;
}

std::vector<scene::Receiver> cornellEdgeVertices() { return wallVertices(true); }
std::vector<scene::Receiver> cornellInnerVertices() { return wallVertices(false); }

std::string pointsCsv(const std::vector<scene::Receiver>& receivers) {
    std::string text = "x,y,z,nx,ny,nz\n";
    for (const scene::Receiver& r : receivers)
        text += fmt::format("{},{},{},{},{},{}\n", r.position.x, r.position.y, r.position.z, r.normal.x, r.normal.y,
                            r.normal.z);
    return text;
}

} // namespace pie::test
