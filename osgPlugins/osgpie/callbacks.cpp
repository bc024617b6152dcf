#include "osgPlugins/osgpie/callbacks.h"

#include <osg/FrameStamp>
#include <osg/NodeVisitor>

namespace osgpie {

void AdvanceCallback::operator()(osg::Node* node, osg::NodeVisitor* visitor) {
    const osg::FrameStamp* stamp = visitor ? visitor->getFrameStamp() : nullptr;
    const unsigned frame = stamp ? stamp->getFrameNumber() : lastFrame_ + 1;
    if (!started_ || frame != lastFrame_) {
        engine_->advance();
        started_ = true;
        lastFrame_ = frame;
    }
    traverse(node, visitor);
}

IrradianceCallback::IrradianceCallback(std::shared_ptr<pie::engine::Engine> engine,
                                       std::vector<std::uint32_t> receivers,
                                       std::vector<std::uint32_t> receiverOfVertex,
                                       osg::ref_ptr<osg::Vec4Array> colours, float scale)
    : engine_(std::move(engine)), receivers_(std::move(receivers)), receiverOfVertex_(std::move(receiverOfVertex)),
      colours_(std::move(colours)), scale_(scale), irradiance_(receivers_.size()) {}

bool IrradianceCallback::refresh() const {
    const std::uint64_t revision = engine_->lightRevision();
    if (revision == revision_) return false;
    engine_->irradiance(receivers_, irradiance_);
    osg::Vec4Array& colours = *colours_;
    for (std::size_t i = 0; i < receiverOfVertex_.size(); ++i) {
        const pie::Rgb light = irradiance_[receiverOfVertex_[i]] * scale_;
        colours[i].set(light.x, light.y, light.z, colours[i].a());
    }
    colours.dirty();
    revision_ = revision;
    return true;
}

void IrradianceCallback::drawImplementation(osg::RenderInfo& renderInfo, const osg::Drawable* drawable) const {
    const std::lock_guard lock(mutex_);
    refresh();
    drawable->drawImplementation(renderInfo);
}

} // namespace osgpie
