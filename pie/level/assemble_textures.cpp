#include "pie/level/assemble.h"
#include "pie/level/image.h"
#include "pie/level/names.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <map>
#include <set>

namespace pie::level {
namespace {

/// Names pictures once each, in the order in which shaders name them.
class TextureList {
public:
    explicit TextureList(Level& level) : level_(&level) {}

    /// `required`: it counts as missing when it is not there.
    void add(const std::string& name, bool clamp, bool required) {
        if (name.empty()) return;
        const auto [at, isNew] = level_->textureIndex.try_emplace(name, level_->textures.size());
        if (isNew) level_->textures.push_back({name, findImage(*level_->files, name), nullptr, clamp});
        if (required && level_->textures[at->second].path.empty() && reported_.insert(lower(name)).second)
            level_->statistics.missingTextures.push_back(name);
    }

private:
    Level* level_;
    std::set<std::string> reported_;
};

bool hasSkyBox(const Shader& shader) { return !shader.skyBox.empty() && shader.skyBox != "-"; }

void nameTextures(const Shader& shader, TextureList& list) {
    for (const Stage& stage : shader.stages)
        for (const std::string& image : stage.images) list.add(image, stage.clamp, shader.drawn() || shader.parms.sky);
    if (hasSkyBox(shader))
        for (const std::string& side : skyBoxImages(shader.skyBox)) list.add(side, true, true);
    list.add(shader.light.lightImage, false, true);
    list.add(shader.editorImage, false, false);
    list.add(shader.name, false, false);
}

/// Pictures that something will look at: what is drawn, the sky, and what says how much light a surface gives back.
std::set<std::size_t> neededTextures(const Level& level) {
    std::set<std::size_t> needed;
    const auto need = [&](const std::string& name) {
        if (const auto at = level.textureIndex.find(name); at != level.textureIndex.end()) needed.insert(at->second);
    };
    for (const Shader& shader : level.shaders) {
        if (shader.drawn() || shader.parms.sky)
            for (const Stage& stage : shader.stages)
                for (const std::string& image : stage.images) need(image);
        if (hasSkyBox(shader))
            for (const std::string& side : skyBoxImages(shader.skyBox)) need(side);
        if (const Texture* light = level.lightImage(shader)) need(light->name);
    }
    return needed;
}

void decode(Level& level, const std::set<std::size_t>& needed) {
    std::vector<std::string> paths; // each file once, whatever names it has
    std::map<std::string, std::size_t> number;
    for (const std::size_t i : needed)
        if (const std::string& path = level.textures[i].path;
            !path.empty() && number.try_emplace(lower(path), paths.size()).second)
            paths.push_back(path);
    std::vector<std::shared_ptr<const Image>> images(paths.size());
    std::vector<std::string> failures(paths.size());
    parallelChunks(paths.size(), 1, [&](std::size_t i, std::size_t) {
        Result<Image> image = loadImage(*level.files, paths[i]);
        if (image)
            images[i] = std::make_shared<const Image>(std::move(*image));
        else
            failures[i] = image.error().message();
    });
    for (const std::string& failure : failures)
        if (!failure.empty()) level.statistics.warnings.push_back(failure);
    for (const std::size_t i : needed)
        if (Texture& texture = level.textures[i]; !texture.path.empty())
            texture.image = images[number.at(lower(texture.path))];
}

} // namespace

void addTextures(Level& level, const LoadOptions& options) {
    TextureList list(level);
    for (const Shader& shader : level.shaders) nameTextures(shader, list);
    if (options.images) decode(level, neededTextures(level));
}

} // namespace pie::level
