#include "pie/brushes/map_shaders.h"

#include "pie/level/image.h"

#include <algorithm>
#include <string_view>

namespace pie::brushes {
namespace {

using level::SurfaceParms;

/// What tools of the editors mean where no script says so: a map may be looked at without its game.
void addToolParms(std::string_view name, SurfaceParms& parms) {
    if (!name.starts_with("textures/common/") && !name.starts_with("textures/system/")) return;
    const std::string_view tool = name.substr(name.rfind('/') + 1);
    const auto is = [&](std::initializer_list<std::string_view> names) {
        return std::find(names.begin(), names.end(), tool) != names.end();
    };
    if (is({"caulk"})) parms.noDraw = true;
    if (is({"nodraw", "nodrawnonsolid", "invisible", "origin", "nodrop", "lightgrid"}))
        parms.noDraw = parms.nonSolid = parms.translucent = true;
    if (is({"clip", "playerclip", "full_clip", "fullclip", "weapclip", "missileclip", "botclip", "monsterclip",
            "donotenter", "clusterportal"}))
        parms.clip = parms.noDraw = parms.translucent = true;
    if (is({"hint", "skip", "hintskip"})) parms.hint = true;
    if (is({"trigger"})) parms.trigger = parms.noDraw = true;
    if (is({"areaportal"})) parms.areaPortal = parms.noDraw = true;
}

/// The flags of the file's shader lump (surfaceflags.h of the game).
void setFlags(MapShader& shader) {
    const SurfaceParms& p = shader.shader.parms;
    const auto surface = [&](bool set, std::uint32_t flag) {
        if (set) shader.surfaceFlags |= static_cast<std::int32_t>(flag);
    };
    const auto content = [&](bool set, std::uint32_t flag) {
        if (set) shader.contentFlags |= static_cast<std::int32_t>(flag);
    };
    surface(p.sky, 0x4U | 0x10U);
    surface(p.noDraw, 0x80U);
    surface(p.hint, 0x100U);
    surface(p.noLightmap, 0x400U);
    surface(p.pointLight, 0x800U);
    surface(p.nonSolid, 0x4000U);
    surface(p.lightFilter, 0x8000U);
    surface(p.alphaShadow, 0x10000U);
    const bool hollow = p.nonSolid || p.lava || p.slime || p.water || p.fog || p.areaPortal || p.clip || p.trigger ||
                        p.hint || shader.origin;
    content(!hollow, 0x1U);
    content(p.lava, 0x8U);
    content(p.slime, 0x10U);
    content(p.water, 0x20U);
    content(p.fog, 0x40U);
    content(p.areaPortal, 0x8000U);
    content(p.clip, 0x10000U);
    content(!p.structural, 0x8000000U);
    content(p.translucent, 0x20000000U);
    content(p.trigger, 0x40000000U);
}

} // namespace

std::uint32_t MapShaders::find(const std::string& name) {
    const auto [at, isNew] = byName_.try_emplace(name, static_cast<std::uint32_t>(shaders_.size()));
    if (!isNew) return at->second;
    MapShader added;
    added.shader = library_.resolve(name, false);
    if (added.shader.origin == "image") addToolParms(name, added.shader.parms);
    const SurfaceParms& p = added.shader.parms;
    added.origin = name.ends_with("/origin");
    const bool open = p.translucent || p.alphaShadow || p.lightFilter || p.water || p.slime || p.lava || p.fog ||
                      p.trigger || p.clip || p.areaPortal || p.hint || added.origin;
    added.seals = !open;
    added.hides = !open && !p.nonSolid;
    // What is not drawn may still shine.
    const bool seen = !p.noDraw || p.sky || added.shader.light.surfaceLight > 0;
    added.kept = seen && !added.origin && !p.hint && !p.areaPortal && !p.trigger;
    setFlags(added);
    shaders_.push_back(std::move(added));
    sizes_.push_back({0, 0});
    return at->second;
}

std::array<int, 2> MapShaders::size(std::uint32_t number) {
    std::array<int, 2>& known = sizes_[number];
    if (known[0] > 0) return known;
    known = {64, 64};
    const level::Shader& shader = shaders_[number].shader;
    std::vector<std::string> names{shader.editorImage, shader.name};
    for (const level::Stage& stage : shader.stages)
        if (stage.source == level::Stage::Source::Image && !stage.images.empty()) {
            names.push_back(stage.images.front());
            break;
        }
    names.push_back(shader.light.lightImage);
    for (const std::string& name : names) {
        const std::string path = name.empty() ? std::string() : level::findImage(files_, name);
        if (path.empty()) continue;
        if (const auto size = level::imageSize(files_, path)) {
            known = *size;
            break;
        }
    }
    return known;
}

} // namespace pie::brushes
