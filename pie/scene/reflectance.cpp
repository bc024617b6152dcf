#include "pie/scene/reflectance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace pie::scene {
namespace {

/// Reflectance where nothing is known: a middle grey.
constexpr float unknownReflectance = 0.5F;
/// Share of the texel that the level compiler bounces.
constexpr float compilerShare = 0.55147F;

float linearised(float stored) {
    return stored <= 0.04045F ? stored / 12.92F : std::pow((stored + 0.055F) / 1.055F, 2.4F);
}

bool kept(std::uint8_t alpha, level::AlphaTest test) {
    switch (test) {
    case level::AlphaTest::None: return true;
    case level::AlphaTest::GreaterZero: return alpha > 0;
    case level::AlphaTest::Less128: return alpha < 128;
    case level::AlphaTest::GreaterEqual128: return alpha >= 128;
    }
    return true;
}

std::uint32_t weightOf(const Rgba8& texel, TexelWeight weight, level::AlphaTest test) {
    switch (weight) {
    case TexelWeight::All: return 1;
    case TexelWeight::Alpha: return texel.w;
    case TexelWeight::Visible: return kept(texel.w, test) ? 1 : 0;
    }
    return 1;
}

/// Bytes are summed as integers: exact, in any order, and the compiler makes vectors of it.
Rgb plainMean(std::span<const Rgba8> pixels) {
    std::array<std::uint64_t, 3> sum{};
    constexpr std::size_t block = 1U << 16U; // 255 × block fits 32 bits
    for (std::size_t begin = 0; begin < pixels.size(); begin += block) {
        std::uint32_t red = 0;
        std::uint32_t green = 0;
        std::uint32_t blue = 0;
        const std::size_t end = std::min(pixels.size(), begin + block);
        for (std::size_t i = begin; i < end; ++i) {
            red += pixels[i].x;
            green += pixels[i].y;
            blue += pixels[i].z;
        }
        sum[0] += red;
        sum[1] += green;
        sum[2] += blue;
    }
    const double scale = 1.0 / (255.0 * static_cast<double>(pixels.size()));
    return {static_cast<float>(static_cast<double>(sum[0]) * scale),
            static_cast<float>(static_cast<double>(sum[1]) * scale),
            static_cast<float>(static_cast<double>(sum[2]) * scale)};
}

/// The stage that shows the picture, or null.
const level::Stage* stageOf(const level::Shader& shader, const level::Texture* texture) {
    if (texture == nullptr) return nullptr;
    for (const level::Stage& stage : shader.stages)
        if (std::find(stage.images.begin(), stage.images.end(), texture->name) != stage.images.end()) return &stage;
    return nullptr;
}

Rgb colourOf(const level::Shader& shader, const level::Texture* texture, Interaction interaction, bool linear) {
    const level::Stage* stage = stageOf(shader, texture);
    Rgb tint(1.0F);
    if (stage != nullptr && stage->rgbGen == level::RgbGen::Constant) tint = stage->rgbConstant;
    if (texture != nullptr && texture->image && !texture->image->pixels.empty()) {
        TexelWeight weight = TexelWeight::All;
        level::AlphaTest test = level::AlphaTest::None;
        if (stage != nullptr && stage->alphaTest != level::AlphaTest::None) {
            weight = TexelWeight::Visible;
            test = stage->alphaTest;
        } else if (interaction == Interaction::Filter && shader.parms.alphaShadow) {
            weight = TexelWeight::Alpha;
        }
        return tint * meanTexel(*texture->image, weight, test, linear);
    }
    for (const level::Stage& plain : shader.stages)
        if (plain.source == level::Stage::Source::White && plain.rgbGen == level::RgbGen::Constant)
            return plain.rgbConstant;
    return Rgb(unknownReflectance);
}

} // namespace

Rgb meanTexel(const level::Image& image, TexelWeight weight, level::AlphaTest test, bool linear) {
    if (image.pixels.empty()) return Rgb(unknownReflectance);
    if (weight == TexelWeight::All && !linear) return plainMean(image.pixels);
    // A weighted histogram: exact, and the curve is evaluated 256 times instead of once a texel.
    std::array<std::array<std::uint64_t, 256>, 3> histogram{};
    std::uint64_t total = 0;
    for (const Rgba8& texel : image.pixels) {
        const std::uint32_t w = weightOf(texel, weight, test);
        histogram[0][texel.x] += w;
        histogram[1][texel.y] += w;
        histogram[2][texel.z] += w;
        total += w;
    }
    if (total == 0) return meanTexel(image, TexelWeight::All, test, linear);
    std::array<double, 3> sum{};
    for (std::size_t value = 0; value < 256; ++value) {
        const float stored = static_cast<float>(value) / 255.0F;
        const double worth = linear ? linearised(stored) : stored;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += worth * static_cast<double>(histogram[c][value]);
    }
    const auto count = static_cast<double>(total);
    return {static_cast<float>(sum[0] / count), static_cast<float>(sum[1] / count), static_cast<float>(sum[2] / count)};
}

Rgb reflectanceOf(const level::Shader& shader, const level::Texture* texture, Interaction interaction,
                  const SceneOptions& options) {
    Rgb colour = colourOf(shader, texture, interaction, options.linear);
    if (options.reflectance == ReflectanceModel::Compiler) colour *= compilerShare * shader.light.bounce;
    const float most = std::clamp(options.maxReflectance, 0.0F, 1.0F);
    // A script may hold any number; what is not one reflects nothing.
    const auto bounded = [&](float value) { return value > 0.0F ? std::min(value, most) : 0.0F; };
    return {bounded(colour.x), bounded(colour.y), bounded(colour.z)};
}

} // namespace pie::scene
