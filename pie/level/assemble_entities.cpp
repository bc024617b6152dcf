#include "pie/level/assemble.h"
#include "pie/level/names.h"
#include "pie/level/tokens.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

namespace pie::level {
namespace {

bool isLight(const Entity& entity) { return startsWithNoCase(entity.className(), "light"); }

/// The lights and, behind them, what spot lights and suns point at.
std::vector<Entity> lightsOf(const std::vector<Entity>& entities) {
    std::vector<Entity> result;
    std::set<std::string> targets;
    for (const Entity& entity : entities)
        if (isLight(entity)) {
            result.push_back(entity);
            if (entity.has("target")) targets.insert(lower(entity.value("target")));
        }
    for (const Entity& entity : entities)
        if (!isLight(entity) && targets.contains(lower(entity.value("targetname")))) result.push_back(entity);
    return result;
}

void addLightsOfMap(Level& level, const std::string& levelName) {
    const std::string mapName = std::string(withoutExtension(levelName)) + ".map";
    if (!level.files->contains(mapName)) return;
    const Result<Bytes> bytes = level.files->read(mapName);
    if (!bytes) {
        level.statistics.warnings.push_back(bytes.error().message());
        return;
    }
    const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    const Result<std::vector<Entity>> entities = parseEntities(text, level.files->origin(mapName), "map");
    if (!entities) {
        level.statistics.warnings.push_back(entities.error().message());
        return;
    }
    level.lightEntities = lightsOf(*entities);
    if (!level.lightEntities.empty()) level.lightEntitySource = mapName;
}

} // namespace

std::optional<Error> addEntities(Level& level, const Bsp& bsp, const std::string& levelName) {
    Result<std::vector<Entity>> entities = parseEntities(bsp.entities, level.file, "lump entities");
    if (!entities) return entities.error();
    level.entities = std::move(*entities);
    level.lightEntities = lightsOf(level.entities);
    if (!level.lightEntities.empty())
        level.lightEntitySource = levelName;
    else
        addLightsOfMap(level, levelName);
    return std::nullopt;
}

bool showsItsModel(const Entity& entity) {
    static constexpr std::array<std::string_view, 9> shown = {"func_static",  "func_door",     "func_button",
                                                              "func_plat",    "func_train",    "func_rotating",
                                                              "func_bobbing", "func_pendulum", "func_breakable"};
    const std::string_view name = entity.className();
    const auto isName = [&](std::string_view known) { return equalNoCase(name, known); };
    if (std::none_of(shown.begin(), shown.end(), isName)) return false;
    if (entity.number("notfree").value_or(0.0F) != 0) return false;
    // "gametype" lists the games that the entity is for.
    return !entity.has("gametype") || lower(entity.value("gametype")).find("ffa") != std::string::npos;
}

void addModels(Level& level, const Bsp& bsp) {
    for (const BspModel& model : bsp.models) {
        Model& added = level.models.emplace_back();
        added.bounds.extend(model.mins);
        added.bounds.extend(model.maxs);
        added.drawn = level.models.size() == 1;
    }
    for (std::size_t i = 0; i < level.entities.size(); ++i) {
        const std::string_view value = level.entities[i].value("model");
        if (!value.starts_with('*')) continue;
        const float number = leadingNumber(value.substr(1)).value_or(0.0F);
        if (!(number >= 1) || number >= static_cast<float>(level.models.size())) {
            level.statistics.warnings.push_back(fmt::format("{}: entity {}: model '{}' is not one of the level's {}",
                                                            level.file, i, value.substr(0, 32), level.models.size()));
            continue;
        }
        Model& model = level.models[static_cast<std::size_t>(number)];
        // Two entities may share a model; the first one that shows it decides where it stands.
        if (model.entity >= 0 && (model.drawn || !showsItsModel(level.entities[i]))) continue;
        model.entity = static_cast<std::int32_t>(i);
        model.origin = level.entities[i].vector("origin").value_or(Vec3(0.0F));
        model.drawn = showsItsModel(level.entities[i]);
    }
    for (Model& model : level.models) {
        model.bounds.lower += model.origin;
        model.bounds.upper += model.origin;
    }
}

void addTree(Level& level, const Bsp& bsp) {
    const auto box = [](const std::array<std::int32_t, 3>& mins, const std::array<std::int32_t, 3>& maxs) {
        Box result;
        result.lower = Vec3(mins[0], mins[1], mins[2]);
        result.upper = Vec3(maxs[0], maxs[1], maxs[2]);
        return result;
    };
    for (const BspPlane& p : bsp.planes) level.tree.planes.push_back({p.normal, p.distance});
    for (const BspNode& n : bsp.nodes)
        level.tree.nodes.push_back({static_cast<std::uint32_t>(n.plane), n.children, box(n.mins, n.maxs)});
    for (const BspLeaf& l : bsp.leaves) level.tree.leaves.push_back({l.cluster, l.area, box(l.mins, l.maxs)});
    const BspVisibility& v = bsp.visibility;
    if (v.clusterCount > 0)
        level.tree.visibility = {static_cast<std::size_t>(v.clusterCount), static_cast<std::size_t>(v.bytesPerCluster),
                                 v.bits};
}

void addFogs(Level& level, const Bsp& bsp, const ShaderLibrary& shaders) {
    for (const BspEffect& effect : bsp.effects) {
        FogVolume& fog = level.fogs.emplace_back();
        fog.shader = lower(effect.shader);
        const Shader* shader = shaders.find(effect.shader);
        if (shader != nullptr && shader->fog)
            fog.keys = *shader->fog;
        else
            level.statistics.warnings.push_back(
                fmt::format("{}: fog shader '{}' has no fogParms", level.file, fog.shader));
        fog.bounds = level.models.front().bounds;
        if (effect.brush < 0) continue;
        const BspBrush& brush = bsp.brushes[static_cast<std::size_t>(effect.brush)];
        const auto plane = [&](std::int32_t side) -> const BspPlane& {
            const BspBrushSide& s =
                bsp.brushSides[static_cast<std::size_t>(brush.firstSide) + static_cast<std::size_t>(side)];
            return bsp.planes[static_cast<std::size_t>(s.plane)];
        };
        for (std::int32_t side = 0; side < brush.sideCount; ++side)
            for (int axis = 0; axis < 3; ++axis) {
                if (plane(side).normal[axis] == 1.0F)
                    fog.bounds.upper[axis] = std::min(fog.bounds.upper[axis], plane(side).distance);
                if (plane(side).normal[axis] == -1.0F)
                    fog.bounds.lower[axis] = std::max(fog.bounds.lower[axis], -plane(side).distance);
            }
        if (effect.visibleSide >= 0)
            fog.visiblePlane = Plane{plane(effect.visibleSide).normal, plane(effect.visibleSide).distance};
    }
}

} // namespace pie::level
