#include "pie/brushes/compile.h"

#include "pie/brushes/level_writer.h"
#include "pie/brushes/placed_models.h"
#include "pie/level/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <set>
#include <string_view>
#include <utility>

namespace pie::brushes {
namespace {

constexpr double worldMargin = 64; // units around everything that is in the map

/// The last few points before the void: there is the hole.
std::string shown(const std::vector<glm::dvec3>& path) {
    std::string text;
    constexpr std::size_t most = 4;
    for (std::size_t i = path.size() > most ? path.size() - most : 0; i < path.size(); ++i)
        text += fmt::format("{}({:.0f} {:.0f} {:.0f})", text.empty() ? "" : " ", path[i].x, path[i].y, path[i].z);
    return text;
}

class Compiler {
public:
    Compiler(const MapText& map, const std::string& fileName, const level::Vfs& files,
             const level::ShaderLibrary& library)
        : map_(map), fileName_(fileName), files_(files), shaders_(files, library) {}

    Result<CompiledMap> compile() {
        MapParts gathered = gatherParts(map_, fileName_, planes_, shaders_, result_.warnings);
        reportKeys();
        if (gathered.parts.empty())
            return Error{fileName_, "", "has no worldspawn with brushes or patches",
                         map_.problems.empty() ? "" : "first problem: " + map_.problems.front()};
        result_.models = ModelPlacer(files_, fileName_, shaders_, result_.warnings).place(map_, gathered.parts);
        result_.brushes = gathered.brushes;
        result_.patches = gathered.patches;
        done("brushes");
        const Part& world = gathered.parts.front();
        std::vector<Fragment> structural = structuralFragments(world.brushes, planes_);
        done("solid");
        SolidTree tree(structural, world.brushes, planes_, worldBounds(world));
        flood(tree);
        done("tree");
        result_.bsp = LevelWriter(map_, gathered.parts, planes_, shaders_).write(tree, std::move(structural));
        done("faces");
        return std::move(result_);
    }

private:
    const MapText& map_;
    const std::string& fileName_;
    const level::Vfs& files_;
    PlaneSet planes_;
    MapShaders shaders_;
    CompiledMap result_;
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();

    void done(const char* stage) {
        const auto now = std::chrono::steady_clock::now();
        result_.times.emplace_back(stage, std::chrono::duration<double, std::milli>(now - last_).count());
        last_ = now;
    }
    void warn(int line, const std::string& text) {
        result_.warnings.push_back(fmt::format("{}: line {}: {}", fileName_, line, text));
    }

    /// What an author may have hoped for and nobody reads, each once.
    void reportKeys() {
        static constexpr std::array<std::string_view, 34> known = {
            "classname",   "origin",     "light",         "_light",       "_color",    "target",       "targetname",
            "radius",      "spawnflags", "fade",          "scale",        "_samples",  "_extradist",   "extradist",
            "_anglescale", "_deviance",  "_filterradius", "_filteradius", "_filter",   "_flareshader", "_flare",
            "_sun",        "_style",     "style",         "angle",        "angles",    "mangle",       "notfree",
            "notteam",     "notsingle",  "gametype",      "_tb_layer",    "_tb_group", "_tb_name"};
        std::set<std::string> reported;
        for (const MapEntity& entity : map_.entities) {
            if (!level::startsWithNoCase(entity.entity.className(), "light")) continue;
            for (const auto& [key, value] : entity.entity.pairs) {
                const std::string name = level::lower(key);
                if (std::find(known.begin(), known.end(), name) == known.end() && reported.insert(name).second)
                    warn(entity.line, fmt::format("a light has a key '{}' that nothing reads", key));
            }
        }
    }

    [[nodiscard]] static Bounds worldBounds(const Part& world) {
        Bounds bounds = world.bounds();
        if (bounds.empty()) bounds.extend(glm::dvec3(0));
        bounds.lower -= worldMargin;
        bounds.upper += worldMargin;
        return bounds;
    }

    void flood(SolidTree& tree) {
        std::vector<glm::dvec3> points;
        std::vector<const MapEntity*> owners;
        for (const MapEntity& entity : map_.entities) {
            if (!entity.brushes.empty() || !entity.patches.empty()) continue;
            const std::optional<Vec3> origin = entity.entity.vector("origin");
            if (!origin) continue;
            // Feet may stand in the floor by a rounding.
            points.emplace_back(glm::dvec3(*origin) + glm::dvec3(0, 0, 1));
            owners.push_back(&entity);
        }
        const std::optional<Leak> leak = tree.flood(points);
        if (!leak) return;
        result_.leakPath = leak->path;
        const MapEntity& owner = *owners[leak->point];
        warn(owner.line,
             fmt::format("the level leaks: {} sees the void around it, by {}; faces towards the void are kept",
                         owner.entity.className(), shown(leak->path)));
    }
};

} // namespace

Result<CompiledMap> compileMap(const MapText& map, const std::string& fileName, const level::Vfs& files,
                               const level::ShaderLibrary& shaders) {
    return Compiler(map, fileName, files, shaders).compile();
}

} // namespace pie::brushes
