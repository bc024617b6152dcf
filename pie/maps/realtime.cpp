#include "pie/maps/realtime.h"

#include <algorithm>

namespace pie::maps {

using photons::Photon;

RealtimeMap::RealtimeMap(std::size_t accumulationFrames, Search search, std::shared_ptr<const Partition> partition)
    : frames_(std::max<std::size_t>(1, accumulationFrames)), partition_(std::move(partition)) {
    if (search == Search::Exact)
        map_.emplace<ExactMap>();
    else if (partition_ != nullptr)
        map_.emplace<SplitTree>(partition_);
}

void RealtimeMap::setAccumulationFrames(std::size_t count) {
    count = std::max<std::size_t>(1, count);
    if (count < frames_.size()) {
        // Newest first; empty slots, whose age is 0, last. The survivors go back to the order of their slots.
        std::vector<Frame*> newest;
        newest.reserve(frames_.size());
        for (Frame& frame : frames_) newest.push_back(&frame);
        std::stable_sort(newest.begin(), newest.end(), [](const Frame* a, const Frame* b) { return a->age > b->age; });
        newest.resize(count);
        std::sort(newest.begin(), newest.end());
        std::vector<Frame> kept;
        kept.reserve(count);
        for (Frame* frame : newest) kept.push_back(std::move(*frame));
        frames_ = std::move(kept);
    }
    frames_.resize(count);
}

std::size_t RealtimeMap::framesPresent() const {
    return static_cast<std::size_t>(
        std::count_if(frames_.begin(), frames_.end(), [](const Frame& frame) { return frame.age != 0; }));
}

std::size_t RealtimeMap::oldestSlot() const {
    const auto oldest =
        std::min_element(frames_.begin(), frames_.end(), [](const Frame& a, const Frame& b) { return a.age < b.age; });
    return static_cast<std::size_t>(oldest - frames_.begin());
}

std::vector<Photon> RealtimeMap::replaceOldest(std::vector<Photon>&& photons) {
    return replaceFrame(oldestSlot(), std::move(photons));
}

std::vector<Photon> RealtimeMap::replaceFrame(std::size_t slot, std::vector<Photon>&& photons) {
    Frame& frame = frames_[slot];
    frame.age = ++arrivals_;
    return std::exchange(frame.photons, std::move(photons));
}

std::vector<Photon> RealtimeMap::removeFrame(std::size_t slot) {
    frames_[slot].age = 0;
    return std::exchange(frames_[slot].photons, {});
}

void RealtimeMap::clear() {
    for (Frame& frame : frames_) frame = {};
}

void RealtimeMap::rebuild() {
    std::size_t total = 0;
    for (const Frame& frame : frames_) total += frame.photons.size();
    std::vector<Photon> all = std::visit([](auto& map) { return map.release(); }, map_);
    all.clear();
    all.reserve(total);
    ++revision_;
    frameEnds_.clear();
    for (const Frame& frame : frames_) {
        if (frame.age == 0) continue;
        all.insert(all.end(), frame.photons.begin(), frame.photons.end());
        frameEnds_.push_back(static_cast<std::uint32_t>(all.size()));
    }
    std::visit([&](auto& map) { map.build(std::move(all)); }, map_);
    const std::size_t present = framesPresent();
    fluxScale_ = present == 0 ? 0.0F : 1.0F / static_cast<float>(present);
}

std::span<const Photon> RealtimeMap::photons() const {
    return visit([](const auto& map) { return map.photons(); });
}

Box RealtimeMap::bounds() const {
    return visit([](const auto& map) { return map.bounds(); });
}

std::size_t RealtimeMap::bytes() const {
    std::size_t total = visit([](const auto& map) { return map.bytes(); });
    for (const Frame& frame : frames_) total += frame.photons.capacity() * sizeof(Photon);
    return total;
}

} // namespace pie::maps
