#include "osgPlugins/osgpie/flashlight.h"

#include <osgUtil/CullVisitor>

#include <numbers>

namespace osgpie {
namespace {

/// Held below the eye, so that shadows can be seen past what casts them.
constexpr float below = 8;    // units
constexpr float slope = 0.5F; // the cone's radius at distance 1
// A torch has a lens: within this distance it is hardly brighter than at it, so that a wall close by is not all white
// while the end of a hall can be seen.
constexpr float reach = 160;       // units
constexpr float wattsOfIntensity = // of a light entity, see lights::Light
    4.0F * std::numbers::pi_v<float> * 7500.0F;

} // namespace

void Flashlight::operator()(osg::Node* node, osg::NodeVisitor* visitor) {
    if (const osgUtil::CullVisitor* cull = visitor ? visitor->asCullVisitor() : nullptr) {
        const std::lock_guard lock(mutex_);
        seen_ = View{cull->getEyeLocal(), cull->getLookVectorLocal()};
    }
    traverse(node, visitor);
}

void Flashlight::follow(bool on) {
    if (!on) {
        if (lit_ && number_) engine_->setLight(*number_, std::nullopt);
        lit_.reset();
        return;
    }
    std::optional<View> view;
    {
        const std::lock_guard lock(mutex_);
        view = seen_;
    }
    if (!view || view == lit_) return;
    lit_ = view;
    if (!number_) number_ = engine_->lightCount();
    const auto& settings = engine_->settings();
    pie::lights::SpotLight spot;
    spot.position = {view->eye.x(), view->eye.y(), view->eye.z() - below};
    spot.direction = {view->look.x(), view->look.y(), view->look.z()};
    spot.power = pie::Rgb(wattsOfIntensity * settings.flashlightIntensity * settings.lightScale);
    spot.slope = slope;
    spot.falloff.extraDistance = reach;
    engine_->setLight(*number_, spot);
}

} // namespace osgpie
