#pragma once
// Changes what a level shows while it is shown (settings: switch_views). Every program of the level holds all views;
// uniforms on the level's root choose. set… may be called between frames by the thread that runs the update; what they
// change shows in the next frame.

#include "pie/engine/engine.h"

#include <osg/Group>
#include <osg/Uniform>
#include <osg/observer_ptr>

#include <atomic>
#include <memory>

namespace osgpie {

class ViewSwitch {
public:
    ViewSwitch(pie::engine::View view, float exposure);

    void setView(pie::engine::View view);
    [[nodiscard]] pie::engine::View view() const { return view_; }
    /// Divider of View::Split, from −1 (left edge of the picture) to 1.
    void setSplit(float place);
    /// Factor on our light before display, as the setting of that name.
    void setExposure(float exposure);
    /// The light at the view, as the setting of that name.
    void setFlashlight(bool on) { flashlight_ = on; }
    [[nodiscard]] bool flashlight() const { return flashlight_; }
    /// Photons of View::Photons, from the next time it is shown.
    void setPhotonCount(std::uint64_t count) { photonCount_ = count; }
    /// The points of View::Photons and edges are made anew: lights have changed.
    void renewOverlay() { overlayOf_ = pie::engine::View::Lit; }

    /// Whether the view needs photons.
    [[nodiscard]] bool showsOurLight() const;
    /// Any thread.
    [[nodiscard]] bool showsSamples() const { return view_ == pie::engine::View::Samples; }

    /// Called by makeLevelNode: `world` is what is drawn of the level, `sky` may be null.
    void attach(osg::Group& root, const std::shared_ptr<pie::engine::Engine>& engine,
                const osg::ref_ptr<osg::Node>& world, const osg::ref_ptr<osg::Node>& sky);
    /// In the update, once the level is refined: makes the overlay of the present view.
    void update();

private:
    void showSky();

    std::atomic<pie::engine::View> view_;
    pie::engine::View overlayOf_ = pie::engine::View::Lit;
    std::atomic<bool> flashlight_{false};
    std::uint64_t photonCount_ = 20'000;
    osg::ref_ptr<osg::Uniform> viewUniform_, splitUniform_, exposureUniform_;
    std::weak_ptr<pie::engine::Engine> engine_;
    osg::observer_ptr<osg::Node> world_, sky_;
    osg::observer_ptr<osg::Group> overlay_;
};

/// What View::Samples counts up to.
[[nodiscard]] int largestSampleCount(const pie::engine::Settings& settings);
/// Its colours: from dark blue for none over green to yellow for `most`, on a logarithmic scale.
[[nodiscard]] pie::Rgb sampleColour(float count, float most);

} // namespace osgpie
