#include "pie/level/assemble.h"
#include "pie/level/image.h"
#include "pie/level/names.h"

#include "pie/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace pie::level {
namespace {

/// Whether a page holds directions: of texels that are not black, nearly all must decode to unit vectors.
bool holdsDirections(const BspLightmap& page) {
    std::size_t used = 0;
    std::size_t unit = 0;
    for (std::size_t i = 0; i + 2 < page.size(); i += 3) {
        if (page[i] == 0 && page[i + 1] == 0 && page[i + 2] == 0) continue;
        Vec3 v;
        for (int k = 0; k < 3; ++k) v[k] = static_cast<float>(page[i + static_cast<std::size_t>(k)]) / 127.5F - 1.0F;
        ++used;
        if (std::abs(glm::length(v) - 1.0F) < 0.1F) ++unit;
    }
    return used == 0 || unit * 10 >= used * 9;
}

bool worldHas(const Level& level, std::string_view key) {
    return !level.entities.empty() && level.entities.front().number(key).value_or(0.0F) != 0;
}

/// Deluxe pages stand behind the plain page they belong to, so that surfaces name even pages only. The compiler notes
/// it in the world's keys; without that the pages themselves must look like it, because a level may well use few pages.
bool isDeluxe(const Level& level, const Bsp& bsp) {
    bool any = false;
    for (const Surface& surface : level.surfaces) {
        if (surface.lightmap >= 0 && surface.lightmap % 2 != 0) return false;
        any |= surface.lightmap >= 0;
    }
    if (!any) return false;
    if (worldHas(level, "deluxemapping") || worldHas(level, "deluxemaps")) return true;
    if (bsp.lightmaps.size() < 2 || bsp.lightmaps.size() % 2 != 0) return false;
    for (std::size_t i = 1; i < bsp.lightmaps.size(); i += 2)
        if (!holdsDirections(bsp.lightmaps[i])) return false;
    return true;
}

void addInternal(Level& level, const Bsp& bsp, int stride) {
    for (std::size_t i = 0; i < bsp.lightmaps.size(); i += static_cast<std::size_t>(stride)) {
        Lightmap& added = level.lightmaps.emplace_back();
        added.width = added.height = lightmapSide;
        added.rgb.assign(bsp.lightmaps[i].begin(), bsp.lightmaps[i].end());
        added.name = fmt::format("*lightmap{}", i);
    }
    for (Surface& surface : level.surfaces)
        if (surface.lightmap >= 0) surface.lightmap /= stride;
}

/// Numbers external pages by their name and loads them when all are known.
class ExternalPages {
public:
    std::int32_t add(const std::string& name) {
        const auto [page, isNew] = pages_.try_emplace(name, static_cast<std::int32_t>(names_.size()));
        if (isNew) names_.push_back(name);
        return page->second;
    }

    /// Pages that are missing are listed as such; surfaces that name them become vertex-lit, as in the game.
    void load(Level& level, bool decode) const {
        const auto firstPage = static_cast<std::int32_t>(level.lightmaps.size());
        std::vector<Lightmap> loaded(names_.size());
        std::vector<std::string> failures(names_.size());
        parallelChunks(names_.size(), 1, [&](std::size_t i, std::size_t) {
            failures[i] = read(*level.files, names_[i], decode, loaded[i]);
        });
        for (const std::string& failure : failures)
            if (!failure.empty()) level.statistics.warnings.push_back(failure);
        for (Surface& surface : level.surfaces) {
            const std::int32_t page = surface.lightmap - firstPage;
            if (page >= 0 && !failures[static_cast<std::size_t>(page)].empty()) surface.lightmap = vertexLit;
        }
        for (Lightmap& page : loaded) level.lightmaps.push_back(std::move(page));
    }

private:
    static std::string read(const Vfs& files, const std::string& name, bool decode, Lightmap& into) {
        into.external = true;
        into.name = findImage(files, name);
        if (into.name.empty()) return fmt::format("external lightmap {} is missing", name);
        if (!decode) return {};
        const Result<Image> image = loadImage(files, into.name);
        if (!image) return image.error().message();
        into.width = image->width;
        into.height = image->height;
        into.rgb.reserve(image->pixels.size() * 3);
        for (const Rgba8& p : image->pixels) into.rgb.insert(into.rgb.end(), {p.r, p.g, p.b});
        return {};
    }

    std::map<std::string, std::int32_t> pages_;
    std::vector<std::string> names_;
};

/// The compiler that writes external pages also writes scripts whose lightmap stage is a plain picture; it becomes a
/// lightmap stage here. Empty if the shader has none.
std::string takeScriptedLightmap(Shader& shader) {
    for (Stage& stage : shader.stages) {
        if (stage.source != Stage::Source::Image || stage.tcGen != TcGen::Lightmap || stage.images.size() != 1)
            continue;
        std::string name = lower(stage.images.front());
        if (!name.starts_with("maps/") || name.find("/lm_") == std::string::npos) continue;
        stage.source = Stage::Source::Lightmap;
        stage.images.clear();
        return name;
    }
    return {};
}

} // namespace

void addLightmaps(Level& level, const AssemblyInput& input) {
    const Bsp& bsp = input.bsp;
    const int stride = input.options.deluxe && isDeluxe(level, bsp) ? 2 : 1;
    ExternalPages external;
    if (!bsp.lightmaps.empty()) {
        addInternal(level, bsp, stride);
    } else {
        for (Surface& surface : level.surfaces)
            if (surface.lightmap >= 0)
                surface.lightmap = external.add(fmt::format("maps/{}/lm_{:04}.tga", level.name, surface.lightmap));
    }
    const auto firstExternal = static_cast<std::int32_t>(level.lightmaps.size());
    std::vector<std::int32_t> pageOfShader(level.shaders.size(), noLightmap);
    for (std::size_t i = 0; i < level.shaders.size(); ++i)
        if (const std::string name = takeScriptedLightmap(level.shaders[i]); !name.empty())
            pageOfShader[i] = firstExternal + external.add(name);
    for (Surface& surface : level.surfaces)
        if (pageOfShader[surface.shader] != noLightmap) surface.lightmap = pageOfShader[surface.shader];
    external.load(level, input.options.images);
}

} // namespace pie::level
