#include "osgPlugins/osgpie/state_sets.h"

#include <osg/AlphaFunc>
#include <osg/BlendFunc>
#include <osg/CullFace>
#include <osg/Depth>
#include <osg/DisplaySettings>
#include <osg/NodeVisitor>
#include <osg/PolygonOffset>
#include <osg/TexEnvCombine>
#include <osg/Uniform>

#include <algorithm>
#include <cmath>
#include <utility>

namespace osgpie {
namespace {

using pie::engine::View;
using pie::level::AlphaTest;
using pie::level::BlendFactor;
using pie::level::Level;
using pie::level::Shader;
using pie::level::Stage;

/// Keeps the level's pixels alive for as long as an osg::Image shows them: pictures are never copied.
struct PixelOwner : osg::Referenced {
    explicit PixelOwner(std::shared_ptr<const pie::level::Image> image) : pixels(std::move(image)) {}
    std::shared_ptr<const pie::level::Image> pixels;
};

GLenum glFactor(BlendFactor factor) {
    switch (factor) {
    case BlendFactor::Zero: return GL_ZERO;
    case BlendFactor::One: return GL_ONE;
    case BlendFactor::SourceColour: return GL_SRC_COLOR;
    case BlendFactor::OneMinusSourceColour: return GL_ONE_MINUS_SRC_COLOR;
    case BlendFactor::DestinationColour: return GL_DST_COLOR;
    case BlendFactor::OneMinusDestinationColour: return GL_ONE_MINUS_DST_COLOR;
    case BlendFactor::SourceAlpha: return GL_SRC_ALPHA;
    case BlendFactor::OneMinusSourceAlpha: return GL_ONE_MINUS_SRC_ALPHA;
    case BlendFactor::DestinationAlpha: return GL_DST_ALPHA;
    case BlendFactor::OneMinusDestinationAlpha: return GL_ONE_MINUS_DST_ALPHA;
    case BlendFactor::SourceAlphaSaturate: return GL_SRC_ALPHA_SATURATE;
    }
    return GL_ONE;
}

void setWrap(osg::Texture2D& texture, bool clamp) {
    const auto mode = clamp ? osg::Texture::CLAMP_TO_EDGE : osg::Texture::REPEAT;
    texture.setWrap(osg::Texture::WRAP_S, mode);
    texture.setWrap(osg::Texture::WRAP_T, mode);
}

/// OSG makes room in a texture for as many contexts as there are when the texture is made. The first frame of a later
/// context then grows Texture2D's count of changes on its own drawing thread (resizeGLObjectBuffers forgets it, and
/// does not reach the frames of an animMap): two such threads at once destroy the heap. So there is room beforehand,
/// for as many as OSG itself assumes before there is a window.
void makeRoomForContexts(osg::Texture2D& texture) {
    constexpr unsigned usual = 32;
    const unsigned contexts = std::max(usual, osg::DisplaySettings::instance()->getMaxNumberOfGraphicsContexts());
    texture.resizeGLObjectBuffers(contexts);
    texture.getModifiedCount(contexts - 1) = 0;
}

osg::ref_ptr<osg::Texture2D> makeTexture(osg::Image* image, bool clamp, bool mipmaps) {
    osg::ref_ptr texture = new osg::Texture2D(image);
    makeRoomForContexts(*texture);
    texture->setResizeNonPowerOfTwoHint(false);
    setWrap(*texture, clamp);
    texture->setFilter(osg::Texture::MIN_FILTER, mipmaps ? osg::Texture::LINEAR_MIPMAP_LINEAR : osg::Texture::LINEAR);
    texture->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
    return texture;
}

osg::ref_ptr<osg::Texture2D> makePlain(osg::Vec4ub colour) {
    osg::ref_ptr image = new osg::Image;
    image->allocateImage(1, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE);
    for (unsigned i = 0; i < 4; ++i) image->data()[i] = colour[i];
    return makeTexture(image, false, false);
}

/// Shows the frames of an animMap in turn.
class AnimationCallback : public osg::StateSet::Callback {
public:
    AnimationCallback(std::vector<osg::ref_ptr<osg::Texture2D>> frames, float framesPerSecond, unsigned unit)
        : frames_(std::move(frames)), framesPerSecond_(framesPerSecond), unit_(unit) {}
    void operator()(osg::StateSet* state, osg::NodeVisitor* visitor) override {
        if (!visitor || !visitor->getFrameStamp()) return;
        const double frame =
            std::floor(visitor->getFrameStamp()->getSimulationTime() * static_cast<double>(framesPerSecond_));
        const auto index = static_cast<std::size_t>(std::max(0.0, frame)) % frames_.size();
        state->setTextureAttribute(unit_, frames_[index]);
    }

private:
    std::vector<osg::ref_ptr<osg::Texture2D>> frames_;
    float framesPerSecond_;
    unsigned unit_;
};

} // namespace

pie::Rgb gameLight(const pie::Rgb& bytes, float overbright) {
    pie::Rgb light = bytes * (4.0F / 255.0F);
    const float largest = pie::maxChannel(light);
    if (largest > overbright) light *= overbright / largest;
    return light / overbright;
}

float largestLight(const pie::engine::Settings& settings) {
    if (settings.renderer == pie::engine::Renderer::Glsl || settings.overbrightClamp <= 1)
        return settings.overbrightClamp;
    return settings.overbrightClamp <= 2 ? 2.0F : 4.0F;
}

StateSets::StateSets(std::shared_ptr<const Level> level, const pie::engine::Settings& settings)
    : level_(std::move(level)), settings_(settings), white_(makePlain({255, 255, 255, 255})),
      missing_(makePlain({128, 128, 128, 255})) {
    if (settings_.viewsSwitch()) viewSwitch_ = std::make_shared<ViewSwitch>(settings_.view, settings_.exposure);
}

const StateSets::Entry& StateSets::get(const StateKey& key) {
    const auto [place, isNew] = entries_.try_emplace(key);
    if (isNew) {
        const Look chosen = look(key);
        const MaterialProgram material = makeMaterialProgram(level_->shaders[key.shader], chosen);
        place->second = {material.visible ? makeState(key, material) : nullptr, material.lit,
                         material.lightmapCoordinates, chosen.light, chosen.switchable};
    }
    return place->second;
}

Look StateSets::look(const StateKey& key) const {
    Look look;
    switch (settings_.view) {
    case View::Baked: look.light = key.lightmap >= 0 ? LightSource::Lightmap : LightSource::Vertex; break;
    case View::Fullbright: look.light = LightSource::None; break;
    default: look.light = LightSource::Irradiance; break;
    }
    if (settings_.viewsSwitch()) {
        look.light = LightSource::Irradiance;
        look.switchable = true;
        look.lightmapped = key.lightmap >= 0;
    }
    look.textures = settings_.view != View::Light || look.switchable;
    look.overbright = largestLight(settings_);
    look.addSigned = settings_.blending == pie::engine::Blending::AddSigned;
    look.linear = settings_.colorSpace == pie::engine::ColorSpace::Srgb;
    look.animate = settings_.animate;
    look.fog = key.fog >= 0 && settings_.drawFog && look.textures;
    return look;
}

osg::ref_ptr<osg::Texture2D> StateSets::texture(const std::string& name, bool clamp) {
    auto& slot = textures_[{name, clamp}];
    if (slot) return slot;
    const pie::level::Texture* source = level_->texture(name);
    if (!source || !source->image) return slot = missing_;
    const auto& picture = source->image;
    osg::ref_ptr image = new osg::Image;
    // NO_DELETE: the pixels belong to the level, which PixelOwner keeps.
    auto* bytes = reinterpret_cast<unsigned char*>(const_cast<pie::Rgba8*>(picture->pixels.data()));
    image->setImage(picture->width, picture->height, 1, picture->hasAlpha ? GL_RGBA8 : GL_RGB8, GL_RGBA,
                    GL_UNSIGNED_BYTE, bytes, osg::Image::NO_DELETE);
    image->setUserData(new PixelOwner(picture));
    image->setFileName(source->path);
    return slot = makeTexture(image, clamp, true);
}

osg::ref_ptr<osg::Texture2D> StateSets::lightmap(std::int32_t index) {
    auto& slot = lightmaps_[index];
    if (slot) return slot;
    if (index < 0 || static_cast<std::size_t>(index) >= level_->lightmaps.size()) return slot = white_;
    const pie::level::Lightmap& source = level_->lightmaps[static_cast<std::size_t>(index)];
    osg::ref_ptr image = new osg::Image;
    image->allocateImage(source.width, source.height, 1, GL_RGB, GL_UNSIGNED_BYTE, 1);
    const std::size_t texels = static_cast<std::size_t>(source.width) * static_cast<std::size_t>(source.height);
    for (std::size_t i = 0; i < texels; ++i) {
        const pie::Rgb bytes(source.rgb[3 * i], source.rgb[3 * i + 1], source.rgb[3 * i + 2]);
        const pie::Rgb light = gameLight(bytes, largestLight(settings_)) * 255.0F;
        constexpr float rounding = 1e-3F; // the game shifts integers: 4 · byte comes out whole
        for (int c = 0; c < 3; ++c)
            image->data()[3 * i + static_cast<std::size_t>(c)] = static_cast<unsigned char>(light[c] + rounding);
    }
    return slot = makeTexture(image, true, false);
}

osg::ref_ptr<osg::Texture2D> StateSets::unitTexture(const UnitTexture& unit, const StateKey& key, std::size_t frame) {
    switch (unit.source) {
    case Stage::Source::Lightmap: return lightmap(key.lightmap);
    case Stage::Source::White: return white_;
    case Stage::Source::Image: break;
    }
    return unit.images.empty() ? white_ : texture(unit.images[frame], unit.clamp);
}

osg::ref_ptr<osg::Program> StateSets::program(const MaterialProgram& material, const std::string& name) {
    auto& slot = programs_[{material.vertexSource, material.fragmentSource}];
    if (!slot) {
        slot = new osg::Program;
        slot->setName(name);
        slot->addShader(new osg::Shader(osg::Shader::VERTEX, material.vertexSource));
        slot->addShader(new osg::Shader(osg::Shader::FRAGMENT, material.fragmentSource));
    }
    return slot;
}

osg::ref_ptr<osg::StateSet> StateSets::makeState(const StateKey& key, const MaterialProgram& material) {
    const Shader& shader = level_->shaders[key.shader];
    osg::ref_ptr state = new osg::StateSet;
    state->setName(shader.name);
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    const bool glsl = settings_.renderer == pie::engine::Renderer::Glsl;
    for (std::size_t u = 0; u < material.units.size(); ++u) {
        const UnitTexture& unit = material.units[u];
        const auto index = static_cast<unsigned>(u);
        // Only what fixed-function rendering may use is enabled as a mode; programs sample without.
        const bool fixedUnit = u == 0 || (u == 1 && unit.source == Stage::Source::Lightmap);
        const osg::ref_ptr<osg::Texture2D> first = unitTexture(unit, key);
        if (fixedUnit)
            state->setTextureAttributeAndModes(index, first);
        else if (glsl)
            state->setTextureAttribute(index, first);
        if (glsl) state->addUniform(new osg::Uniform(("unit" + std::to_string(u)).c_str(), static_cast<int>(u)));
        if (unit.images.size() > 1 && unit.framesPerSecond > 0 && settings_.animate && (glsl || fixedUnit)) {
            std::vector<osg::ref_ptr<osg::Texture2D>> frames;
            for (std::size_t f = 0; f < unit.images.size(); ++f) frames.push_back(unitTexture(unit, key, f));
            state->setDataVariance(osg::Object::DYNAMIC);
            state->setUpdateCallback(new AnimationCallback(std::move(frames), unit.framesPerSecond, index));
        }
    }
    if (glsl) state->setAttributeAndModes(program(material, shader.name));
    addFixedFunction(*state, key, material);
    if (glsl && key.fog >= 0) {
        const pie::level::FogVolume& fog = level_->fogs[static_cast<std::size_t>(key.fog)];
        const pie::Rgb colour = fog.keys.colour;
        // Without a visible side the whole volume fogs: a plane that everything lies below.
        osg::Vec4 below(0, 0, 0, 1e6F);
        if (fog.visiblePlane) {
            const auto& plane = *fog.visiblePlane;
            below.set(-plane.normal.x, -plane.normal.y, -plane.normal.z, plane.distance);
        }
        state->addUniform(new osg::Uniform("fogColour", osg::Vec3(colour.x, colour.y, colour.z)));
        state->addUniform(new osg::Uniform("fogPlane", below));
        state->addUniform(new osg::Uniform("fogOpaque", std::max(1.0F, fog.keys.opaqueDistance)));
    }
    if (shader.cull == pie::level::Cull::None)
        state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    else
        state->setAttributeAndModes(
            new osg::CullFace(shader.cull == pie::level::Cull::Back ? osg::CullFace::FRONT : osg::CullFace::BACK));
    if (shader.polygonOffset) state->setAttributeAndModes(new osg::PolygonOffset(-1.0F, -2.0F));
    if (material.blended) {
        // A blend function that stands for several stages fits only what the program makes of them.
        const auto blend = glsl ? material.blend : shader.stages.front().blend;
        state->setAttributeAndModes(new osg::BlendFunc(glFactor(blend.source), glFactor(blend.destination)));
    }
    if (!material.depthWrite) state->setAttributeAndModes(new osg::Depth(osg::Depth::LEQUAL, 0.0, 1.0, false));
    if (material.bin != 0) state->setRenderBinDetails(material.bin, material.blended ? "DepthSortedBin" : "RenderBin");
    return state;
}

/// What shows where programs are not to be had: picture × light of the vertices or the lightmap, cut per channel.
void StateSets::addFixedFunction(osg::StateSet& state, const StateKey& key, const MaterialProgram& material) const {
    const bool lightmap = material.units.size() > 1 && material.units[1].source == Stage::Source::Lightmap;
    const bool picture = settings_.view != View::Light;
    const bool vertices = material.vertexLit && !lightmap;
    osg::ref_ptr first = new osg::TexEnvCombine;
    first->setCombine_RGB(vertices && picture ? osg::TexEnvCombine::MODULATE : osg::TexEnvCombine::REPLACE);
    first->setSource0_RGB(picture ? osg::TexEnvCombine::TEXTURE : osg::TexEnvCombine::PRIMARY_COLOR);
    first->setSource1_RGB(osg::TexEnvCombine::PRIMARY_COLOR);
    first->setCombine_Alpha(osg::TexEnvCombine::REPLACE);
    first->setSource0_Alpha(osg::TexEnvCombine::TEXTURE);
    first->setScale_RGB(vertices ? largestLight(settings_) : 1.0F);
    state.setTextureAttribute(0, first);
    if (lightmap) {
        osg::ref_ptr second = new osg::TexEnvCombine;
        second->setCombine_RGB(osg::TexEnvCombine::MODULATE);
        second->setSource0_RGB(osg::TexEnvCombine::TEXTURE);
        second->setSource1_RGB(osg::TexEnvCombine::PREVIOUS);
        second->setCombine_Alpha(osg::TexEnvCombine::REPLACE);
        second->setSource0_Alpha(osg::TexEnvCombine::PREVIOUS);
        second->setScale_RGB(largestLight(settings_));
        state.setTextureAttribute(1, second);
    }
    if (!material.alphaTested || settings_.renderer != pie::engine::Renderer::Fixed) return;
    osg::ref_ptr test = new osg::AlphaFunc(osg::AlphaFunc::GEQUAL, 0.5F);
    switch (level_->shaders[key.shader].stages.front().alphaTest) {
    case AlphaTest::GreaterZero: test->setFunction(osg::AlphaFunc::GREATER, 0.0F); break;
    case AlphaTest::Less128: test->setFunction(osg::AlphaFunc::LESS, 0.5F); break;
    case AlphaTest::GreaterEqual128:
    case AlphaTest::None: break;
    }
    state.setAttributeAndModes(test);
}

} // namespace osgpie
