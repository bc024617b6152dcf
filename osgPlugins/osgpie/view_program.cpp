#include "osgPlugins/osgpie/view_program.h"

#include "pie/engine/settings.h"

#include <fmt/format.h>

namespace osgpie {

const char* const viewVaryings = "varying vec3 bakedColour;\nvarying vec4 clipPosition;\n";
const char* const viewVertexCode = "    bakedColour = gl_SecondaryColor.rgb;\n    clipPosition = gl_Position;\n";

namespace {

std::string numbers() {
    using pie::engine::View;
    const auto define = [](const char* name, View view) {
        return fmt::format("#define {} {}\n", name, static_cast<int>(view));
    };
    return define("BAKED", View::Baked) + define("FULLBRIGHT", View::Fullbright) + define("LIGHT", View::Light) +
           define("LIGHTMAP", View::Lightmap) + define("SPLIT", View::Split) + define("DIFFERENCE", View::Difference) +
           define("NORMALS", View::Normals) + define("TRIANGLES", View::Triangles) +
           define("COARSE", View::CoarseTriangles) + define("PHOTONS", View::Photons) +
           define("SAMPLES", View::Samples);
}

constexpr const char* functions = R"(
bool textured() { return pieView != LIGHT && pieView != LIGHTMAP && pieView < DIFFERENCE; }
vec4 plain(vec4 t) { return textured() ? t : vec4(vec3(1.0), t.a); }
vec3 cut(vec3 l) {
    float m = max(l.r, max(l.g, l.b));
    return m > OVERBRIGHT ? l * (OVERBRIGHT / m) : l;
}
vec3 ours() { return cut(max(colour.rgb, vec3(0.0)) * (pieExposure * OVERBRIGHT)); }
vec3 lightOf(vec3 baked) {
    if (pieView == FULLBRIGHT) return vec3(1.0);
    bool left = clipPosition.x < pieSplit * clipPosition.w;
    return pieView == BAKED || pieView == LIGHTMAP || (pieView == SPLIT && left) ? baked : ours();
}
vec3 light() { return lightOf(bakedColour * OVERBRIGHT); }
vec3 differenceColour(float d) {
    vec3 far = d > 0.0 ? vec3(0.70, 0.05, 0.10) : vec3(0.05, 0.20, 0.70);
    return mix(vec3(0.93), far, clamp(abs(d), 0.0, 1.0));
}
vec3 looked(vec3 b, vec3 baked, bool lit) {
    if (pieView == SPLIT) {
        float gap = abs(clipPosition.x / clipPosition.w - pieSplit);
        return gap < 0.002 ? vec3(1.0) : b;
    }
    if (pieView < DIFFERENCE) return b;
    if (pieView == DIFFERENCE) return lit ? differenceColour(dot(ours() - baked, vec3(1.0 / 3.0))) : vec3(0.35);
    if (pieView == NORMALS) return 0.5 + 0.5 * normalize(normal);
    if (pieView == SAMPLES) return lit ? colour.rgb : vec3(0.35);
    return b * (pieView == PHOTONS ? 0.3 : 0.6);
}
)";

} // namespace

std::string viewLight(float overbright) {
    return "uniform int pieView;\nuniform float pieSplit, pieExposure;\n" + std::string(viewVaryings) + numbers() +
           fmt::format("#define OVERBRIGHT {:.6f}\n", overbright) + functions;
}

} // namespace osgpie
