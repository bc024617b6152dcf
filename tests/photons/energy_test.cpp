// Closed forms: what a closed room must hold.

#include "tests/photons/traced.h"
#include "tests/sampling/distributions.h"
#include "tests/sampling/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pie::photons {
namespace {

using test::Traced;

void expectBooksBalance(const TraceCounts& c) {
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(c.emittedFlux[i], c.absorbedFlux[i] + c.escapedFlux[i] + c.cutFlux[i],
                    1e-9 * std::abs(c.emittedFlux[i]) + 1e-300)
            << i;
}

/// Furnace: in a closed room of reflectance ρ a lamp of Φ watts makes a mean irradiance of Φ / (A (1 − ρ)). Repetitions
/// are independent seeds; splitting stops at depth 4, which cuts the series 1 + ρ + ρ² … there. The mean must lie
/// within 0.5 % and within 5 of its standard errors (false alarm 6e-7 each).
TEST(Energy, Furnace) {
    for (const float reflectance : {0.0F, 0.3F, 0.5F, 0.8F})
        for (const bool split : {false, true}) {
            constexpr double side = 100.0;
            constexpr double watts = 6e5;
            const double series = (1.0 - (split ? std::pow(reflectance, 5.0) : 0.0)) / (1.0 - reflectance);
            const double expected = watts / (6.0 * side * side) * series;
            test::Moments irradiance;
            for (std::uint64_t seed = 1; seed <= 16; ++seed) {
                auto options = split ? test::splitting(3, true, 4) : test::roulette(true, 200);
                options.seed = seed;
                Traced traced(test::furnace(Rgb(reflectance)),
                              {test::lamp({30, 60, 45}, Rgb(static_cast<float>(watts)))}, options);
                double sum = 0.0;
                for (const Photon& p : traced.trace(0, split ? 100 : 20'000)) sum += p.flux.x;
                irradiance.add(sum / (6.0 * side * side));
                expectBooksBalance(traced.counts);
                EXPECT_EQ(traced.counts.escaped + traced.counts.backHits, 0U) << "a closed room is closed";
            }
            EXPECT_NEAR(irradiance.mean() / expected, 1.0, 0.005)
                << reflectance << (split ? " splitting" : " roulette");
            EXPECT_LT(std::abs(test::zScore(irradiance.mean(), expected,
                                            irradiance.squaredError() + 1e-10 * expected * expected)),
                      5.0)
                << reflectance << (split ? " splitting " : " roulette ") << irradiance.mean() << ' ' << expected;
        }
}

class EveryDistribution : public testing::TestWithParam<sampling::Distribution> {};
INSTANTIATE_TEST_SUITE_P(Energy, EveryDistribution, testing::ValuesIn(test::allDistributions),
                         [](const auto& test) { return pie::test::distributionName(test.param); });

/// A room half open, with a coloured wall: what is emitted is absorbed, escapes or is cut, in every channel; and what
/// is stored, roulette or not, is what a long run of Halton's says, within 4 standard errors (48 seeds: false alarm
/// 2e-4 each).
TEST_P(EveryDistribution, EmittedIsAbsorbedEscapedOrCut) {
    test::RoomBuilder room;
    const auto grey = room.material(test::opaque(Rgb(0.6F)));
    const auto red = room.material(test::opaque(Rgb(0.9F, 0.3F, 0.1F)));
    const auto open = room.material(test::sky());
    room.inside({0, 0, 0}, {256, 256, 128}, {grey, red, grey, grey, grey, open});
    const std::vector<lights::Light> lamps{
        test::lamp({60, 100, 50}, Rgb(600.0F, 500.0F, 400.0F)),
        lights::makeAreaLight({{30, 30, 100}, {30, 90, 100}, {90, 90, 100}, {90, 30, 100}}, Rgb(0.1F), true)};
    for (const bool split : {false, true}) {
        TracerOptions options = split ? test::splitting(4, true, 4) : test::roulette(true, 4);
        Traced reference(room.build(), lamps, options);
        const std::uint64_t many = split ? 3000 : 100'000;
        const auto stored = [](const std::vector<Photon>& photons) {
            glm::dvec3 sum(0.0);
            for (const Photon& p : photons) sum += glm::dvec3(p.flux);
            return sum;
        };
        const glm::dvec3 expected = stored(reference.trace(0, many));

        options.lightDistribution = options.diffuseDistribution = GetParam();
        options.photonsPerFrame = split ? 25 : 500;
        std::array<test::Moments, 3> flux;
        std::array<test::Moments, 3> books;
        for (std::uint64_t seed = 1; seed <= 48; ++seed) {
            options.seed = seed;
            Traced traced(room.build(), lamps, options);
            const auto photons = traced.trace(seed * options.photonsPerFrame, options.photonsPerFrame);
            const glm::dvec3 sum = stored(photons);
            expectBooksBalance(traced.counts);
            for (int c = 0; c < 3; ++c) {
                flux.at(static_cast<std::size_t>(c)).add(sum[c]);
                books.at(static_cast<std::size_t>(c)).add(traced.counts.emittedFlux[c]);
            }
        }
        for (std::size_t c = 0; c < 3; ++c) {
            // The reference has an error of its own, about a thousandth.
            const double square =
                flux[c].squaredError() + 1e-6 * expected[static_cast<int>(c)] * expected[static_cast<int>(c)];
            EXPECT_LT(std::abs(test::zScore(flux[c].mean(), expected[static_cast<int>(c)], square)), 4.0)
                << (split ? "split " : "roulette ") << c << ' ' << flux[c].mean() << ' '
                << expected[static_cast<int>(c)];
            const double power = reference.lights().totalPower()[static_cast<int>(c)];
            EXPECT_LT(std::abs(test::zScore(books[c].mean(), power, books[c].squaredError() + 1e-10 * power * power)),
                      4.0);
        }
    }
}

/// The furnace for every distribution: Φ / (A (1 − ρ)) within 4 standard errors (64 seeds: false alarm 2e-4 each) and
/// 0.7 %.
TEST_P(EveryDistribution, Furnace) {
    for (const double reflectance : {0.2, 0.5, 0.8}) {
        test::Moments sums;
        for (std::uint64_t seed = 1; seed <= 64; ++seed) {
            TracerOptions options = test::roulette(true, 200);
            options.lightDistribution = options.diffuseDistribution = GetParam();
            options.photonsPerFrame = 1000;
            options.seed = seed;
            Traced traced(test::furnace(Rgb(static_cast<float>(reflectance))), {test::lamp({30, 60, 45}, Rgb(1.0F))},
                          options);
            double sum = 0.0;
            for (const Photon& p : traced.trace(0, 1000)) sum += p.flux.x;
            sums.add(sum);
        }
        const double expected = 1.0 / (1.0 - reflectance);
        EXPECT_NEAR(sums.mean() / expected, 1.0, 0.007) << reflectance;
        EXPECT_LT(std::abs(test::zScore(sums.mean(), expected, sums.squaredError() + 1e-10)), 4.0) << reflectance;
    }
}

/// Without stored direct light the same room holds ρ Φ / (A (1 − ρ)), and the first reflection always survives.
TEST(Energy, FurnaceOfIndirectLight) {
    constexpr double watts = 6e5;
    constexpr double reflectance = 0.4;
    Traced traced(test::furnace(Rgb(static_cast<float>(reflectance))),
                  {test::lamp({30, 60, 45}, Rgb(static_cast<float>(watts)))}, test::roulette(false, 200));
    double sum = 0.0;
    const auto photons = traced.trace(0, 50'000);
    for (const Photon& p : photons) sum += p.flux.x;
    EXPECT_NEAR(sum / (watts * reflectance / (1.0 - reflectance)), 1.0, 0.005);
    // 1 + 1/(1-ρ) rays for 1/(1-ρ) photons.
    EXPECT_NEAR(static_cast<double>(photons.size()) / static_cast<double>(traced.counts.rays),
                1.0 / (2.0 - reflectance), 0.01);
    expectBooksBalance(traced.counts);
}

/// Colours: every channel on its own, for walls of several reflectances that all see each other alike (a sphere would;
/// a cube of one colour does).
TEST(Energy, FurnaceByChannel) {
    const Rgb reflectance(0.8F, 0.4F, 0.1F);
    const Rgb watts(1e5F, 2e5F, 4e5F);
    for (const TracerOptions& options : {test::roulette(true, 300), test::splitting(2, true, 8)}) {
        const bool split = options.scattering == TracerOptions::Scattering::Splitting;
        Traced traced(test::furnace(reflectance), {test::lamp(Vec3(50.0F), watts)}, options);
        glm::dvec3 sum(0.0);
        for (const Photon& p : traced.trace(0, split ? 40 : 60'000)) sum += glm::dvec3(p.flux);
        for (int c = 0; c < 3; ++c) {
            const double r = reflectance[c];
            const double series = (1.0 - (split ? std::pow(r, 9.0) : 0.0)) / (1.0 - r);
            EXPECT_NEAR(sum[c] / (static_cast<double>(watts[c]) * series), 1.0, 0.015) << c;
        }
        expectBooksBalance(traced.counts);
    }
}

/// Irradiance is uniform over the walls of the furnace once direct light is spread: each wall gets its share of what is
/// indirect (in a cube all faces see each other alike).
TEST(Energy, IndirectLightReachesAllWallsAlike) {
    Traced traced(test::furnace(Rgb(0.7F)), {test::lamp(Vec3(50.0F), Rgb(6e5F))}, test::roulette(false, 100));
    std::array<double, 6> wall{};
    double total = 0.0;
    for (const Photon& p : traced.trace(0, 100'000)) {
        wall[p.triangle / 2] += p.flux.x;
        total += p.flux.x;
    }
    for (const double flux : wall) EXPECT_NEAR(flux / total, 1.0 / 6.0, 0.002);
}

/// What goes in comes out: open rooms, filters, falloffs of the compiler, every kind of light.
TEST(Energy, BooksBalanceForEveryLight) {
    test::RoomBuilder room;
    const auto grey = room.material(test::opaque(Rgb(0.6F, 0.5F, 0.4F)));
    const auto open = room.material(test::sky());
    room.inside({0, 0, 0}, {256, 256, 128}, {grey, open, grey, grey, grey, grey});
    lights::Falloff odd;
    odd.noCosine = true;
    odd.extraDistance = 30;
    lights::SkyLight dome{{{0, 0, 1}, glm::normalize(Vec3(1, 0, 1)), glm::normalize(Vec3(0, -1, 0.2F))}, Rgb(3.0F)};
    for (const lights::Light& light :
         {lights::Light(lights::PointLight{{50, 50, 10}, Rgb(1e4F), odd}),
          lights::Light(lights::SphereLight{{80, 80, 60}, Rgb(1e4F, 0, 0), 20, {}}),
          lights::Light(lights::SpotLight{{128, 128, 120}, {0, 0, -1}, Rgb(1e5F), 0.5F, 32, {}}),
          lights::Light(lights::SunLight{glm::normalize(Vec3(0.2F, 0.3F, 1.0F)), Rgb(50.0F), 0.05F}),
          lights::Light(
              lights::makeAreaLight({{30, 30, 100}, {30, 90, 100}, {90, 90, 100}, {90, 30, 100}}, Rgb(50.0F), true)),
          lights::Light(dome)})
        for (const TracerOptions& options : {test::roulette(true, 8), test::splitting(4, false, 3)}) {
            Traced traced(room.build(), {light}, options);
            const auto photons = traced.trace(11, 2000);
            EXPECT_FALSE(photons.empty()) << lights::kindName(light);
            EXPECT_GT(traced.counts.emittedFlux[0], 0.0);
            EXPECT_NEAR(traced.counts.emittedFlux[0] / traced.lights().totalPower().x, 1.0, 0.01)
                << lights::kindName(light);
            expectBooksBalance(traced.counts);
            EXPECT_EQ(traced.counts.stored, photons.size());
            if (options.scattering == TracerOptions::Scattering::RussianRoulette) {
                EXPECT_EQ(traced.counts.emitted, traced.counts.escaped + traced.counts.absorbed + traced.counts.cut);
            }
            // A room open above, its light inside: nothing lands behind a wall.
            EXPECT_EQ(traced.counts.backHits, 0U) << lights::kindName(light);
        }
}

/// With direct light stored, what photons leave on the floor is the integral of illuminate over it.
TEST(Energy, FloorUnderCompilerLightGetsTheCompilersIrradiance) {
    test::RoomBuilder room;
    const auto black = room.material(test::opaque(Rgb(0.0F)));
    const float half = 128.0F;
    room.quad({-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}, black);
    lights::Falloff falloff;
    falloff.extraDistance = 50;
    falloff.angleScale = 0.7F;
    const lights::PointLight light{{10, 20, 60}, Rgb(1e6F), falloff};
    Traced traced(room.build(), {light}, test::roulette(true, 0));
    double sum = 0.0;
    for (const Photon& p : traced.trace(0, 200'000)) sum += p.flux.x;
    double expected = 0.0;
    constexpr int steps = 400;
    for (int i = 0; i < steps; ++i)
        for (int k = 0; k < steps; ++k) {
            const Vec3 p(half * (2.0F * (static_cast<float>(i) + 0.5F) / steps - 1.0F),
                         half * (2.0F * (static_cast<float>(k) + 0.5F) / steps - 1.0F), 0.0F);
            expected +=
                lights::illuminate(light, p, {0, 0, 1}, false, {}).irradiance.x * 4.0 * half * half / (steps * steps);
        }
    EXPECT_NEAR(sum / expected, 1.0, 0.002);
}

} // namespace
} // namespace pie::photons
