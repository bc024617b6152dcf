#pragma once
// A scene with receivers, and Transports over it.

#include "pie/engine/transport.h"
#include "tests/gather/scenes.h"

#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace pie::engine::test {

struct LitRoom {
    std::shared_ptr<const scene::Scene> scene;
    scene::Receivers receivers;
    std::vector<std::uint32_t> which; ///< all receivers
    level::Tree none;

    LitRoom(std::shared_ptr<const scene::Scene> theScene, std::vector<scene::Receiver> points)
        : scene(std::move(theScene)), receivers(gather::test::receiversAt(std::move(points))),
          which(receivers.points.size()) {
        std::iota(which.begin(), which.end(), 0U);
    }
    [[nodiscard]] Transport transport(const std::vector<lights::Light>& lights, const Settings& settings) const {
        return {makeSurroundings(scene, none, settings), lights, none, receivers, settings};
    }
};

} // namespace pie::engine::test
