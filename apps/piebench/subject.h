#pragma once
// What is measured on: a level with its lights, refined to a number of triangles, and the number of photons to emit so
// that about as many are stored as were asked for.

#include "pie/core/result.h"
#include "pie/engine/settings.h"
#include "pie/level/level.h"
#include "pie/lights/light_set.h"
#include "pie/photons/tracer.h"
#include "pie/scene/mesh.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace piebench {

struct LoadedLevel {
    std::string name;
    std::shared_ptr<const pie::level::Level> level;
    std::shared_ptr<const pie::scene::Scene> scene;
    std::vector<pie::lights::Light> lights;
    pie::scene::Mesh mesh; ///< not refined, T-junctions closed
};
/// `level` as pieprobe takes it: a .bsp or .map on disk, or in a pk3; with the setting `game` the name of a map.
[[nodiscard]] pie::Result<LoadedLevel> load(const std::string& level, const pie::engine::Settings& settings);
/// One of our own levels ("small"), in the folder where the program is run or beside it, built or installed. The name
/// as it is where none is found.
[[nodiscard]] std::string bundledLevel(const std::string& name);

/// Which questions a frame asks: one per receiver (the estimate cache), or one per corner of every triangle, as
/// without.
enum class Questions : std::uint8_t { PerReceiver, PerCorner };

struct Subject {
    const LoadedLevel* of = nullptr;
    pie::scene::Receivers receivers;
    std::size_t triangles = 0;
    std::vector<std::uint32_t> which; ///< receivers, in the order of the questions
    /// For each vertex that is lit, which answer is its colour.
    std::vector<std::uint32_t> answerOfVertex;
};
/// `triangles`: so many, or one or two more where a closed T-junction needs them; 0: as the settings say. An error
/// where the level has more.
[[nodiscard]] pie::Result<Subject> refined(const LoadedLevel& level, std::size_t triangles,
                                           const pie::engine::Settings& settings,
                                           Questions questions = Questions::PerReceiver);

struct PhotonCount {
    std::uint64_t emitted = 0; ///< a multiple of what was wanted
    std::uint64_t stored = 0;  ///< of indices 0 … emitted − 1
};
/// How many have to be emitted for about `stored` hits. An error where the level keeps none, or too few of them.
[[nodiscard]] pie::Result<PhotonCount> photonsFor(std::uint64_t stored, std::uint64_t multipleOf,
                                                  const LoadedLevel& level, pie::photons::TracerOptions options);

} // namespace piebench
