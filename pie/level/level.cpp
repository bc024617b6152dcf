#include "pie/level/level.h"
#include "pie/level/names.h"

#include <algorithm>
#include <array>
#include <system_error>

namespace pie::level {
namespace {

/// A player who has just appeared: the game lifts the start by 9 units, and eyes are 26 above a player's origin.
constexpr float eyeHeight = 9.0F + 26.0F;

/// Classes that mark where a player may stand, best first.
constexpr std::array<std::string_view, 7> startClasses = {
    "info_player_deathmatch", "info_player_start",   "team_CTF_redspawn",       "team_CTF_bluespawn",
    "team_CTF_redplayer",     "team_CTF_blueplayer", "info_player_intermission"};

float yawOf(const Entity& entity) {
    if (const std::optional<float> angle = entity.number("angle")) return *angle;
    if (const std::optional<Vec3> angles = entity.vector("angles")) return angles->y;
    return 0;
}

const Entity* firstOf(const std::vector<Entity>& entities, std::initializer_list<std::string_view> names) {
    for (const Entity& entity : entities)
        for (const std::string_view name : names)
            if (equalNoCase(entity.className(), name) && entity.vector("origin")) return &entity;
    return nullptr;
}

/// The middle of the largest leaf that is inside the level.
Vec3 somewhereInside(const Level& level) {
    float largest = -1;
    Vec3 best = level.models.empty() ? Vec3(0.0F) : level.models.front().bounds.centre();
    for (const Tree::Leaf& leaf : level.tree.leaves) {
        const Vec3 size = leaf.bounds.size();
        const float volume = size.x * size.y * size.z;
        if (leaf.cluster < 0 || !(volume > largest)) continue;
        largest = volume;
        best = leaf.bounds.centre();
    }
    return best;
}

} // namespace

std::array<std::string, 6> skyBoxImages(std::string_view base) {
    std::array<std::string, 6> names;
    constexpr std::array<std::string_view, 6> sides = {"rt", "bk", "lf", "ft", "up", "dn"};
    for (std::size_t i = 0; i < sides.size(); ++i)
        names.at(i) = std::string(base) + "_" + std::string(sides.at(i)) + ".tga";
    return names;
}

std::size_t Tree::leafAt(const Vec3& point) const {
    if (nodes.empty()) return 0;
    std::int32_t at = 0;
    while (at >= 0) {
        const Node& node = nodes[static_cast<std::size_t>(at)];
        const Plane& plane = planes[node.plane];
        at = node.children[glm::dot(plane.normal, point) >= plane.distance ? 0 : 1];
    }
    return static_cast<std::size_t>(-(at + 1));
}

const Texture* Level::texture(std::string_view imageName) const {
    const auto at = textureIndex.find(imageName);
    return at == textureIndex.end() ? nullptr : &textures[at->second];
}

const Texture* Level::lightImage(const Shader& shader) const {
    const auto existing = [&](std::string_view image) -> const Texture* {
        const Texture* found = image.empty() ? nullptr : texture(image);
        return found != nullptr && !found->path.empty() ? found : nullptr;
    };
    if (const Texture* found = existing(shader.light.lightImage)) return found;
    for (const Stage& stage : shader.stages)
        if (stage.source == Stage::Source::Image && stage.tcGen != TcGen::Environment && !stage.images.empty())
            if (const Texture* found = existing(stage.images.front())) return found;
    if (!shader.skyBox.empty() && shader.skyBox != "-")
        if (const Texture* found = existing(skyBoxImages(shader.skyBox)[4])) return found;
    if (const Texture* found = existing(shader.editorImage)) return found;
    return existing(shader.name);
}

Result<std::filesystem::path> Level::lightEntityFile() const {
    if (lightEntitySource.empty()) return Error{file, "", "has no light entities", "the lights are in shaders"};
    const std::string where = files != nullptr ? files->origin(lightEntitySource) : lightEntitySource;
    if (!endsWithNoCase(lightEntitySource, ".map"))
        return Error{where, "", "is compiled, and its lights are not written", "open the .map it was made from"};
    std::error_code error;
    if (!std::filesystem::is_regular_file(where, error))
        return Error{where, "", "is not a file of its own on disk", "unpack it from its archive and open that"};
    return std::filesystem::path(where);
}

Level::View Level::firstView() const {
    const Entity* start = firstOf(entities, {startClasses[0], startClasses[1]});
    for (std::size_t i = 2; start == nullptr && i < startClasses.size(); ++i)
        start = firstOf(entities, {startClasses.at(i)});
    if (start == nullptr) return {somewhereInside(*this), 0};
    const Vec3 origin = start->vector("origin").value_or(Vec3(0.0F));
    return {origin + Vec3(0, 0, eyeHeight), yawOf(*start)};
}

} // namespace pie::level
