// All levels that Debian ships, against a second reading of their files that shares no code with the library.

#include "pie/level/bsp.h"
#include "pie/level/decoders.h"
#include "pie/level/level.h"
#include "pie/level/patch.h"
#include "tests/support/game_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

using namespace pie;
using namespace pie::level;
using namespace pie::test;

namespace {

/// Offsets and sizes as the format's description gives them.
class RawFile {
public:
    explicit RawFile(const Bytes& bytes) : bytes_(&bytes) {}
    template <class T> [[nodiscard]] T at(std::size_t offset) const {
        T value;
        std::memcpy(&value, bytes_->data() + offset, sizeof value);
        return value;
    }
    [[nodiscard]] std::size_t offset(std::size_t lump) const {
        return static_cast<std::size_t>(at<std::int32_t>(8 + 8 * lump));
    }
    [[nodiscard]] std::size_t count(std::size_t lump, std::size_t record) const {
        return static_cast<std::size_t>(at<std::int32_t>(12 + 8 * lump)) / record;
    }
    [[nodiscard]] Vec3 vertex(int number) const {
        const std::size_t at0 = offset(10) + 44 * static_cast<std::size_t>(number);
        return {at<float>(at0), at<float>(at0 + 4), at<float>(at0 + 8)};
    }

private:
    const Bytes* bytes_;
};

struct Sums {
    double area = 0;
    Box bounds;
    void triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
        area += 0.5 * glm::length(glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a)));
        for (const Vec3& p : {a, b, c}) bounds.extend(p);
    }
};

/// A patch piece of 3×3 points, evaluated densely.
void addPiece(const std::array<glm::dvec3, 9>& p, const Vec3& origin, Sums& sums) {
    constexpr int n = 24;
    const auto point = [&](int i, int j) {
        const double u = static_cast<double>(i) / n;
        const double v = static_cast<double>(j) / n;
        const double bu[3] = {(1 - u) * (1 - u), 2 * u * (1 - u), u * u};
        const double bv[3] = {(1 - v) * (1 - v), 2 * v * (1 - v), v * v};
        glm::dvec3 sum(0.0);
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 3; ++c) sum += bu[c] * bv[r] * p[3 * r + c];
        return Vec3(sum) + origin;
    };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            sums.triangle(point(i, j), point(i + 1, j), point(i, j + 1));
            sums.triangle(point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
        }
}

/// Area and bounds of the faces that `drawn` says are drawn, straight from the bytes.
Sums readAgain(const Bytes& bytes, const std::function<bool(std::size_t face)>& drawn,
               const std::function<Vec3(std::size_t face)>& origin) {
    const RawFile raw(bytes);
    Sums sums;
    for (std::size_t f = 0; f < raw.count(13, 104); ++f) {
        if (!drawn(f)) continue;
        const std::size_t face = raw.offset(13) + 104 * f;
        const auto field = [&](std::size_t i) { return raw.at<std::int32_t>(face + 4 * i); };
        const Vec3 o = origin(f);
        const int firstVertex = field(3);
        if (field(2) == 1 || field(2) == 3) {
            for (int i = 0; i < field(6); i += 3) {
                const auto corner = [&](int k) {
                    return raw.vertex(firstVertex + raw.at<std::int32_t>(raw.offset(11) + 4 * static_cast<std::size_t>(
                                                                                                  field(5) + i + k))) +
                           o;
                };
                sums.triangle(corner(0), corner(1), corner(2));
            }
        } else if (field(2) == 2) {
            const int w = field(24);
            const int h = field(25);
            for (int row = 0; row + 2 < h; row += 2)
                for (int column = 0; column + 2 < w; column += 2) {
                    std::array<glm::dvec3, 9> p;
                    for (int k = 0; k < 9; ++k)
                        p.at(static_cast<std::size_t>(k)) =
                            raw.vertex(firstVertex + (row + k / 3) * w + column + k % 3);
                    addPiece(p, o, sums);
                }
        }
    }
    return sums;
}

Level load(const std::string& name, const LoadOptions& options) {
    Location location{GameData::instance().files, name};
    Result<Level> level = loadLevel(std::move(location), options);
    EXPECT_TRUE(level) << level.error().message();
    return level ? std::move(*level) : Level{};
}

LoadOptions withoutImages() {
    LoadOptions options;
    options.images = false;
    return options;
}

Bytes bytesOf(const std::string& name) {
    Result<Bytes> bytes = GameData::instance().files.read(name);
    EXPECT_TRUE(bytes) << bytes.error().message();
    return bytes ? std::move(*bytes) : Bytes{};
}

using Key = std::tuple<float, float, float>;
Key key(const Vec3& p) { return {p.x, p.y, p.z}; }

} // namespace

TEST(Shipped, AreaAndBoundsEqualASecondReading) {
    PIE_NEED_GAME_DATA();
    for (const std::string& name : GameData::instance().levels) {
        const Level level = load(name, withoutImages());
        ASSERT_FALSE(level.surfaces.empty()) << name;
        const Bytes bytes = bytesOf(name);
        const RawFile raw(bytes);
        // Which faces are drawn is the scripts' word, taken from the level; the geometry is read again.
        std::vector<const Surface*> surfaceOf(raw.count(13, 104), nullptr);
        std::size_t next = 0;
        for (std::size_t f = 0; f < surfaceOf.size(); ++f)
            if (raw.at<std::int32_t>(raw.offset(13) + 104 * f + 8) != 4) surfaceOf[f] = &level.surfaces.at(next++);
        ASSERT_EQ(next, level.surfaces.size()) << name;
        const Sums sums = readAgain(
            bytes,
            [&](std::size_t f) {
                return surfaceOf[f] != nullptr && level.shaders[surfaceOf[f]->shader].drawn() &&
                       level.models[surfaceOf[f]->model].drawn;
            },
            [&](std::size_t f) { return level.models[surfaceOf[f]->model].origin; });
        EXPECT_NEAR(level.statistics.drawnArea / sums.area, 1, 1e-3) << name;
        const float size = glm::length(sums.bounds.size());
        EXPECT_LT(glm::length(level.statistics.drawnBounds.lower - sums.bounds.lower), 1e-3F * size) << name;
        EXPECT_LT(glm::length(level.statistics.drawnBounds.upper - sums.bounds.upper), 1e-3F * size) << name;
    }
}

TEST(Shipped, WritingGivesEveryLumpBack) {
    PIE_NEED_GAME_DATA();
    for (const std::string& name : GameData::instance().levels) {
        const Bytes bytes = bytesOf(name);
        const Result<Bsp> first = readBsp(bytes, name);
        ASSERT_TRUE(first) << first.error().message();
        const std::vector<std::byte> written = writeBsp(*first);
        const Result<Bsp> second = readBsp(written, name);
        ASSERT_TRUE(second) << second.error().message();
        EXPECT_EQ(writeBsp(*second), written) << name;
        // The lumps of the game's file, byte by byte, but for coordinates that were mended and padding behind names.
        const RawFile was(bytes);
        const RawFile is(written);
        for (const std::size_t lump : {2U, 3U, 4U, 5U, 6U, 7U, 8U, 9U, 10U, 11U, 13U, 14U, 15U, 16U}) {
            if (lump == 10 && first->nonFiniteLightmapCoordinates != 0) continue;
            const std::size_t size = was.count(lump, 1);
            ASSERT_EQ(is.count(lump, 1), size) << name << " lump " << lump;
            EXPECT_EQ(std::memcmp(bytes.data() + was.offset(lump), written.data() + is.offset(lump), size), 0)
                << name << " lump " << lump;
        }
    }
}

TEST(Shipped, FrontsFaceTheWayTheirNormalsDo) {
    PIE_NEED_GAME_DATA();
    for (const std::string& name : GameData::instance().levels) {
        const Level level = load(name, withoutImages());
        std::map<SurfaceKind, std::pair<double, double>> agreeing; // area: with its normals, all
        for (const Surface& surface : level.surfaces)
            for (std::size_t i = surface.firstIndex; i < surface.firstIndex + surface.indexCount; i += 3) {
                const Vertex* corner[3];
                for (std::size_t k = 0; k < 3; ++k) corner[k] = &level.vertices[level.indices[i + k]];
                const Vec3 n =
                    glm::cross(corner[1]->position - corner[0]->position, corner[2]->position - corner[0]->position);
                auto& [with, all] = agreeing[surface.kind];
                all += glm::length(n);
                if (glm::dot(n, corner[0]->normal + corner[1]->normal + corner[2]->normal) > 0) with += glm::length(n);
            }
        for (const auto& [kind, area] : agreeing)
            // Models and patches come with a few normals of their own mind.
            EXPECT_GE(area.first, (kind == SurfaceKind::Polygon ? 0.999 : 0.9) * area.second)
                << name << " kind " << static_cast<int>(kind);
    }
}

// A crack is a vertex of one patch's edge that lies on an edge which another patch shares control point by control
// point, and is not among that patch's vertices.
TEST(Shipped, NeighbouringPatchesLeaveNoCracks) {
    PIE_NEED_GAME_DATA();
    std::size_t sharedEdges = 0;
    for (const std::string& name : GameData::instance().levels) {
        const Result<Bsp> bsp = readBsp(bytesOf(name), name);
        ASSERT_TRUE(bsp);
        // For each Bézier segment on a patch's border, whichever way it runs: the vertices that each patch puts on it.
        std::map<std::set<Key>, std::vector<std::set<Key>>> segments;
        for (const BspFace& face : bsp->faces) {
            if (face.type != BspFaceType::Patch) continue;
            std::vector<PatchVertex> controls;
            for (std::int32_t i = 0; i < face.vertexCount; ++i) {
                const BspVertex& v =
                    bsp->vertices[static_cast<std::size_t>(face.firstVertex) + static_cast<std::size_t>(i)];
                controls.push_back({v.position, v.normal, v.texture, v.lightmap, Vec4(v.colour)});
            }
            const auto [w, h] = face.patchSize;
            std::set<Key> vertices;
            for (const PatchVertex& v : tessellate(controls, w, h).vertices) vertices.insert(key(v.position));
            const auto addSegment = [&](int first, int step) {
                const auto p = [&](int i) {
                    return glm::dvec3(controls[static_cast<std::size_t>(first) +
                                               static_cast<std::size_t>(i) * static_cast<std::size_t>(step)]
                                          .position);
                };
                const glm::dvec3 a = p(0);
                const glm::dvec3 b = p(1);
                const glm::dvec3 c = p(2);
                const std::set<Key> id = {key(Vec3(a)), key(Vec3(b)), key(Vec3(c))};
                if (id.size() < 3) return; // collapsed
                std::set<Key> onIt;
                for (int n = 1; n <= 32; ++n)
                    for (int i = 0; i <= n; ++i) {
                        const double t = static_cast<double>(i) / n;
                        const glm::dvec3 on = (1 - t) * (1 - t) * a + 2 * t * (1 - t) * b + t * t * c;
                        // Whatever of the patch lies within rounding of the curve.
                        for (const double dx : {-1.0, 0.0, 1.0})
                            for (const double dy : {-1.0, 0.0, 1.0})
                                for (const double dz : {-1.0, 0.0, 1.0}) {
                                    const auto near = [](double value, double direction) {
                                        const auto f = static_cast<float>(value);
                                        return direction == 0 ? f : std::nextafter(f, direction > 0 ? 1e30F : -1e30F);
                                    };
                                    const Key candidate{near(on.x, dx), near(on.y, dy), near(on.z, dz)};
                                    if (vertices.contains(candidate)) onIt.insert(candidate);
                                }
                    }
                segments[id].push_back(std::move(onIt));
            };
            for (int c = 0; c + 2 < w; c += 2)
                for (const int row : {0, h - 1}) addSegment(row * w + c, 1);
            for (int r = 0; r + 2 < h; r += 2)
                for (const int column : {0, w - 1}) addSegment(r * w + column, w);
        }
        for (const auto& [id, users] : segments) {
            if (users.size() > 1) ++sharedEdges;
            for (const std::set<Key>& user : users) EXPECT_EQ(user, users.front()) << name;
        }
    }
    EXPECT_GT(sharedEdges, 0U);
    RecordProperty("sharedEdges", static_cast<int>(sharedEdges));
}

TEST(Shipped, EveryScriptParses) {
    PIE_NEED_GAME_DATA();
    const ShaderLibrary library = ShaderLibrary::load(GameData::instance().files);
    for (const std::string& name : library.names()) {
        const Shader* shader = library.find(name);
        // The game cuts a surface's shader name at its last dot, so nothing reaches a definition with one.
        if (shader == nullptr) {
            EXPECT_NE(name.find('.'), std::string::npos) << name;
            continue;
        }
        EXPECT_TRUE(shader->sort.has_value()) << name;
    }
    EXPECT_FALSE(library.names().empty());
}

TEST(Shipped, NoLevelIsTakenForADeluxeOne) {
    PIE_NEED_GAME_DATA();
    for (const std::string& name : GameData::instance().levels) {
        const Result<Bsp> bsp = readBsp(bytesOf(name), name);
        ASSERT_TRUE(bsp);
        EXPECT_EQ(load(name, withoutImages()).lightmaps.size(), bsp->lightmaps.size()) << name;
    }
}

TEST(Shipped, FacesAreWhatTheyAreKnownToBe) {
    PIE_NEED_GAME_DATA();
    if (GameData::instance().levels.size() != 85) GTEST_SKIP() << "needs all 85 shipped levels. " << GameData::missing;
    LoadStatistics all;
    std::size_t mended = 0;
    for (const std::string& name : GameData::instance().levels) {
        const Level level = load(name, withoutImages());
        all.polygons += level.statistics.polygons;
        all.patches += level.statistics.patches;
        all.meshes += level.statistics.meshes;
        all.flares += level.statistics.flares;
        for (const std::string& warning : level.statistics.warnings)
            mended += warning.find("not finite") != std::string::npos ? 1 : 0;
    }
    EXPECT_EQ(all.polygons, 184185U);
    EXPECT_EQ(all.patches, 8181U);
    EXPECT_EQ(all.meshes, 6041U);
    EXPECT_EQ(all.flares, 6176U);
    EXPECT_EQ(mended, 18U);
}

TEST(Shipped, PicturesOfALevelAreAllDecoded) {
    PIE_NEED_GAME_DATA();
    if (!GameData::instance().has("oa_dm1")) GTEST_SKIP() << "needs oa_dm1. " << GameData::missing;
    const Level level = load("maps/oa_dm1.bsp", {});
    EXPECT_TRUE(level.statistics.missingTextures.empty());
    EXPECT_TRUE(level.statistics.warnings.empty());
    for (const Shader& shader : level.shaders) {
        const Texture* light = level.lightImage(shader);
        ASSERT_NE(light, nullptr) << shader.name;
        EXPECT_NE(light->image, nullptr) << shader.name;
        if (!shader.drawn()) continue;
        for (const Stage& stage : shader.stages)
            for (const std::string& image : stage.images) {
                ASSERT_NE(level.texture(image), nullptr) << image;
                EXPECT_NE(level.texture(image)->image, nullptr) << image;
            }
    }
    EXPECT_FALSE(level.tree.leaves.empty());
    EXPECT_GE(level.tree.leaves[level.tree.leafAt(level.firstView().eye)].cluster, 0);
}

/// Every eighth: OpenImageIO needs several times as long.
TEST(ShippedPictures, OurDecodersMakeOfThemWhatOpenImageIoMakes) {
    PIE_NEED_GAME_DATA();
    const GameData& game = GameData::instance();
    std::size_t compared = 0;
    for (const std::string extension : {"tga", "jpg"}) {
        const std::vector<std::string> names = game.files.list("textures", "." + extension);
        for (std::size_t i = 0; i < names.size(); i += 8) {
            const Result<Bytes> bytes = game.files.read(names[i]);
            ASSERT_TRUE(bytes);
            const auto ours = extension == "tga" ? decodeTga(*bytes) : decodeJpeg(*bytes);
            ASSERT_TRUE(ours) << names[i];
            ASSERT_TRUE(ours->image) << names[i] << ": " << ours->failure;
            Decoding other = decodeOther(*bytes, extension);
            ASSERT_TRUE(other.image) << names[i] << ": " << other.failure;
            const auto width = static_cast<std::size_t>(other.image->width);
            const auto height = static_cast<std::size_t>(other.image->height);
            // The game takes a TGA that starts above for one that starts below.
            if (extension == "tga" && (std::to_integer<unsigned>((*bytes)[17]) & 0x20U) != 0)
                for (std::size_t y = 0; y < height / 2; ++y)
                    for (std::size_t x = 0; x < width; ++x)
                        std::swap(other.image->pixels[y * width + x],
                                  other.image->pixels[(height - 1 - y) * width + x]);
            ASSERT_EQ(ours->image->width, other.image->width) << names[i];
            EXPECT_EQ(ours->image->pixels, other.image->pixels) << names[i];
            EXPECT_EQ(ours->image->hasAlpha, other.image->hasAlpha) << names[i];
            ++compared;
        }
    }
    EXPECT_GT(compared, 100U);
}
