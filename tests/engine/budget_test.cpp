// What fits into a frame, and when there is enough: against clocks and errors that are made up, and through Transport
// where neither may change what a still view ends with.

#include "pie/engine/convergence.h"
#include "pie/engine/frame_budget.h"
#include "tests/engine/lit_room.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

namespace pie::engine {
namespace {

using gather::test::receiverAt;
using gather::test::SceneBuilder;
using Kind = FrameBudget::Kind;

/// A machine on which every kind of work has its price, give or take a tenth.
struct Machine {
    double still = 0.2, changing = 0.8, ray = 1e-4, receiver = 1e-4, upload = 0.2;
    std::mt19937 random{5};
    double spent = 0;

    void frame(FrameBudget& budget, const FrameBudget::Work& work) {
        std::uniform_real_distribution<double> some(0.9, 1.1);
        budget.begin();
        spent = 0;
        const FrameBudget::Plan plan = budget.plan(work, 16, 200'000);
        const auto report = [&](Kind kind, double units, double price) {
            if (!(units > 0)) return;
            const double ms = units * price * some(random);
            spent += ms;
            budget.report(kind, units, ms);
        };
        report(Kind::TraceStill, plan.still, still);
        report(Kind::TraceChanging, plan.changing, changing);
        report(Kind::Refine, static_cast<double>(plan.rays), ray);
        report(Kind::Answer, static_cast<double>(plan.receivers), receiver);
        for (int drawable = 0; drawable < 10; ++drawable) report(Kind::Upload, 1, upload / 10);
    }
};

TEST(FrameBudget, WithoutABoundAFrameIsAFrame) {
    FrameBudget budget(0);
    EXPECT_FALSE(budget.bounded());
    const FrameBudget::Plan plan = budget.plan({100, 3, true, 5000}, 16, 7777);
    EXPECT_EQ(plan.still, 16U);
    EXPECT_EQ(plan.changing, 3U);
    EXPECT_EQ(plan.rays, 7777U);
    EXPECT_EQ(plan.receivers, 5000U);
    EXPECT_EQ(budget.plan({7, 0, false, 0}, 16, 7777).still, 7U);
}

TEST(FrameBudget, IsHeldWhateverThereIsToDo) {
    for (const double milliseconds : {2.0, 8.0, 33.0})
        for (const FrameBudget::Work& work :
             {FrameBudget::Work{1000, 0, false, 4000}, FrameBudget::Work{1000, 40, true, 4000},
              FrameBudget::Work{0, 0, true, 60'000}, FrameBudget::Work{1000, 40, true, 400'000}}) {
            FrameBudget budget(milliseconds);
            Machine machine;
            for (int i = 0; i < 200; ++i) machine.frame(budget, work);
            EXPECT_LE(budget.percentile95(), 1.1 * milliseconds) << milliseconds << " ms, " << work.receivers;
            EXPECT_GE(budget.median(), 0.5 * milliseconds) << "time is used: " << milliseconds << ' ' << work.receivers;
        }
}

TEST(FrameBudget, WhatCannotFitIsDoneInTheSmallestSteps) {
    FrameBudget budget(0.1);
    Machine machine;
    for (int i = 0; i < 50; ++i) machine.frame(budget, {1000, 40, true, 1000});
    const FrameBudget::Plan plan = budget.plan({1000, 40, true, 1000}, 16, 1);
    EXPECT_EQ(plan.still, 1U);
    EXPECT_EQ(plan.changing, 1U);
    EXPECT_GT(plan.rays, 0U);
}

TEST(FrameBudget, AnswersThatDoNotFitAreSpreadOverFrames) {
    FrameBudget budget(8);
    Machine machine;
    const FrameBudget::Work work{0, 0, false, 200'000}; // 20 ms
    for (int i = 0; i < 50; ++i) machine.frame(budget, work);
    const auto alone = budget.plan(work, 16, 1).receivers;
    EXPECT_GT(alone, 40'000U);
    EXPECT_LT(alone, 80'000U);
    EXPECT_LT(budget.plan({0, 0, true, 200'000}, 16, 1).receivers, alone) << "others want some of it";
    EXPECT_EQ(budget.plan({0, 0, false, 700}, 16, 1).receivers, 700U);
}

gather::Estimate estimate(float light, float error) { return {Rgb(light), error, 0, 0, 0}; }

TEST(Convergence, RelativeErrorIsTheRootMeanSquareAndTheDarkDoesNotCount) {
    EXPECT_NEAR(relativeError(std::vector{estimate(100, 3), estimate(200, 8)}), std::sqrt((9 + 16) / 2.0), 1e-5);
    // A twentieth of the mean of 50 is 2.5.
    EXPECT_NEAR(relativeError(std::vector{estimate(100, 0), estimate(0, 0.25F)}), std::sqrt(100 / 2.0), 1e-4);
    EXPECT_EQ(relativeError({}), 0.0);
    EXPECT_EQ(relativeError(std::vector{estimate(0, 1)}), 0.0);
}

TEST(Convergence, StopsAtTheTargetOrWherePhotonsHelpNoMore) {
    Convergence none(0);
    EXPECT_FALSE(none.wanted());
    EXPECT_FALSE(none.due(1'000'000));
    for (const double floor : {0.0, 3.0}) { // noise of rays, per cent
        Convergence convergence(2);
        std::uint64_t parts = 0;
        while (!convergence.done()) {
            ASSERT_LT(++parts, 1'000'000U);
            if (!convergence.due(parts)) continue;
            const double error = std::hypot(floor, 50 / std::sqrt(static_cast<double>(parts)));
            convergence.judge(std::vector{estimate(100, static_cast<float>(error))}, parts);
        }
        if (floor == 0.0) {
            EXPECT_LE(convergence.errorPercent(), 2.0);
            EXPECT_LE(parts, 625U * 5 / 4 + 1);
        } else {
            EXPECT_NEAR(convergence.errorPercent(), 3.0, 0.2);
        }
        convergence.restart();
        EXPECT_FALSE(convergence.done());
        EXPECT_LT(convergence.errorPercent(), 0.0);
    }
}

const lights::Light lamp = lights::PointLight{Vec3(40, 50, 60), Rgb(4e7F), {}};

/// Many receivers on the floor of an empty room.
struct Room : test::LitRoom {
    Room() : LitRoom(makeScene(), makePoints()) {}

    static std::shared_ptr<const scene::Scene> makeScene() {
        SceneBuilder builder;
        builder.grey(0.6F);
        builder.room(Vec3(0.0F), Vec3(100.0F));
        return builder.make();
    }
    static std::vector<scene::Receiver> makePoints() {
        std::vector<scene::Receiver> points;
        for (int x = 0; x < 32; ++x)
            for (int y = 0; y < 48; ++y)
                points.push_back(
                    receiverAt(Vec3(2.0F + 3.0F * static_cast<float>(x), 2.0F + 2.0F * static_cast<float>(y), 0.0F),
                               Vec3(0, 0, 1)));
        return points;
    }
    /// Frames until the light stands still; drawn in batches, as drawables are.
    std::vector<Rgb> settle(const Settings& settings, Statistics& statistics) const {
        Transport engine = transport({lamp}, settings);
        std::vector<Rgb> light(which.size());
        int frames = 0;
        while (engine.advance() && ++frames < 20'000)
            for (std::size_t first = 0; first < which.size(); first += 64)
                engine.irradiance(std::span(which).subspan(first, 64), std::span(light).subspan(first, 64));
        EXPECT_LT(frames, 20'000) << "never still";
        statistics = engine.statistics();
        return light;
    }
};

TEST(Transport, ABudgetChangesWhenThingsAreDoneNotWhatStaysInTheEnd) {
    const Room room;
    for (const EstimatorKind kind : {EstimatorKind::Gather, EstimatorKind::TrueArea}) {
        Settings settings;
        settings.estimator = kind;
        settings.photonsFromLight = 3000;
        settings.stillFrames = 10;
        settings.accumulationFrames = 4;
        Statistics statistics;
        const std::vector<Rgb> free = room.settle(settings, statistics);
        EXPECT_EQ(statistics.estimatesDeferred, 0U);
        settings.budgetMs = 0.3F;
        const std::vector<Rgb> bounded = room.settle(settings, statistics);
        EXPECT_TRUE(statistics.still);
        EXPECT_GT(statistics.frameMs95, 0.0);
        EXPECT_GT(statistics.estimatesDeferred, 0U) << "so tight that answers had to wait";
        if (kind != EstimatorKind::Gather) continue; // there a frame is as large as its time allows
        EXPECT_EQ(std::memcmp(free.data(), bounded.data(), free.size() * sizeof(Rgb)), 0);
    }
}

// Whoever takes a picture draws once, runs updates until the light stands still, and draws again.
TEST(Transport, WhenItSaysStillTheAnswersAreThoseOfTheLightThatIsThere) {
    const Room room;
    std::vector<std::vector<Rgb>> results;
    for (const float budget : {0.0F, 0.3F}) {
        Settings settings;
        settings.photonsFromLight = 3000;
        settings.stillFrames = 10;
        settings.budgetMs = budget;
        Transport transport = room.transport({lamp}, settings);
        std::vector<Rgb> light(room.which.size());
        transport.advance();
        transport.irradiance(room.which, light);
        int frames = 0;
        while (transport.advance()) ASSERT_LT(++frames, 20'000);
        EXPECT_TRUE(transport.irradiance(room.which, light)) << "nothing older is left";
        EXPECT_FALSE(transport.advance());
        results.push_back(light);
    }
    EXPECT_EQ(std::memcmp(results[0].data(), results[1].data(), results[0].size() * sizeof(Rgb)), 0);
}

TEST(Transport, ATargetIsReachedAndThenNothingIsDone) {
    const Room room;
    Settings settings;
    settings.photonsFromLight = 1000;
    std::uint64_t before = 0;
    for (const float target : {8.0F, 3.0F, 1.5F}) {
        settings.targetError = target;
        Statistics statistics;
        room.settle(settings, statistics);
        EXPECT_TRUE(statistics.still);
        EXPECT_GT(statistics.errorPercent, 0.0);
        EXPECT_LE(statistics.errorPercent, static_cast<double>(target));
        EXPECT_GE(statistics.photonsEmitted, before) << "smaller errors take more photons";
        before = statistics.photonsEmitted;
    }
}

} // namespace
} // namespace pie::engine
