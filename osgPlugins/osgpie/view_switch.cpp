#include "osgPlugins/osgpie/view_switch.h"

#include "osgPlugins/osgpie/view_overlays.h"
#include "pie/engine/options.h"

#include <osg/StateSet>

#include <algorithm>
#include <cmath>

namespace osgpie {

using pie::engine::View;

ViewSwitch::ViewSwitch(View view, float exposure)
    : view_(view), viewUniform_(new osg::Uniform("pieView", static_cast<int>(view))),
      splitUniform_(new osg::Uniform("pieSplit", 0.0F)), exposureUniform_(new osg::Uniform("pieExposure", exposure)) {}

void ViewSwitch::setView(View view) {
    view_ = view;
    viewUniform_->set(static_cast<int>(view));
    showSky();
}

void ViewSwitch::setSplit(float place) { splitUniform_->set(place); }
void ViewSwitch::setExposure(float exposure) { exposureUniform_->set(exposure); }

bool ViewSwitch::showsOurLight() const {
    switch (view_) {
    case View::Baked:
    case View::Fullbright:
    case View::Lightmap:
    case View::Normals: return false;
    default: return true;
    }
}

void ViewSwitch::attach(osg::Group& root, const std::shared_ptr<pie::engine::Engine>& engine,
                        const osg::ref_ptr<osg::Node>& world, const osg::ref_ptr<osg::Node>& sky) {
    osg::StateSet* state = root.getOrCreateStateSet();
    for (const auto& uniform : {viewUniform_, splitUniform_, exposureUniform_}) {
        uniform->setDataVariance(osg::Object::DYNAMIC);
        state->addUniform(uniform);
    }
    engine_ = engine;
    world_ = world;
    sky_ = sky;
    const osg::ref_ptr overlay = new osg::Group;
    overlay->setName("overlay");
    overlay->addDescription("filled when a view needs it"); // a described group is one that OSG's optimiser keeps
    root.addChild(overlay);
    overlay_ = overlay;
    showSky();
}

void ViewSwitch::showSky() {
    const View view = view_;
    const bool textured = view != View::Light && view != View::Lightmap && view < View::Difference;
    if (sky_.valid()) sky_->setNodeMask(textured ? ~0U : 0U);
}

void ViewSwitch::update() {
    const View view = view_;
    const auto engine = engine_.lock();
    if (view == overlayOf_ || !overlay_.valid() || !engine) return;
    overlayOf_ = view;
    overlay_->removeChildren(0, overlay_->getNumChildren());
    osg::ref_ptr<osg::Node> made;
    if (view == View::Triangles && world_.valid()) made = makeEdges(*world_);
    if (view == View::CoarseTriangles) made = makeCoarseEdges(engine->level());
    if (view == View::Photons) made = makePhotonPoints(engine->photons(photonCount_));
    if (made) overlay_->addChild(made);
}

int largestSampleCount(const pie::engine::Settings& settings) {
    if (!pie::engine::gathers(settings)) return settings.maxSearchCount;
    return static_cast<int>(std::exp2(std::ceil(std::log2(std::max(2, settings.gatherRays)))));
}

pie::Rgb sampleColour(float count, float most) {
    const float t = std::clamp(std::log2(1.0F + count) / std::log2(1.0F + std::max(1.0F, most)), 0.0F, 1.0F);
    constexpr pie::Rgb none(0.20F, 0.05F, 0.35F);
    constexpr pie::Rgb half(0.10F, 0.60F, 0.50F);
    constexpr pie::Rgb all(1.00F, 0.90F, 0.15F);
    return t < 0.5F ? none + (half - none) * (2.0F * t) : half + (all - half) * (2.0F * t - 1.0F);
}

} // namespace osgpie
