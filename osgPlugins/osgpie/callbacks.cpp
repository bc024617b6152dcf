#include "osgPlugins/osgpie/callbacks.h"

#include "osgPlugins/osgpie/level_node.h"
#include "pie/core/clock.h"
#include "pie/level/names.h"

#include <osg/BufferObject>
#include <osg/FrameStamp>
#include <osg/NodeVisitor>
#include <osg/Notify>
#include <osg/RenderInfo>
#include <osg/State>
#include <osg/ValueObject>

namespace osgpie {

void AdvanceCallback::announce() {
    engine_->prepare();
    const pie::lights::ImportedLights& found = engine_->lights();
    const std::string kind = pie::level::lower(pie::level::extension(engine_->level().file));
    OSG_NOTICE << '[' << kind << "] " << engine_->level().name << ": light: " << found.summary() << std::endl;
    for (const std::string& warning : found.warnings)
        OSG_INFO << '[' << kind << "] " << engine_->level().name << ": " << warning << std::endl;
}

void AdvanceCallback::announceStill() {
    if (!osg::isNotifyEnabled(osg::INFO)) return;
    const pie::engine::Statistics statistics = engine_->statistics();
    OSG_INFO << "[pie] " << engine_->level().name << ": light stands still after " << statistics.photonsEmitted
             << " photons and " << statistics.frames << " frames";
    if (statistics.errorPercent >= 0) OSG_INFO << "; standard error " << statistics.errorPercent << " %";
    OSG_INFO << std::endl;
}

void AdvanceCallback::operator()(osg::Node* node, osg::NodeVisitor* visitor) {
    if (!node) return;
    const osg::FrameStamp* stamp = visitor ? visitor->getFrameStamp() : nullptr;
    const unsigned frame = stamp ? stamp->getFrameNumber() : lastFrame_ + 1;
    if (!started_ || frame != lastFrame_) {
        if (!started_) {
            if (auto* level = dynamic_cast<LevelNode*>(node)) level->complete();
            announce();
        }
        if (views_) views_->update();
        if (flashlight_) flashlight_->follow(!views_ || views_->flashlight());
        const bool settled = (views_ && !views_->showsOurLight()) || !engine_->advance();
        if (!started_ || settled != settled_) {
            node->setUserValue("pie.settled", settled);
            if (settled) announceStill();
        }
        settled_ = settled;
        if (engine_->settings().stats) node->setUserValue("pie.statistics", engine_->statistics().json());
        started_ = true;
        lastFrame_ = frame;
    }
    traverse(node, visitor);
}

IrradianceCallback::IrradianceCallback(std::shared_ptr<pie::engine::Engine> engine,
                                       std::vector<std::uint32_t> receivers,
                                       std::vector<std::uint32_t> receiverOfVertex,
                                       const osg::ref_ptr<osg::Vec4Array>& colours, float scale,
                                       std::shared_ptr<const ViewSwitch> views)
    : engine_(std::move(engine)), receivers_(std::move(receivers)), receiverOfVertex_(std::move(receiverOfVertex)),
      colours_(colours), scale_(scale), views_(std::move(views)), irradiance_(receivers_.size()) {}

bool IrradianceCallback::refresh() const {
    const std::uint64_t revision = engine_->lightRevision();
    const bool samples = views_ && views_->showsSamples();
    if (revision == revision_ && samples == samplesShown_) return false;
    samplesShown_ = samples;
    const bool current = fetch(samples);
    const float scale = samples ? 1.0F : scale_;
    osg::Vec4Array& colours = *colours_;
    for (std::size_t i = 0; i < receiverOfVertex_.size(); ++i) {
        const pie::Rgb light = irradiance_[receiverOfVertex_[i]] * scale;
        colours[i].set(light.x, light.y, light.z, colours[i].a());
    }
    colours.dirty();
    if (current) revision_ = revision; // else some of it is older, and the next draw asks again
    return true;
}

/// Light, or the colours of how many rays it rests on. Returns whether that is up to date.
bool IrradianceCallback::fetch(bool samples) const {
    if (!samples) return engine_->irradiance(receivers_, irradiance_);
    std::vector<std::uint32_t> counts(receivers_.size());
    engine_->samples(receivers_, counts);
    const auto most = static_cast<float>(largestSampleCount(engine_->settings()));
    for (std::size_t i = 0; i < counts.size(); ++i) irradiance_[i] = sampleColour(static_cast<float>(counts[i]), most);
    return true;
}

/// Sends the colours now rather than in the midst of drawing, so that its time is known.
void IrradianceCallback::upload(osg::RenderInfo& renderInfo) const {
    const auto start = pie::Clock::now();
    osg::GLBufferObject* buffer = colours_->getOrCreateGLBufferObject(renderInfo.getContextID());
    if (buffer && buffer->isDirty()) {
        buffer->compileBuffer();
        // The state of OSG does not know that its array buffer was bound past it.
        renderInfo.getState()->unbindVertexBufferObject();
    }
    engine_->countUpload(pie::millisecondsSince(start));
}

void IrradianceCallback::drawImplementation(osg::RenderInfo& renderInfo, const osg::Drawable* drawable) const {
    const std::lock_guard lock(mutex_);
    if (refresh()) upload(renderInfo);
    drawable->drawImplementation(renderInfo);
}

} // namespace osgpie
