// Lights that change: what the gather holds of them is renewed, to the bit of what it would have been without the past.

#include "pie/gather/cached_gather.h"
#include "pie/photons/tracer.h"
#include "tests/gather/scenes.h"
#include "tests/lights/rooms.h"

#include <gtest/gtest.h>

#include <limits>

namespace pie::gather {
namespace {

using pie::test::lamp;
using test::all;
using test::relativeRms;

/// A white room with a wall in the middle.
struct Room {
    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<intersect::Intersector> intersector;
    scene::Receivers receivers;

    Room() {
        test::SceneBuilder builder;
        builder.grey(0.6F);
        builder.room(Vec3(0.0F), Vec3(100.0F));
        builder.room(Vec3(45.0F, 0.0F, 0.0F), Vec3(50.0F, 70.0F, 100.0F));
        scene = builder.make();
        intersector = intersect::makeIntersector(intersect::Kind::Embree, *scene, {});
        std::vector<scene::Receiver> points;
        for (int x = 0; x < 6; ++x)
            for (int y = 0; y < 12; ++y)
                points.push_back(test::receiverAt(
                    Vec3(3.0F + 7.0F * static_cast<float>(x), 4.0F + 8.0F * static_cast<float>(y), 0.0F),
                    Vec3(0, 0, 1)));
        receivers = test::receiversAt(points);
    }

    /// Photons of these frames, 2000 each.
    [[nodiscard]] std::vector<photons::Photon> photons(const lights::LightSet& lights, std::uint64_t first,
                                                       std::uint64_t frames, bool firstHits) const {
        photons::TracerOptions options;
        options.storeDirectLight = firstHits;
        std::vector<photons::Photon> result;
        photons::PhotonTracer(*scene, lights, *intersector, options).trace(2000 * first, 2000 * frames, 2000, result);
        return result;
    }
};

/// A gather over the room with all it needs.
struct Gathering {
    const Room& room;
    lights::LightSet lights, changing;
    DirectLight direct, changingDirect;
    CachedGather gather;

    Gathering(const Room& theRoom, const std::vector<lights::Light>& still, const std::vector<lights::Light>& moving,
              bool byPhotons)
        : room(theRoom), lights(still, room.scene), changing(moving, room.scene),
          direct(*room.scene, lights, *room.intersector, room.receivers),
          changingDirect(*room.scene, changing, *room.intersector, room.receivers),
          gather(*room.scene, lights, *room.intersector, room.receivers, &direct, options(byPhotons)) {}

    static GatherOptions options(bool byPhotons) {
        GatherOptions options;
        options.texelsByPhotons = byPhotons;
        return options;
    }
    void finish() { gather.refine(all(room.receivers), std::numeric_limits<std::uint64_t>::max()); }
    [[nodiscard]] std::vector<Rgb> light() const {
        std::vector<Rgb> result(room.receivers.points.size());
        gather.estimate(all(room.receivers), result);
        return result;
    }
};

const lights::Light left = lamp(Vec3(20, 40, 60), Rgb(4e8F, 2e8F, 1e8F));
const lights::Light right = lamp(Vec3(80, 80, 50), Rgb(1e8F, 3e8F, 1e8F));

TEST(ChangingLights, GiveWhatTheyWouldGiveIfTheyStoodStill) {
    const Room room;
    Gathering apart(room, {left}, {right}, false);
    apart.gather.add(room.photons(apart.lights, 0, 200, false), 200 * PhotonSums::batches);
    apart.gather.setChanging(&apart.changingDirect, 3e8);
    apart.gather.addChanging(room.photons(apart.changing, 0, 200, true), 200 * PhotonSums::batches);
    apart.finish();
    Gathering together(room, {left, right}, {}, false);
    together.gather.add(room.photons(together.lights, 0, 200, false), 200 * PhotonSums::batches);
    together.finish();
    EXPECT_LT(relativeRms(apart.light(), together.light()), 0.03)
        << "noise of 400,000 photons, and texels are lit by first hits instead of shadow rays";
}

TEST(ChangingLights, LeaveNothingBehindWhenTheyMove) {
    const Room room;
    const lights::LightSet before({lamp(Vec3(70, 80, 90), Rgb(9e8F))}, room.scene);
    Gathering moved(room, {left}, {right}, false);
    moved.gather.add(room.photons(moved.lights, 0, 4, false), 4 * PhotonSums::batches);
    moved.gather.setChanging(&moved.changingDirect, 9e8);
    const auto past = room.photons(before, 0, 1, true);
    moved.changingDirect.change(before);
    moved.gather.addChanging(past);
    moved.finish();
    (void)moved.light();
    moved.gather.removeChanging(past);
    moved.changingDirect.change(moved.changing);
    moved.gather.addChanging(room.photons(moved.changing, 0, 1, true));
    moved.gather.update();

    Gathering fresh(room, {left}, {right}, false);
    fresh.gather.add(room.photons(fresh.lights, 0, 4, false), 4 * PhotonSums::batches);
    fresh.gather.setChanging(&fresh.changingDirect, 9e8);
    fresh.gather.addChanging(room.photons(fresh.changing, 0, 1, true));
    fresh.finish();
    EXPECT_EQ(moved.light(), fresh.light());
}

TEST(ChangingLights, ALightThatGoesOutTakesItsLightAlong) {
    const Room room;
    for (const bool byPhotons : {false, true}) {
        Gathering edited(room, {left, right}, {}, byPhotons);
        edited.gather.add(room.photons(edited.lights, 0, 4, byPhotons), 4 * PhotonSums::batches);
        edited.finish();
        lights::LightSet alone = edited.lights;
        alone.muteAllBut(1);
        edited.gather.mute(1, lights::LightSet({right}, room.scene));
        edited.gather.takeBack(room.photons(alone, 0, 4, byPhotons));
        edited.gather.update();
        lights::LightSet rest = edited.lights;
        rest.mute(1);

        // The same photons of the other light, and never any of this one.
        Gathering fresh(room, {left, right}, {}, byPhotons);
        fresh.direct.mute(
            1, DirectLight(*room.scene, lights::LightSet({right}, room.scene), *room.intersector, room.receivers));
        fresh.gather.mute(1, lights::LightSet({right}, room.scene));
        fresh.gather.add(room.photons(rest, 0, 4, byPhotons), 4 * PhotonSums::batches);
        fresh.finish();
        EXPECT_LT(relativeRms(edited.light(), fresh.light()), 1e-5) << byPhotons;
        const auto rough = [&] {
            std::size_t count = 0;
            for (const std::uint32_t r : all(room.receivers)) count += edited.direct.rough(r) ? 1 : 0;
            return count;
        };
        EXPECT_GT(rough(), 5U) << "what the light shone on";
        EXPECT_LT(rough(), room.receivers.points.size()) << "and no more";
        edited.finish();
        EXPECT_EQ(rough(), 0U);
        EXPECT_LT(relativeRms(edited.light(), fresh.light()), 1e-5) << byPhotons;
    }
}

TEST(ChangingLights, ClearForgetsPhotonsAlone) {
    const Room room;
    Gathering gathering(room, {left}, {}, true);
    gathering.gather.add(room.photons(gathering.lights, 0, 2, true), 2 * PhotonSums::batches);
    gathering.finish();
    const std::vector<Rgb> before = gathering.light();
    gathering.gather.add(room.photons(gathering.lights, 2, 2, true), 2 * PhotonSums::batches);
    gathering.gather.update();
    EXPECT_NE(gathering.light(), before);
    gathering.gather.clear();
    gathering.gather.add(room.photons(gathering.lights, 0, 2, true), 2 * PhotonSums::batches);
    gathering.gather.update();
    EXPECT_EQ(gathering.light(), before);
}

} // namespace
} // namespace pie::gather
