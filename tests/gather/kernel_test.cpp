#include "pie/gather/area_shape.h"
#include "pie/gather/kernel.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <array>
#include <random>

namespace pie::gather {
namespace {

using glm::dvec2;
constexpr std::array kernels{Kernel::Constant, Kernel::Cone, Kernel::Gaussian, Kernel::Epanechnikov};
constexpr double pi = std::numbers::pi;

class Kernels : public testing::TestWithParam<Kernel> {};
INSTANTIATE_TEST_SUITE_P(All, Kernels, testing::ValuesIn(kernels),
                         [](const auto& test) { return "Kernel" + std::to_string(static_cast<int>(test.param)); });

TEST_P(Kernels, FallFromTheCentreToTheBorder) {
    const Kernel kernel = GetParam();
    EXPECT_NEAR(value(kernel, 0), kernel == Kernel::Gaussian ? 0.918 : 1.0, 1e-12);
    for (int i = 0; i < 99; ++i) {
        const double t = 0.01 * i;
        EXPECT_GE(value(kernel, t), value(kernel, t + 0.01));
        EXPECT_GE(value(kernel, t + 0.01), 0);
    }
}

TEST_P(Kernels, PrimitiveIsTheIntegralOfTheValue) {
    const Kernel kernel = GetParam();
    constexpr int steps = 200000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        sum += value(kernel, (i + 0.5) / steps) / steps;
        if (i % 20000 != 19999) continue;
        EXPECT_NEAR(primitive(kernel, (i + 1.0) / steps), sum, 1e-7) << "t " << (i + 1.0) / steps;
    }
    EXPECT_NEAR(discIntegral(kernel), pi * sum, 1e-6);
}

double kernelAt(const PlaneKernel& plane, const dvec2& p) {
    const double t = (glm::dot(p, p) + plane.height * plane.height) / (plane.radius * plane.radius);
    return t <= 1 ? value(plane.kernel, t) : 0;
}

TEST_P(Kernels, WholeDiscInsideThePolygon) {
    const std::array<dvec2, 4> square{{{-3, -5}, {4, -5}, {4, 3}, {-3, 3}}};
    for (const double height : {0.0, 0.5, 1.9}) {
        const PlaneKernel plane{GetParam(), height, 2.0};
        const double expected = pi * 4 * (primitive(GetParam(), 1) - primitive(GetParam(), height * height / 4));
        EXPECT_NEAR(integrate(plane, square), expected, 1e-9);
    }
    EXPECT_EQ(integrate({GetParam(), 2.0, 2.0}, square), 0);
    EXPECT_EQ(integrate({GetParam(), 7.0, 2.0}, square), 0);
}

TEST_P(Kernels, HalfAndQuarterDiscs) {
    const double whole = discIntegral(GetParam()) * 4;
    const std::array<dvec2, 4> half{{{0, -5}, {9, -5}, {9, 5}, {0, 5}}};
    const std::array<dvec2, 4> quarter{{{0, 0}, {9, 0}, {9, 9}, {0, 9}}};
    EXPECT_NEAR(integrate({GetParam(), 0, 2}, half), whole / 2, 1e-9);
    EXPECT_NEAR(integrate({GetParam(), 0, 2}, quarter), whole / 4, 1e-9);
    const std::array<dvec2, 3> away{{{3, 0}, {4, 0}, {4, 1}}};
    EXPECT_NEAR(integrate({GetParam(), 0, 2}, away), 0, 1e-12);
}

TEST_P(Kernels, RandomPolygonsAgreeWithAGrid) {
    std::mt19937 random(17);
    std::uniform_real_distribution<double> place(-2.5, 2.5);
    for (int round = 0; round < 40; ++round) {
        std::array<dvec2, 3> triangle;
        for (dvec2& corner : triangle) corner = {place(random), place(random)};
        const auto cross = [](const dvec2& a, const dvec2& b) { return a.x * b.y - a.y * b.x; };
        if (cross(triangle[1] - triangle[0], triangle[2] - triangle[0]) < 0) std::swap(triangle[1], triangle[2]);
        const PlaneKernel plane{GetParam(), 0.1 * (round % 10), 1.0 + 0.05 * round};
        constexpr int cells = 700;
        const double width = 5.0 / cells;
        double sum = 0;
        for (int y = 0; y < cells; ++y)
            for (int x = 0; x < cells; ++x) {
                const dvec2 p(-2.5 + (x + 0.5) * width, -2.5 + (y + 0.5) * width);
                bool inside = true;
                for (std::size_t i = 0; i < 3; ++i)
                    inside = inside && cross(triangle[(i + 1) % 3] - triangle[i], p - triangle[i]) >= 0;
                if (inside) sum += kernelAt(plane, p) * width * width;
            }
        // A grid of this width misjudges the border, at most about 10 long, by a fraction of a cell.
        EXPECT_NEAR(integrate(plane, triangle), sum, 0.01) << "round " << round;
        EXPECT_NEAR(FlatPolygon(triangle).integral(plane), integrate(plane, triangle), 1e-9);
    }
}

TEST_P(Kernels, CuttingAPolygonDoesNotChangeTheSum) {
    std::mt19937 random(18);
    std::uniform_real_distribution<double> place(-2, 2);
    for (int round = 0; round < 500; ++round) {
        const std::array<dvec2, 3> whole{
            {{place(random), place(random)}, {place(random), place(random)}, {place(random), place(random)}}};
        const dvec2 middle(place(random), place(random)); // also outside: signs take care of it
        const PlaneKernel plane{GetParam(), 0.3, 1.4};
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::array<dvec2, 3> part{{middle, whole[i], whole[(i + 1) % 3]}};
            sum += integrate(plane, part);
        }
        // Cone and Gaussian integrate their straight parts numerically.
        const bool closed = GetParam() == Kernel::Constant || GetParam() == Kernel::Epanechnikov;
        EXPECT_NEAR(sum, integrate(plane, whole), closed ? 1e-11 : 2e-4);
    }
}

TEST_P(Kernels, WhollyInsideOrOutsideIsTheSameAsCuttingTheCircle) {
    std::mt19937 random(19);
    std::uniform_real_distribution<double> place(-2, 2);
    int whole = 0;
    for (int round = 0; round < 2000; ++round) {
        const dvec2 a(place(random), place(random));
        std::array<dvec2, 3> triangle{a, a + 0.5 * dvec2(place(random), place(random)),
                                      a + 0.5 * dvec2(place(random), place(random))};
        const dvec2 u = triangle[1] - a;
        const dvec2 v = triangle[2] - a;
        if (u.x * v.y < u.y * v.x) std::swap(triangle[1], triangle[2]);
        const FlatPolygon shape(triangle);
        for (const double radius : {0.2, 1.0, 2.0, 5.0}) {
            const PlaneKernel plane{GetParam(), 0.15, radius};
            const double expected = integrate(plane, triangle);
            EXPECT_NEAR(shape.integral(plane), expected, 1e-9);
            if (radius == 5.0 && expected > 0) ++whole;
        }
    }
    EXPECT_GT(whole, 1900);
}

TEST_P(Kernels, DegeneratePolygonsAreNothing) {
    const std::array<dvec2, 3> point{{{1, 1}, {1, 1}, {1, 1}}};
    const std::array<dvec2, 3> line{{{-1, 0}, {0, 0}, {1, 0}}};
    const std::array<dvec2, 3> offLine{{{-1, 0.5}, {0, 0.5}, {1, 0.5}}};
    for (const auto& polygon : {point, line, offLine}) EXPECT_NEAR(integrate({GetParam(), 0, 2}, polygon), 0, 1e-5);
    EXPECT_EQ(integrate({GetParam(), 0, 0}, line), 0);
}

} // namespace
} // namespace pie::gather
