#pragma once
// How light gets into the draw: traced in the update stage, fetched in the draw stage for what survived culling.

#include "osgPlugins/osgpie/flashlight.h"
#include "osgPlugins/osgpie/view_switch.h"
#include "pie/engine/engine.h"

#include <osg/Array>
#include <osg/Callback>
#include <osg/Drawable>

#include <memory>
#include <mutex>
#include <vector>

namespace osgpie {

/// Update callback of the level's root: one step of the engine per frame, however many views traverse it. The node's
/// user value "pie.settled" (bool) says whether the light stands still: all photons are there, and what is in view is
/// refined. That it came to stand still is also said at OSG's level INFO.
class AdvanceCallback : public osg::NodeCallback {
public:
    /// `flashlight` and `views` may be null.
    AdvanceCallback(std::shared_ptr<pie::engine::Engine> engine, const osg::ref_ptr<Flashlight>& flashlight,
                    std::shared_ptr<ViewSwitch> views)
        : engine_(std::move(engine)), flashlight_(flashlight), views_(std::move(views)) {}
    void operator()(osg::Node* node, osg::NodeVisitor* visitor) override;

private:
    std::shared_ptr<pie::engine::Engine> engine_;
    osg::ref_ptr<Flashlight> flashlight_;
    std::shared_ptr<ViewSwitch> views_;
    void announce();
    void announceStill();
    unsigned lastFrame_ = 0;
    bool started_ = false, settled_ = false;
};

/// Draw callback of a lit drawable: asks for the irradiance of its receivers when the light has changed, writes it into
/// the colour array and draws. OSG draws in other threads than it updates in, and several contexts may draw one
/// drawable at once: a mutex covers fetching, uploading and drawing.
class IrradianceCallback : public osg::Drawable::DrawCallback {
public:
    /// `receivers`: those of the drawable, each once; `receiverOfVertex`: place in that list for each element of
    /// `colours`. `scale` turns irradiance into colour values. `views` may be null.
    IrradianceCallback(std::shared_ptr<pie::engine::Engine> engine, std::vector<std::uint32_t> receivers,
                       std::vector<std::uint32_t> receiverOfVertex, const osg::ref_ptr<osg::Vec4Array>& colours,
                       float scale, std::shared_ptr<const ViewSwitch> views);
    void drawImplementation(osg::RenderInfo& renderInfo, const osg::Drawable* drawable) const override;
    /// Brings the colours up to date; whether they changed. Called by the draw; for writers of files also without one.
    bool refresh() const;
    [[nodiscard]] const std::vector<std::uint32_t>& receivers() const { return receivers_; }

private:
    void upload(osg::RenderInfo& renderInfo) const;
    std::shared_ptr<pie::engine::Engine> engine_;
    std::vector<std::uint32_t> receivers_, receiverOfVertex_;
    osg::ref_ptr<osg::Vec4Array> colours_;
    float scale_;
    std::shared_ptr<const ViewSwitch> views_;
    mutable std::mutex mutex_;
    mutable std::vector<pie::Rgb> irradiance_;
    mutable std::uint64_t revision_ = 0;
    mutable bool samplesShown_ = false;
    [[nodiscard]] bool fetch(bool samples) const;
};

} // namespace osgpie
