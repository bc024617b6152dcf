#pragma once
// OpenGL state of a level's surfaces: textures, lightmaps, programs and blending, each made once and shared.

#include "osgPlugins/osgpie/material_program.h"
#include "osgPlugins/osgpie/view_switch.h"
#include "pie/engine/settings.h"
#include "pie/level/level.h"

#include <osg/Program>
#include <osg/StateSet>
#include <osg/Texture2D>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <tuple>

namespace osgpie {

/// What tells one drawable's state from another's.
struct StateKey {
    std::uint32_t shader = 0;
    std::int32_t lightmap = pie::level::noLightmap;
    std::int32_t fog = -1;
    bool operator==(const StateKey&) const = default;
    friend bool operator<(const StateKey& a, const StateKey& b) {
        return std::tie(a.shader, a.lightmap, a.fog) < std::tie(b.shader, b.lightmap, b.fog);
    }
};

class StateSets {
public:
    StateSets(std::shared_ptr<const pie::level::Level> level, const pie::engine::Settings& settings);

    struct Entry {
        osg::ref_ptr<osg::StateSet> state; ///< null: nothing to draw
        bool lit = false;
        bool lightmapCoordinates = false; ///< the drawable needs texture coordinates 1
        LightSource light = LightSource::None;
        bool baked = false; ///< the drawable needs the level's own light as its secondary colour
    };
    /// The state of surfaces with this key; made at the first call.
    const Entry& get(const StateKey& key);
    /// Null unless views switch.
    [[nodiscard]] const std::shared_ptr<ViewSwitch>& viewSwitch() const { return viewSwitch_; }
    /// The level's sky behind everything; null if there is none or it is switched off.
    [[nodiscard]] osg::ref_ptr<osg::Node> makeSky();

private:
    std::shared_ptr<const pie::level::Level> level_;
    const pie::engine::Settings& settings_;
    std::shared_ptr<ViewSwitch> viewSwitch_;
    std::map<StateKey, Entry> entries_;
    std::map<std::pair<std::string, bool>, osg::ref_ptr<osg::Texture2D>> textures_; ///< by image name and clamp
    std::map<std::int32_t, osg::ref_ptr<osg::Texture2D>> lightmaps_;
    std::map<std::pair<std::string, std::string>, osg::ref_ptr<osg::Program>> programs_; ///< by sources
    osg::ref_ptr<osg::Texture2D> white_;
    osg::ref_ptr<osg::Texture2D> missing_;

    [[nodiscard]] Look look(const StateKey& key) const;
    osg::ref_ptr<osg::Texture2D> texture(const std::string& name, bool clamp);
    osg::ref_ptr<osg::Texture2D> lightmap(std::int32_t index);
    osg::ref_ptr<osg::Texture2D> unitTexture(const UnitTexture& unit, const StateKey& key, std::size_t frame = 0);
    osg::ref_ptr<osg::Program> program(const MaterialProgram& material, const std::string& name);
    osg::ref_ptr<osg::StateSet> makeState(const StateKey& key, const MaterialProgram& material);
    void addFixedFunction(osg::StateSet& state, const StateKey& key, const MaterialProgram& material) const;
};

/// The largest light that can be shown: the setting, or where fixed-function rendering multiplies by 1, 2 or 4 only,
/// the next of these.
[[nodiscard]] float largestLight(const pie::engine::Settings& settings);

/// The game's light for a stored byte triple (lightmap texel, vertex colour): 4 · byte / 255, cut at `overbright` with
/// the hue kept, over `overbright`; so 1 means `overbright` (LEVELS in doc/manual.md).
[[nodiscard]] pie::Rgb gameLight(const pie::Rgb& bytes, float overbright);

} // namespace osgpie
