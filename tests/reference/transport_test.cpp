// The oracle against what photons carry, and what it says about its own error.

#include "pie/core/parallel.h"
#include "pie/photons/tracer.h"
#include "tests/reference/traced.h"

#include <gtest/gtest.h>

#include <array>
#include <numbers>

namespace pie::reference::test {
namespace {

const Vec3 up(0.0F, 0.0F, 1.0F);

lights::AreaLight panel(const Vec3& corner, const Vec3& u, const Vec3& v, float radiosity, bool twoSided = false) {
    return lights::makeAreaLight({corner, corner + u, corner + u + v, corner + v}, Rgb(radiosity), twoSided);
}

/// A room with every kind of surface: coloured walls, a one-sided and a two-sided screen, a tinted filter, a window to
/// the sky.
SceneBuilder everything() {
    SceneBuilder builder;
    scene::Material red;
    red.reflectance = {0.6F, 0.2F, 0.1F};
    builder.room(Vec3(0.0F), Vec3(100.0F), builder.material(red));
    scene::Material cloth;
    cloth.reflectance = Rgb(0.6F);
    cloth.twoSided = true;
    builder.quad({60.0F, 20.0F, 10.0F}, {0.0F, 40.0F, 0.0F}, {0.0F, 0.0F, 40.0F}, builder.material(cloth));
    builder.quad({20.0F, 70.0F, 0.0F}, {40.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 50.0F}, builder.grey(0.5F));
    scene::Material glass;
    glass.interaction = scene::Interaction::Filter;
    glass.alphaOnly = false;
    glass.reflectance = Rgb(0.4F);
    auto picture = std::make_shared<level::Image>();
    picture->width = picture->height = 1;
    picture->pixels = {Rgba8(200, 100, 40, 255)};
    glass.filter = picture;
    builder.quad({0.0F, 0.0F, 65.0F}, {50.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F}, builder.material(glass));
    scene::Material sky;
    sky.interaction = scene::Interaction::Sky;
    builder.quad({30.0F, 30.0F, 99.0F}, {0.0F, 40.0F, 0.0F}, {40.0F, 0.0F, 0.0F}, builder.material(sky));
    return builder;
}

std::vector<std::pair<const char*, lights::Light>> everyLight() {
    lights::SphereLight sphere;
    sphere.position = {80.0F, 50.0F, 70.0F};
    sphere.power = Rgb(30'000.0F);
    sphere.radius = 8;
    sphere.falloff.minDistance = 0;
    lights::SpotLight spot;
    spot.position = {50.0F, 10.0F, 80.0F};
    spot.direction = glm::normalize(Vec3(0.0F, 0.5F, -1.0F));
    spot.power = Rgb(90'000.0F);
    spot.slope = 0.7F;
    spot.rim = 10;
    spot.falloff.minDistance = 0;
    lights::SunLight sun;
    sun.towards = glm::normalize(Vec3(0.3F, 0.1F, 1.0F));
    sun.irradiance = {50.0F, 40.0F, 30.0F};
    lights::SunLight wide = sun;
    wide.devianceRadians = 0.2F;
    lights::SkyLight sky;
    for (int i = 0; i < 9; ++i) {
        const float azimuth = 0.7F * static_cast<float>(i);
        sky.towards.push_back(
            glm::normalize(Vec3(std::cos(azimuth), std::sin(azimuth), 0.3F + 0.3F * static_cast<float>(i))));
    }
    sky.irradiance = Rgb(8.0F);
    lights::PointLight odd = lamp({20.0F, 20.0F, 80.0F}, Rgb(20'000.0F));
    odd.falloff.minDistance = 30;
    odd.falloff.extraDistance = 10;
    odd.falloff.angleScale = 0.4F;
    return {{"point", lamp({80.0F, 20.0F, 60.0F}, {30'000.0F, 20'000.0F, 10'000.0F})},
            {"compiler's point", odd},
            {"sphere", sphere},
            {"spot", spot},
            {"sun", sun},
            {"wide sun", wide},
            {"sky", sky},
            {"area", panel({70.0F, 60.0F, 98.0F}, {0.0F, 20.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, 60.0F)},
            {"area of two sides", panel({20.0F, 5.0F, 30.0F}, {20.0F, 0.0F, 0.0F}, {0.0F, 20.0F, 0.0F}, 40.0F, true)}};
}

struct Patch {
    const char* name;
    Vec3 origin, u, v, normal;
};

/// Flux of the photons that arrive on a patch, per square unit, with its error.
struct Arrived {
    glm::dvec3 mean{0.0}, error{0.0};
};
std::vector<Arrived> photonsOn(const Traced& traced, std::span<const Patch> patches) {
    const lights::LightSet lights(traced.lights, traced.scene);
    constexpr int batches = 16;
    std::vector<glm::dvec3> sums(patches.size() * batches, glm::dvec3(0.0));
    for (std::size_t b = 0; b < batches; ++b) {
        photons::TracerOptions options;
        options.storeDirectLight = true;
        options.recursionDepth = 100;
        options.seed = b + 1;
        std::vector<photons::Photon> photons;
        photons::PhotonTracer(*traced.scene, lights, *traced.intersector, options).trace(0, 8192, photons);
        for (const auto& photon : photons)
            for (std::size_t p = 0; p < patches.size(); ++p) {
                const Patch& patch = patches[p];
                const Vec3 at = photon.position - patch.origin;
                const float s = glm::dot(at, patch.u) / glm::dot(patch.u, patch.u);
                const float t = glm::dot(at, patch.v) / glm::dot(patch.v, patch.v);
                const bool on = s >= 0 && s <= 1 && t >= 0 && t <= 1 && std::abs(glm::dot(at, patch.normal)) < 0.01F;
                if (on && glm::dot(photon.direction, patch.normal) < 0.0F)
                    sums[p * batches + b] +=
                        glm::dvec3(photon.flux) / double{glm::length(glm::cross(patch.u, patch.v))};
            }
    }
    std::vector<Arrived> arrived(patches.size());
    for (std::size_t p = 0; p < patches.size(); ++p) {
        const auto own = std::span(sums).subspan(p * batches, batches);
        for (const auto& sum : own) arrived[p].mean += sum / double{batches};
        for (const auto& sum : own) arrived[p].error += (sum - arrived[p].mean) * (sum - arrived[p].mean);
        arrived[p].error = glm::sqrt(arrived[p].error / (double{batches} * (batches - 1)));
    }
    return arrived;
}

TEST(Reference, GivesWhatPhotonsCarryForEveryKindOfLight) {
    const Vec3 x(1.0F, 0.0F, 0.0F);
    const Vec3 y(0.0F, 1.0F, 0.0F);
    const std::array patches{Patch{"floor under the filter", {5.0F, 5.0F, 0.0F}, 30.0F * x, 30.0F * y, up},
                             Patch{"floor in the open", {65.0F, 65.0F, 0.0F}, 30.0F * x, 30.0F * y, up},
                             Patch{"wall", {100.0F, 20.0F, 20.0F}, 40.0F * y, 50.0F * up, -x},
                             Patch{"back of the cloth", {60.0F, 20.0F, 10.0F}, 40.0F * y, 40.0F * up, -x}};
    for (const auto& [name, light] : everyLight()) {
        const Traced traced(everything(), {light});
        const std::vector<Arrived> arrived = photonsOn(traced, patches);
        for (std::size_t p = 0; p < patches.size(); ++p) {
            const Patch& patch = patches[p];
            const Arrived& photons = arrived[p];
            // Few paths each from many places: shadows have edges.
            Options options;
            options.mostPaths = 256;
            std::vector<scene::Receiver> points;
            std::mt19937 random(static_cast<unsigned>(p) + 1);
            for (int i = 0; i < 200; ++i) {
                const float s = gather::test::unit(random);
                points.push_back(
                    receiverAt(patch.origin + s * patch.u + gather::test::unit(random) * patch.v, patch.normal));
            }
            const auto values = traced.at(points, options);
            const auto count = static_cast<double>(values.size());
            glm::dvec3 mean(0.0);
            glm::dvec3 error(0.0);
            for (const Value& value : values) mean += value.irradiance / count;
            for (const Value& value : values) error += (value.irradiance - mean) * (value.irradiance - mean);
            error /= count * (count - 1);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(mean[c], photons.mean[c],
                            mostErrors * std::sqrt(error[c] + photons.error[c] * photons.error[c]) + 0.005 * mean[c])
                    << name << ", " << patch.name << ", channel " << c;
            }
        }
    }
}

TEST(Reference, AllLightsTogetherAreTheSumOfEach) {
    // Choosing among lights must not change what they give: walls, and many lamps on both sides of them.
    SceneBuilder builder;
    builder.room(Vec3(0.0F), {300.0F, 100.0F, 100.0F}, builder.grey(0.6F));
    builder.quad({150.0F, 0.0F, 0.0F}, {0.0F, 80.0F, 0.0F}, {0.0F, 0.0F, 100.0F});
    builder.quad({149.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 100.0F}, {0.0F, 80.0F, 0.0F});
    std::mt19937 random(5);
    std::vector<lights::Light> lights;
    for (int i = 0; i < 14; ++i) {
        const Vec3 place = Vec3(10.0F) + Vec3(270.0F, 70.0F, 80.0F) * gather::test::unit3(random);
        if (i % 3 == 0)
            lights.emplace_back(lamp(place, Rgb(500.0F * gather::test::unit(random))));
        else
            lights.emplace_back(
                panel(place, {0.0F, 8.0F, 0.0F}, {8.0F, 0.0F, 0.0F}, 30.0F * gather::test::unit(random)));
    }
    const Traced together(builder, lights);
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 12; ++i) points.push_back(receiverAt({10.0F + 25.0F * static_cast<float>(i), 40.0F, 0.0F}, up));
    Options options;
    options.target = 0.03;
    const auto whole = together.at(points, options);
    std::vector<double> sum(points.size());
    std::vector<double> squares(points.size());
    for (const auto& light : lights) {
        const auto part = Traced(together.scene, {light}).at(points, options);
        for (std::size_t i = 0; i < points.size(); ++i) {
            sum[i] += part[i].irradiance.x;
            squares[i] += part[i].standardError.x * part[i].standardError.x;
        }
    }
    double chiSquared = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double error = std::sqrt(squares[i] + whole[i].standardError.x * whole[i].standardError.x);
        EXPECT_NEAR(whole[i].irradiance.x, sum[i], 4.5 * error) << i;
        chiSquared += std::pow((whole[i].irradiance.x - sum[i]) / error, 2);
    }
    EXPECT_LT(chiSquared, 39.1) << "12 degrees of freedom: once in 10,000";
}

TEST(Reference, StandardErrorsAreHonest) {
    const Traced traced(everything(), {panel({70.0F, 60.0F, 98.0F}, {0.0F, 20.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, 60.0F)});
    std::vector<scene::Receiver> points = grid(Vec3(0.0F), {100.0F, 0.0F, 0.0F}, {0.0F, 65.0F, 0.0F}, up, 7);
    Options fine;
    fine.target = 0.01;
    fine.seed = 99;
    const auto truth = traced.at(points, fine);
    int within = 0;
    int count = 0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        Options coarse;
        coarse.target = 0.05;
        coarse.seed = seed;
        const auto values = traced.at(points, coarse);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double off = (values[i].irradiance.x + values[i].irradiance.y + values[i].irradiance.z -
                                truth[i].irradiance.x - truth[i].irradiance.y - truth[i].irradiance.z) /
                               3;
            ++count;
            if (std::abs(off) <= std::hypot(values[i].meanError, truth[i].meanError)) ++within;
            EXPECT_TRUE(values[i].reached);
            EXPECT_LE(values[i].meanError,
                      0.05 * (values[i].irradiance.x + values[i].irradiance.y + values[i].irradiance.z) / 3);
        }
    }
    const double share = double(within) / count;
    // 490 values, which give the share within 2.1 %; those of a point share a truth, whose error is smaller than
    // theirs.
    EXPECT_NEAR(share, 0.683, 0.085) << "four standard errors";
}

TEST(Reference, SaysWhenTheTargetWasNotReached) {
    const Traced traced(everything(), {panel({70.0F, 60.0F, 98.0F}, {0.0F, 20.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, 60.0F)});
    Options options;
    options.target = 1e-6;
    options.mostPaths = 8192;
    const auto values = traced.at({receiverAt({50.0F, 50.0F, 0.0F}, up)}, options);
    EXPECT_FALSE(values[0].reached);
    EXPECT_EQ(values[0].paths, 8192U);
    EXPECT_GT(values[0].meanError, 0.0);
}

TEST(Reference, SameBitsOnAnyNumberOfThreadsAndInAnyCompany) {
    std::vector<lights::Light> lights;
    for (const auto& [name, light] : everyLight()) lights.push_back(light);
    const Traced traced(everything(), lights);
    Options options;
    options.target = 0.05;
    const auto points = grid({5.0F, 5.0F, 0.0F}, {90.0F, 0.0F, 0.0F}, {0.0F, 90.0F, 0.0F}, up, 4);
    setThreads(1);
    const auto one = traced.at(points, options);
    setThreads(0);
    const auto many = traced.at(points, options);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(one[i].irradiance, many[i].irradiance);
        EXPECT_EQ(one[i].meanError, many[i].meanError);
    }
    EXPECT_EQ(traced.at({points[7]}, options)[0].irradiance, one[7].irradiance);
}

TEST(Reference, TwoSidedReceiversSeeBothSides) {
    SceneBuilder builder;
    scene::Material cloth;
    cloth.twoSided = true;
    builder.quad({-500.0F, -500.0F, 0.0F}, {1000.0F, 0.0F, 0.0F}, {0.0F, 1000.0F, 0.0F}, builder.material(cloth));
    const Traced traced(builder, {lamp({0.0F, 0.0F, 60.0F}, Rgb(1000.0F)), lamp({0.0F, 0.0F, -60.0F}, Rgb(500.0F))});
    const auto values = traced.at({receiverAt(Vec3(0.0F), up, true), receiverAt(Vec3(0.0F), up)});
    EXPECT_NEAR(values[0].irradiance.x / values[1].irradiance.x, 1.5, 1e-3);
}

TEST(Reference, WithoutLightsItIsDark) {
    const Traced traced(everything(), {});
    const auto values = traced.at({receiverAt({50.0F, 50.0F, 0.0F}, up)});
    EXPECT_EQ(values[0].irradiance, glm::dvec3(0.0));
    EXPECT_EQ(values[0].paths, 0U);
    EXPECT_TRUE(values[0].reached);
}

TEST(Reference, StaysFiniteWhateverHappens) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float power : {0.0F, 1e-30F, 1e30F, std::numeric_limits<float>::infinity(), nan})
        for (const Vec3& place : {Vec3(50.0F, 50.0F, 0.0F), Vec3(0.0F), Vec3(-50.0F), Vec3(1e30F), Vec3(nan)}) {
            const Traced traced(everything(),
                                {lamp(place, Rgb(power)), panel(place, {0.0F, 8.0F, 0.0F}, {8.0F, 0.0F, 0.0F}, power)});
            Options options;
            options.mostPaths = 4096;
            for (const Value& value : traced.at({receiverAt({50.0F, 50.0F, 0.0F}, up), receiverAt(Vec3(nan), up),
                                                 receiverAt(Vec3(1e30F), up), receiverAt(Vec3(0.0F), Vec3(0.0F))},
                                                options)) {
                EXPECT_TRUE(std::isfinite(value.irradiance.x) && std::isfinite(value.meanError))
                    << power << " at " << place.x;
                EXPECT_GE(value.irradiance.x, 0.0);
            }
        }
}

} // namespace
} // namespace pie::reference::test
