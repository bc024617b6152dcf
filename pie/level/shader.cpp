#include "pie/level/shader.h"
#include "pie/level/image.h"
#include "pie/level/names.h"
#include "pie/level/shader_parser.h"
#include "pie/level/tokens.h"
#include "pie/level/vfs.h"

#include "pie/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <unordered_map>

namespace pie::level {

bool Shader::drawn() const {
    if (parms.noDraw || parms.hint || parms.areaPortal || parms.trigger) return false;
    // A sky that names no sky box is drawn like any other script, as far as it has one.
    const bool scripted = origin != "image" && origin != "missing";
    if (!skyBox.empty() || (parms.sky && !scripted)) return false;
    // Glass and leaves may clip as well; a clip brush whose script is missing has no picture to show.
    if (parms.clip && origin == "missing") return false;
    return !stages.empty();
}

bool Shader::opaque() const { return !stages.empty() && stages.front().blend.opaque(); }

void SurfaceParms::addFlags(std::int32_t surfaceFlags, std::int32_t contentFlags) {
    const auto surface = static_cast<std::uint32_t>(surfaceFlags);
    const auto content = static_cast<std::uint32_t>(contentFlags);
    sky |= (surface & 0x4U) != 0;
    noDraw |= (surface & 0x80U) != 0;
    hint |= (surface & 0x300U) != 0; // hint, skip
    noLightmap |= (surface & 0x400U) != 0;
    pointLight |= (surface & 0x800U) != 0;
    nonSolid |= (surface & 0x4000U) != 0;
    lightFilter |= (surface & 0x8000U) != 0;
    alphaShadow |= (surface & 0x10000U) != 0;
    lava |= (content & 0x8U) != 0;
    slime |= (content & 0x10U) != 0;
    water |= (content & 0x20U) != 0;
    fog |= (content & 0x40U) != 0;
    areaPortal |= (content & 0x8000U) != 0;
    clip |= (content & 0x30000U) != 0; // player, monster
    translucent |= (content & 0x20000000U) != 0;
    trigger |= (content & 0x40000000U) != 0;
    if ((content & 0x8000000U) != 0) structural = false;
}

namespace {

/// What one file defines, in its order. The game ignores a file with an unclosed or unopened definition whole.
struct Scan {
    struct Definition {
        std::string name;
        std::size_t offset = 0;
        int line = 1, bodyLine = 1;
    };
    std::vector<Definition> definitions;
    std::string defect;
};

Scan scanDefinitions(std::string_view text, const std::string& fileName) {
    Scan scan;
    Tokens tokens(text);
    while (const std::optional<Token> name = tokens.next()) {
        const std::optional<Token> open = tokens.next();
        if (!open || !open->is('{')) {
            scan.defect = fmt::format("{}: line {}: '{}' is not followed by '{{'; the rest of the file is ignored",
                                      fileName, name->line, name->text.substr(0, 64));
            return scan;
        }
        const std::size_t body = tokens.offset();
        const int bodyLine = tokens.line();
        if (!tokens.skipBlock()) {
            scan.defect = fmt::format("{}: line {}: the definition of '{}' is not closed by '}}'; it is ignored",
                                      fileName, name->line, name->text.substr(0, 64));
            return scan;
        }
        scan.definitions.push_back({lower(name->text), body, name->line, bodyLine});
    }
    return scan;
}

} // namespace

/// Where a definition stands: parsed when it is asked for, because a level uses a few dozen of several thousand.
struct ShaderLibrary::Index {
    struct Definition {
        std::size_t file = 0, offset = 0;
        int line = 1;     ///< of the name
        int bodyLine = 1; ///< of the '{'
    };
    struct File {
        std::string name;
        std::string text;
    };
    std::vector<std::unique_ptr<const File>> files;
    std::unordered_map<std::string, Definition> definitions;
    std::vector<std::string> warnings;
    std::mutex mutex; ///< guards `parsed`
    std::unordered_map<std::string, std::unique_ptr<const Shader>> parsed;

    void add(std::unique_ptr<const File> file, Scan scan);
};

ShaderLibrary::ShaderLibrary() : index_(std::make_shared<Index>()) {}

/// Adds a file's definitions below those that are already there.
void ShaderLibrary::Index::add(std::unique_ptr<const File> file, Scan scan) {
    if (!scan.defect.empty()) warnings.push_back(std::move(scan.defect));
    for (Scan::Definition& found : scan.definitions)
        definitions.try_emplace(std::move(found.name),
                                Definition{files.size(), found.offset, found.line, found.bodyLine});
    files.push_back(std::move(file));
}

void ShaderLibrary::parse(std::string_view text, const std::string& fileName) {
    auto file = std::make_unique<const Index::File>(Index::File{fileName, std::string(text)});
    Scan scan = scanDefinitions(file->text, fileName);
    index_->add(std::move(file), std::move(scan));
}

ShaderLibrary ShaderLibrary::load(const Vfs& files) {
    // The game lists scripts from the highest precedence down (each name once, read from where it wins), joins the
    // texts from the last of that list to the first, and takes the first definition of a name it meets in the joined
    // text (ioquake3, ScanAndLoadShaderFiles and FindShaderInShaderText). So of two files of *different* names the one
    // in the lower archive wins.
    std::vector<std::string> names = files.scan("scripts", ".shader");
    std::reverse(names.begin(), names.end());
    struct Loaded {
        std::unique_ptr<const Index::File> file;
        Scan scan;
        std::string failure;
    };
    std::vector<Loaded> loaded(names.size());
    parallelChunks(names.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Result<Bytes> bytes = files.read(names[i]);
            if (!bytes) {
                loaded[i].failure = bytes.error().message();
                continue;
            }
            std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
            loaded[i].file = std::make_unique<const Index::File>(Index::File{names[i], std::move(text)});
            loaded[i].scan = scanDefinitions(loaded[i].file->text, names[i]);
        }
    });
    ShaderLibrary library;
    for (Loaded& script : loaded) {
        if (script.file)
            library.index_->add(std::move(script.file), std::move(script.scan));
        else
            library.index_->warnings.push_back(std::move(script.failure));
    }
    return library;
}

const Shader* ShaderLibrary::find(std::string_view name) const {
    const std::string key = lower(withoutExtension(name));
    const auto found = index_->definitions.find(key);
    if (found == index_->definitions.end()) return nullptr;
    const std::lock_guard lock(index_->mutex);
    std::unique_ptr<const Shader>& shader = index_->parsed[key];
    if (!shader) {
        const Index::File& file = *index_->files[found->second.file];
        Shader parsed = parseShader(key, std::string_view(file.text).substr(found->second.offset), file.name,
                                    found->second.bodyLine);
        parsed.origin = fmt::format("{}:{}", file.name, found->second.line);
        shader = std::make_unique<const Shader>(std::move(parsed));
    }
    return shader.get();
}

std::vector<std::string> ShaderLibrary::names() const {
    std::vector<std::string> result;
    result.reserve(index_->definitions.size());
    for (const auto& [name, where] : index_->definitions) result.push_back(name);
    std::sort(result.begin(), result.end());
    return result;
}

const std::vector<std::string>& ShaderLibrary::warnings() const { return index_->warnings; }

Shader ShaderLibrary::resolve(std::string_view name, bool lightmapped) const {
    if (const Shader* script = find(name)) return *script;
    Shader shader;
    shader.name = lower(withoutExtension(name));
    shader.origin = "image";
    shader.sort = sortOpaque;
    Stage texture;
    texture.images.emplace_back(name);
    if (!lightmapped) {
        texture.rgbGen = RgbGen::ExactVertex;
        shader.stages.push_back(std::move(texture));
        return shader;
    }
    Stage light;
    light.source = Stage::Source::Lightmap;
    light.tcGen = TcGen::Lightmap;
    texture.blend = {BlendFactor::DestinationColour, BlendFactor::Zero};
    texture.depthWrite = false;
    shader.stages.push_back(std::move(light));
    shader.stages.push_back(std::move(texture));
    return shader;
}

} // namespace pie::level
