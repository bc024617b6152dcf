// How far the triangles of a level's curves are from the curves, for values of patch_tolerance, and for the same number
// of pieces everywhere. Distances are to the nearest point of the exact surface (Gauss-Newton from the parameters of
// the point), at 15 points of each triangle. Control points carry their own place in the grid as texture coordinates:
// those are quadratic like the surface, so they are the exact parameters of every vertex.
//
//   patch_bench [level …]       prints CSV: per way and value, triangles of all levels together and distances in units

#include "pie/level/bsp.h"
#include "pie/level/patch.h"
#include "pie/level/vfs.h"

#include <fmt/format.h>
#include <glm/ext/matrix_double2x2.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using Dvec2 = glm::dvec2;
using Dvec3 = glm::dvec3;
using pie::level::PatchVertex;

struct Patch {
    std::vector<PatchVertex> controls;
    int width = 0, height = 0;

    struct Point {
        Dvec3 position, alongU, alongV;
    };
    /// The exact surface, parameters counted in control points.
    [[nodiscard]] Point at(const Dvec2& parameter) const {
        const auto block = [](double t, int size) { return std::clamp(2 * static_cast<int>(t / 2), 0, size - 3); };
        const int x = block(parameter.x, width);
        const int y = block(parameter.y, height);
        const double u = 0.5 * (parameter.x - x);
        const double v = 0.5 * (parameter.y - y);
        const std::array<double, 3> wu{(1 - u) * (1 - u), 2 * u * (1 - u), u * u};
        const std::array<double, 3> wv{(1 - v) * (1 - v), 2 * v * (1 - v), v * v};
        const std::array<double, 3> du{u - 1, 1 - 2 * u, u};
        const std::array<double, 3> dv{v - 1, 1 - 2 * v, v};
        Point point{Dvec3(0.0), Dvec3(0.0), Dvec3(0.0)};
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t i = 0; i < 3; ++i) {
                const auto k = (static_cast<std::size_t>(y) + j) * static_cast<std::size_t>(width) +
                               static_cast<std::size_t>(x) + i;
                const Dvec3 control(controls[k].position);
                point.position += wu.at(i) * wv.at(j) * control;
                point.alongU += du.at(i) * wv.at(j) * control;
                point.alongV += wu.at(i) * dv.at(j) * control;
            }
        return point;
    }

    /// From a point to the surface near the parameter: at most the distance to the surface at the parameter itself.
    [[nodiscard]] double distance(const Dvec3& target, Dvec2 parameter) const {
        Point point = at(parameter);
        double best = glm::distance(target, point.position);
        for (int round = 0; round < 12; ++round) {
            const Dvec3 off = target - point.position;
            const double uu = glm::dot(point.alongU, point.alongU);
            const double uv = glm::dot(point.alongU, point.alongV);
            const double vv = glm::dot(point.alongV, point.alongV);
            // Damped a little: at a collapsed edge the surface has one direction only.
            const glm::dmat2 square(uu * (1 + 1e-6) + 1e-12, uv, uv, vv * (1 + 1e-6) + 1e-12);
            const Dvec2 step = glm::inverse(square) * Dvec2(glm::dot(point.alongU, off), glm::dot(point.alongV, off));
            double share = 1;
            double reached = best;
            for (; share > 0.05; share *= 0.5) {
                const Dvec2 trial = glm::clamp(parameter + share * step, Dvec2(0.0), Dvec2(width - 1, height - 1));
                const Point there = at(trial);
                reached = glm::distance(target, there.position);
                if (reached < best) {
                    parameter = trial;
                    point = there;
                    break;
                }
            }
            if (!(reached < best - 1e-9)) break;
            best = reached;
        }
        return best;
    }
};

[[noreturn]] void fail(const pie::Error& error) {
    fmt::print(stderr, "patch_bench: {}\n", error.message());
    std::exit(1);
}

void addPatches(const std::string& name, std::vector<Patch>& patches) {
    const auto location = pie::level::locate(name, "/usr/share/games/openarena/baseoa");
    if (!location) fail(location.error());
    const auto bytes = location->files.read(location->name);
    if (!bytes) fail(bytes.error());
    const auto bsp = pie::level::readBsp(*bytes, name);
    if (!bsp) fail(bsp.error());
    for (const pie::level::BspFace& face : bsp->faces) {
        if (face.type != pie::level::BspFaceType::Patch) continue;
        Patch patch;
        patch.width = face.patchSize[0];
        patch.height = face.patchSize[1];
        patch.controls.resize(static_cast<std::size_t>(face.vertexCount));
        const auto first = static_cast<std::size_t>(face.firstVertex);
        for (std::size_t i = 0; i < patch.controls.size(); ++i) {
            const auto width = static_cast<std::size_t>(patch.width);
            patch.controls[i].position = bsp->vertices[first + i].position;
            patch.controls[i].texture = {i % width, i / width};
        }
        patches.push_back(std::move(patch));
    }
}

struct Distances {
    std::size_t triangles = 0;
    double largest = 0, areaSum = 0, distanceSum = 0; ///< the mean is weighted by area

    void add(const Patch& patch, float tolerance, int maxSegments) {
        constexpr int steps = 4;
        const auto mesh = pie::level::tessellate(patch.controls, patch.width, patch.height, tolerance, maxSegments);
        triangles += mesh.indices.size() / 3;
        for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
            const auto corner = [&](std::size_t i) -> const PatchVertex& { return mesh.vertices[mesh.indices[t + i]]; };
            const Dvec3 a(corner(0).position);
            const Dvec3 b(corner(1).position);
            const Dvec3 c(corner(2).position);
            double sum = 0;
            for (int i = 0; i <= steps; ++i)
                for (int j = 0; i + j <= steps; ++j) {
                    const double u = static_cast<double>(i) / steps;
                    const double v = static_cast<double>(j) / steps;
                    const Dvec2 parameter = (1 - u - v) * Dvec2(corner(0).texture) + u * Dvec2(corner(1).texture) +
                                            v * Dvec2(corner(2).texture);
                    const double distance = patch.distance((1 - u - v) * a + u * b + v * c, parameter);
                    largest = std::max(largest, distance);
                    sum += distance / 15;
                }
            const double area = 0.5 * glm::length(glm::cross(b - a, c - a));
            areaSum += area;
            distanceSum += area * sum;
        }
    }
};

} // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): what goes wrong may end a measurement
int main(int argumentCount, char** arguments) {
    std::vector<std::string> levels(arguments + 1, arguments + argumentCount);
    if (levels.empty()) levels = {"ctf_inyard"};
    std::vector<Patch> patches;
    for (const std::string& level : levels) addPatches(level, patches);
    fmt::print("way,value,patches,triangles,largest,mean\n");
    const auto line = [&](const char* way, double value, float tolerance, int maxSegments) {
        Distances distances;
        for (const Patch& patch : patches) distances.add(patch, tolerance, maxSegments);
        fmt::print("{},{},{},{},{:.5g},{:.5g}\n", way, value, patches.size(), distances.triangles, distances.largest,
                   distances.distanceSum / distances.areaSum);
    };
    for (const float tolerance : {32.0F, 16.0F, 8.0F, 4.0F, 2.0F, 1.0F, 0.5F, 0.25F, 0.125F, 0.0625F})
        line("tolerance", double{tolerance}, tolerance, 32);
    // So small a tolerance asks for as many pieces as there may be.
    for (const int pieces : {2, 3, 4, 6, 8, 12, 16}) line("pieces", pieces, 1e-5F, pieces);
    return 0;
}
