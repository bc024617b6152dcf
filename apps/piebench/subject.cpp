#include "apps/piebench/subject.h"

#include "pie/brushes/load.h"
#include "pie/engine/options.h"
#include "pie/intersect/intersector.h"
#include "pie/lights/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

namespace piebench {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t mostEmitted = 10'000'000; // the range of photons_from_light

} // namespace

std::string bundledLevel(const std::string& name) {
    const fs::path file = fs::path("maps") / (name + ".map");
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    for (const fs::path& folder : {fs::path("levels"), program / "../../../levels", program / "../share/pie/levels"})
        if (fs::is_regular_file(folder / file, ignored)) return (folder / file).lexically_normal().string();
    return name;
}

pie::Result<LoadedLevel> load(const std::string& name, const pie::engine::Settings& settings) {
    const std::vector<fs::path> folders(settings.textures.begin(), settings.textures.end());
    auto location = pie::level::locate(name, settings.game, folders);
    if (!location) return location.error();
    pie::level::LoadOptions options;
    options.patchTolerance = settings.patchTolerance;
    auto level = pie::brushes::loadLevel(std::move(*location), options);
    if (!level) return level.error();
    LoadedLevel loaded;
    loaded.name = level->name;
    loaded.scene =
        std::make_shared<const pie::scene::Scene>(pie::scene::makeScene(*level, pie::engine::sceneOptions(settings)));
    loaded.lights = pie::lights::importLights(*level, *loaded.scene, pie::engine::importOptions(settings)).lights;
    loaded.mesh = pie::scene::makeMesh(*level);
    pie::scene::closeTJunctions(loaded.mesh, settings.tJunctionTolerance);
    loaded.level = std::make_shared<const pie::level::Level>(std::move(*level));
    return loaded;
}

pie::Result<Subject> refined(const LoadedLevel& level, std::size_t triangles, const pie::engine::Settings& settings,
                             Questions questions) {
    pie::scene::Mesh mesh = level.mesh;
    pie::scene::RefineOptions options = pie::engine::refineOptions(settings);
    if (triangles != 0) {
        if (triangles < mesh.triangles.size())
            return pie::Error{level.name, "",
                              fmt::format("has {} triangles before any is split, {} were asked for",
                                          mesh.triangles.size(), triangles),
                              "--triangles can only add to them"};
        // Splitting one triangle in two adds one.
        options.maxSplits = triangles - mesh.triangles.size();
        options.maxEdge = std::numeric_limits<float>::min();
        options.maxTriangles = std::max(options.maxTriangles, triangles);
    }
    pie::scene::refine(mesh, options);
    Subject subject;
    subject.of = &level;
    subject.receivers = pie::scene::makeReceivers(mesh, *level.level);
    subject.triangles = mesh.triangles.size();
    if (subject.receivers.points.empty()) return pie::Error{level.name, "", "has no surface that is lit", ""};

    const std::vector<std::uint32_t>& ofVertex = subject.receivers.ofVertex;
    std::vector<std::uint32_t> answer(ofVertex.size(), pie::scene::noReceiver);
    if (questions == Questions::PerReceiver) {
        for (std::uint32_t r = 0; r < subject.receivers.points.size(); ++r) subject.which.push_back(r);
        answer = ofVertex;
    } else {
        for (const pie::scene::MeshTriangle& triangle : mesh.triangles)
            for (const std::uint32_t vertex : triangle.vertices) {
                if (ofVertex[vertex] == pie::scene::noReceiver) continue;
                answer[vertex] = static_cast<std::uint32_t>(subject.which.size());
                subject.which.push_back(ofVertex[vertex]);
            }
    }
    for (const std::uint32_t a : answer)
        if (a != pie::scene::noReceiver) subject.answerOfVertex.push_back(a);
    return subject;
}

pie::Result<PhotonCount> photonsFor(std::uint64_t stored, std::uint64_t multipleOf, const LoadedLevel& level,
                                    pie::photons::TracerOptions options) {
    const pie::lights::LightSet lights(level.lights, level.scene);
    const auto intersector =
        pie::intersect::makeIntersector(pie::intersect::Kind::Embree, *level.scene, level.level->tree);
    PhotonCount found{std::max(multipleOf, stored), 0};
    // The share that is kept hardly depends on the number, so the second guess is as good as it gets.
    for (int round = 0; round < 3; ++round) {
        found.emitted = std::min(found.emitted, mostEmitted);
        options.photonsPerFrame = found.emitted;
        const pie::photons::PhotonTracer tracer(*level.scene, lights, *intersector, options);
        std::vector<pie::photons::Photon> photons;
        found.stored = tracer.trace(0, found.emitted, photons).stored;
        if (round == 2) break;
        const double share = static_cast<double>(found.stored) / static_cast<double>(found.emitted);
        if (found.stored == 0 || static_cast<double>(stored) / share > static_cast<double>(mostEmitted))
            return pie::Error{level.name, "",
                              level.lights.empty()
                                  ? "has no light"
                                  : fmt::format("keeps {} of {} photons: {} cannot be had from {} a frame",
                                                found.stored, found.emitted, stored, mostEmitted),
                              level.lights.empty() ? "" : "fewer --photons"};
        const double units = static_cast<double>(stored) / share / static_cast<double>(multipleOf);
        found.emitted = multipleOf * std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(units)));
    }
    return found;
}

} // namespace piebench
