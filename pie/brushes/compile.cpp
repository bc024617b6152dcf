#include "pie/brushes/compile.h"

#include "pie/brushes/bsp_writer.h"
#include "pie/brushes/solid_tree.h"
#include "pie/level/names.h"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <deque>
#include <iterator>
#include <set>

namespace pie::brushes {
namespace {

using level::Entity;
using level::StageTime;

constexpr double worldMargin = 64; // units around everything that is in the map

/// Brushes and patches that move together: the world, or one brush entity.
struct Part {
    std::size_t entity = 0; ///< MapText::entities
    std::vector<Brush> brushes;
    struct Curve {
        const PatchText* text = nullptr;
        std::uint32_t shader = 0;
    };
    std::vector<Curve> patches;
    glm::dvec3 origin{0};
};

struct Fog {
    std::size_t brush = 0; ///< of the world
    std::int32_t effect = -1;
};

bool isGroup(const Entity& entity) { return level::equalNoCase(entity.className(), "func_group"); }

Bounds boundsOf(const PatchText& patch) {
    Bounds bounds;
    for (const PatchText::Control& control : patch.controls) bounds.extend(control.position);
    return bounds;
}

class Compiler {
public:
    Compiler(const MapText& map, const std::string& fileName, const level::Vfs& files,
             const level::ShaderLibrary& library)
        : map_(map), fileName_(fileName), shaders_(files, library), writer_(planes_, shaders_) {}

    Result<CompiledMap> compile() {
        gather();
        reportKeys();
        if (parts_.empty()) return Error{fileName_, "", "has no worldspawn with brushes or patches", ""};
        done("brushes");
        const Part& world = parts_.front();
        std::vector<Brush> structural;
        for (const Brush& brush : world.brushes)
            if (brush.structural) structural.push_back(brush);
        const BrushGrid grid(structural);
        const std::vector<std::uint8_t> all(shaders_.size(), 1);
        const std::vector<Fragment> solid = visibleFragments(structural, planes_, all);
        done("solid");
        SolidTree tree(solid, structural, grid, planes_, worldBounds());
        flood(tree);
        done("tree");

        std::vector<std::uint8_t> kept(shaders_.size());
        for (std::uint32_t i = 0; i < shaders_.size(); ++i) kept[i] = shaders_[i].kept ? 1 : 0;
        writeWorld(tree, kept);
        for (std::size_t i = 1; i < parts_.size(); ++i) writePart(parts_[i], kept);
        writeTree(tree);
        writeEntities();
        for (std::uint32_t i = 0; i < planes_.size(); ++i) {
            const Plane& plane = planes_[i];
            writer_.bsp.planes.push_back({Vec3(plane.normal), static_cast<float>(plane.distance)});
        }
        done("faces");
        result_.bsp = std::move(writer_.bsp);
        return std::move(result_);
    }

private:
    const MapText& map_;
    const std::string& fileName_;
    PlaneSet planes_;
    MapShaders shaders_;
    BspWriter writer_;
    std::deque<Part> parts_; ///< the world first
    std::vector<Fog> fogs_;
    CompiledMap result_;
    std::vector<std::vector<std::uint32_t>> leafFaces_, leafBrushes_;
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();

    void done(const char* stage) {
        const auto now = std::chrono::steady_clock::now();
        result_.times.emplace_back(stage, std::chrono::duration<double, std::milli>(now - last_).count());
        last_ = now;
    }
    void warn(int line, const std::string& text) {
        result_.warnings.push_back(fmt::format("{}: line {}: {}", fileName_, line, text));
    }

    void gather() {
        for (std::size_t i = 0; i < map_.entities.size(); ++i) {
            const MapEntity& entity = map_.entities[i];
            if (entity.brushes.empty() && entity.patches.empty()) continue;
            const bool ofWorld = level::equalNoCase(entity.entity.className(), "worldspawn") || isGroup(entity.entity);
            if (parts_.empty()) {
                parts_.emplace_back(); // the world, wherever it stands in the file
                if (!ofWorld) warn(entity.line, "a brush entity stands before worldspawn");
            }
            Part& part = ofWorld ? parts_.front() : parts_.emplace_back();
            part.entity = i;
            for (const BrushText& text : entity.brushes) addBrush(part, text);
            for (const PatchText& patch : entity.patches) {
                part.patches.push_back({&patch, shaders_.find(patch.shader)});
                ++result_.patches;
            }
            Bounds middle;
            for (const Brush& brush : part.brushes)
                if (brush.origin) middle.extend(brush.bounds.lower), middle.extend(brush.bounds.upper);
            if (!ofWorld && !middle.empty()) part.origin = 0.5 * (middle.lower + middle.upper);
            std::erase_if(part.brushes, [](const Brush& brush) { return brush.origin; });
        }
    }

    /// What an author may have hoped for and nobody reads, each once.
    void reportKeys() {
        static constexpr std::array<std::string_view, 34> known = {
            "classname",   "origin",     "light",         "_light",       "_color",    "target",       "targetname",
            "radius",      "spawnflags", "fade",          "scale",        "_samples",  "_extradist",   "extradist",
            "_anglescale", "_deviance",  "_filterradius", "_filteradius", "_filter",   "_flareshader", "_flare",
            "_sun",        "_style",     "style",         "angle",        "angles",    "mangle",       "notfree",
            "notteam",     "notsingle",  "gametype",      "_tb_layer",    "_tb_group", "_tb_name"};
        std::set<std::string> reported;
        std::size_t models = 0;
        int firstModel = 0;
        for (const MapEntity& entity : map_.entities) {
            if (level::equalNoCase(entity.entity.className(), "misc_model") && models++ == 0) firstModel = entity.line;
            if (!level::startsWithNoCase(entity.entity.className(), "light")) continue;
            for (const auto& [key, value] : entity.entity.pairs) {
                const std::string name = level::lower(key);
                if (std::find(known.begin(), known.end(), name) == known.end() && reported.insert(name).second)
                    warn(entity.line, fmt::format("a light has a key '{}' that nothing reads", key));
            }
        }
        if (models > 0)
            warn(firstModel,
                 fmt::format("{} misc_model: models are not read from .map text; a compiled .bsp has them", models));
    }

    void addBrush(Part& part, const BrushText& text) {
        std::string reason;
        std::optional<Brush> brush = makeBrush(text, planes_, reason);
        if (!brush) {
            warn(text.line, "the brush " + reason + "; it is left out");
            return;
        }
        ++result_.brushes;
        brush->hides = true;
        brush->structural = true;
        constexpr std::int32_t detail = 0x8000000;
        for (Side& side : brush->sides) {
            side.shader = shaders_.find(text.faces[side.face].shader);
            const MapShader& shader = shaders_[side.shader];
            brush->hides = brush->hides && shader.hides;
            brush->origin = brush->origin || shader.origin;
            brush->structural =
                brush->structural && (text.faces[side.face].contents & detail) == 0 && shader.shader.parms.structural;
        }
        brush->structural = brush->structural && brush->hides;
        part.brushes.push_back(std::move(*brush));
    }

    [[nodiscard]] Bounds worldBounds() const {
        Bounds bounds;
        for (const Brush& brush : parts_.front().brushes) {
            bounds.extend(brush.bounds.lower);
            bounds.extend(brush.bounds.upper);
        }
        for (const Part::Curve& curve : parts_.front().patches)
            for (const PatchText::Control& control : curve.text->controls) bounds.extend(control.position);
        if (bounds.empty()) bounds.extend(glm::dvec3(0));
        bounds.lower -= worldMargin;
        bounds.upper += worldMargin;
        return bounds;
    }

    void flood(SolidTree& tree) {
        std::vector<glm::dvec3> points;
        std::vector<const MapEntity*> owners;
        for (const MapEntity& entity : map_.entities) {
            if (!entity.brushes.empty() || !entity.patches.empty()) continue;
            const std::optional<Vec3> origin = entity.entity.vector("origin");
            if (!origin) continue;
            // Feet may stand in the floor by a rounding.
            points.emplace_back(glm::dvec3(*origin) + glm::dvec3(0, 0, 1));
            owners.push_back(&entity);
        }
        const std::optional<Leak> leak = tree.flood(points);
        if (!leak) return;
        result_.leakPath = leak->path;
        const MapEntity& owner = *owners[leak->point];
        warn(owner.line,
             fmt::format("the level leaks: {} sees the void around it, by {}; faces towards the void are kept",
                         owner.entity.className(), shown(leak->path)));
    }

    /// The last few points before the void: there is the hole.
    static std::string shown(const std::vector<glm::dvec3>& path) {
        std::string text;
        constexpr std::size_t most = 4;
        for (std::size_t i = path.size() > most ? path.size() - most : 0; i < path.size(); ++i)
            text += fmt::format("{}({:.0f} {:.0f} {:.0f})", text.empty() ? "" : " ", path[i].x, path[i].y, path[i].z);
        return text;
    }

    void beginModel(const Part& part) {
        level::BspModel model;
        Bounds bounds;
        for (const Brush& brush : part.brushes) {
            bounds.extend(brush.bounds.lower);
            bounds.extend(brush.bounds.upper);
        }
        for (const Part::Curve& curve : part.patches) {
            const Bounds curved = boundsOf(*curve.text);
            bounds.extend(curved.lower);
            bounds.extend(curved.upper);
        }
        if (bounds.empty()) bounds.extend(part.origin);
        model.mins = Vec3(bounds.lower - part.origin);
        model.maxs = Vec3(bounds.upper - part.origin);
        model.firstFace = static_cast<std::int32_t>(writer_.bsp.faces.size());
        model.firstBrush = static_cast<std::int32_t>(writer_.bsp.brushes.size());
        writer_.bsp.models.push_back(model);
    }
    void endModel() {
        level::BspModel& model = writer_.bsp.models.back();
        model.faceCount = static_cast<std::int32_t>(writer_.bsp.faces.size()) - model.firstFace;
        model.brushCount = static_cast<std::int32_t>(writer_.bsp.brushes.size()) - model.firstBrush;
    }

    struct Piece {
        Polygon polygon;
        std::int32_t fog = -1;
    };
    /// Faces are cut where fog begins: each piece is in one volume or in none.
    [[nodiscard]] std::vector<Piece> cutByFog(const Polygon& polygon, std::uint32_t plane) const {
        std::vector<Piece> pieces{{polygon, -1}};
        for (const Fog& fog : fogs_) {
            std::vector<Piece> cut;
            for (Piece& piece : pieces) {
                Polygon inside = piece.fog < 0 ? piece.polygon : Polygon{};
                std::vector<Piece> outside;
                for (const Side& side : parts_.front().brushes[fog.brush].sides) {
                    if ((side.plane & ~1U) == (plane & ~1U)) {
                        // In the volume's own border: inside if it looks into it.
                        if (side.plane == plane) inside.clear();
                        continue;
                    }
                    Split parts = split(inside, planes_[side.plane]);
                    if (hasArea(parts.front)) outside.push_back({std::move(parts.front), -1});
                    inside = std::move(parts.back);
                    if (inside.empty()) break;
                }
                if (!hasArea(inside)) {
                    cut.push_back(std::move(piece));
                    continue;
                }
                cut.push_back({std::move(inside), fog.effect});
                std::move(outside.begin(), outside.end(), std::back_inserter(cut));
            }
            pieces = std::move(cut);
        }
        return pieces;
    }
    /// The fog that holds a point.
    [[nodiscard]] std::int32_t fogAt(const glm::dvec3& point) const {
        for (const Fog& fog : fogs_) {
            const Brush& brush = parts_.front().brushes[fog.brush];
            if (std::all_of(brush.sides.begin(), brush.sides.end(),
                            [&](const Side& s) { return planes_[s.plane].above(point) < onPlane; }))
                return fog.effect;
        }
        return -1;
    }

    void writeWorld(const SolidTree& tree, const std::vector<std::uint8_t>& kept) {
        const Part& world = parts_.front();
        leafFaces_.resize(tree.leaves().size());
        leafBrushes_.resize(tree.leaves().size());
        std::vector<Fragment> fragments = visibleFragments(world.brushes, planes_, kept);
        beginModel(world);
        std::vector<std::uint32_t> leaves;
        for (std::size_t b = 0; b < world.brushes.size(); ++b) {
            const Brush& brush = world.brushes[b];
            const std::int32_t number = writer_.addBrush(brush, glm::dvec3(0));
            leaves.clear();
            tree.leavesNear(brush.bounds, leaves);
            for (const std::uint32_t leaf : leaves) leafBrushes_[leaf].push_back(static_cast<std::uint32_t>(number));
            const level::Shader& shader = shaders_[brush.sides.front().shader].shader;
            if (shader.fog) {
                fogs_.push_back({b, static_cast<std::int32_t>(writer_.bsp.effects.size())});
                writer_.bsp.effects.push_back({shader.name, number, -1});
            }
        }
        for (const Fragment& fragment : fragments) {
            const Brush& brush = world.brushes[fragment.brush];
            const Side& side = brush.sides[fragment.side];
            leaves.clear();
            tree.leavesInFront(fragment.polygon, side.plane, leaves);
            // What stands in the open inside a solid leaf touches nobody's eye either.
            std::erase_if(leaves, [&](std::uint32_t leaf) { return !tree.leaves()[leaf].reached; });
            if (leaves.empty()) continue;
            for (const Piece& piece : cutByFog(fragment.polygon, side.plane)) {
                const auto face = static_cast<std::uint32_t>(writer_.bsp.faces.size());
                writer_.addPolygon(piece.polygon, side, brush.text->faces[side.face], glm::dvec3(0), piece.fog);
                if (writer_.bsp.faces.size() > face)
                    for (const std::uint32_t leaf : leaves) leafFaces_[leaf].push_back(face);
            }
        }
        for (const Part::Curve& curve : world.patches) {
            if (!shaders_[curve.shader].kept) continue;
            const Bounds bounds = boundsOf(*curve.text);
            leaves.clear();
            tree.leavesNear(bounds, leaves);
            std::erase_if(leaves, [&](std::uint32_t leaf) { return !tree.leaves()[leaf].reached; });
            if (leaves.empty()) continue;
            const auto face = static_cast<std::uint32_t>(writer_.bsp.faces.size());
            writer_.addPatch(*curve.text, curve.shader, glm::dvec3(0), fogAt(0.5 * (bounds.lower + bounds.upper)));
            for (const std::uint32_t leaf : leaves) leafFaces_[leaf].push_back(face);
        }
        endModel();
    }

    void writePart(const Part& part, const std::vector<std::uint8_t>& kept) {
        beginModel(part);
        for (const Brush& brush : part.brushes) writer_.addBrush(brush, part.origin);
        for (const Fragment& fragment : visibleFragments(part.brushes, planes_, kept)) {
            const Brush& brush = part.brushes[fragment.brush];
            const Side& side = brush.sides[fragment.side];
            writer_.addPolygon(fragment.polygon, side, brush.text->faces[side.face], part.origin, -1);
        }
        for (const Part::Curve& curve : part.patches)
            if (shaders_[curve.shader].kept) writer_.addPatch(*curve.text, curve.shader, part.origin, -1);
        endModel();
    }

    static std::array<std::int32_t, 3> whole(const glm::dvec3& v, bool up) {
        std::array<std::int32_t, 3> result{};
        for (int axis = 0; axis < 3; ++axis)
            result.at(static_cast<std::size_t>(axis)) =
                static_cast<std::int32_t>(up ? std::ceil(v[axis]) : std::floor(v[axis]));
        return result;
    }

    void writeTree(const SolidTree& tree) {
        level::Bsp& bsp = writer_.bsp;
        for (const SolidTree::Node& node : tree.nodes())
            bsp.nodes.push_back({static_cast<std::int32_t>(node.plane), node.children, whole(node.bounds.lower, false),
                                 whole(node.bounds.upper, true)});
        for (std::size_t i = 0; i < tree.leaves().size(); ++i) {
            const SolidTree::Leaf& leaf = tree.leaves()[i];
            level::BspLeaf written;
            written.cluster = leaf.reached ? 0 : -1;
            written.area = leaf.reached ? 0 : -1;
            if (!leaf.bounds.empty()) {
                written.mins = whole(leaf.bounds.lower, false);
                written.maxs = whole(leaf.bounds.upper, true);
            }
            written.firstLeafFace = static_cast<std::int32_t>(bsp.leafFaces.size());
            written.leafFaceCount = static_cast<std::int32_t>(leafFaces_[i].size());
            written.firstLeafBrush = static_cast<std::int32_t>(bsp.leafBrushes.size());
            written.leafBrushCount = static_cast<std::int32_t>(leafBrushes_[i].size());
            bsp.leafFaces.insert(bsp.leafFaces.end(), leafFaces_[i].begin(), leafFaces_[i].end());
            bsp.leafBrushes.insert(bsp.leafBrushes.end(), leafBrushes_[i].begin(), leafBrushes_[i].end());
            bsp.leaves.push_back(written);
        }
        // One cluster that sees itself: everything is visible from everywhere.
        bsp.visibility.clusterCount = 1;
        bsp.visibility.bytesPerCluster = 8;
        bsp.visibility.bits.assign(8, 0);
        bsp.visibility.bits.front() = 1;
    }

    /// A word without quotes may hold one; inside quotes it would end there.
    static std::string plain(std::string text) {
        std::replace(text.begin(), text.end(), '"', '\'');
        return text;
    }

    void writeEntities() {
        std::size_t model = 0;
        std::vector<std::size_t> modelOf(map_.entities.size(), 0);
        for (const Part& part : parts_) {
            if (model > 0) modelOf[part.entity] = model;
            ++model;
        }
        for (std::size_t i = 0; i < map_.entities.size(); ++i) {
            const Entity& entity = map_.entities[i].entity;
            if (isGroup(entity)) continue;
            writer_.bsp.entities += "{\n";
            const bool placed = modelOf[i] > 0 && parts_[modelOf[i]].origin != glm::dvec3(0);
            for (const auto& [key, value] : entity.pairs) {
                if (modelOf[i] > 0 && level::equalNoCase(key, "model")) continue;
                if (placed && level::equalNoCase(key, "origin")) continue;
                writer_.bsp.entities += fmt::format("\"{}\" \"{}\"\n", plain(key), plain(value));
            }
            if (modelOf[i] > 0) writer_.bsp.entities += fmt::format("\"model\" \"*{}\"\n", modelOf[i]);
            if (placed) {
                const glm::dvec3& o = parts_[modelOf[i]].origin;
                writer_.bsp.entities += fmt::format("\"origin\" \"{:g} {:g} {:g}\"\n", o.x, o.y, o.z);
            }
            writer_.bsp.entities += "}\n";
        }
    }
};

} // namespace

Result<CompiledMap> compileMap(const MapText& map, const std::string& fileName, const level::Vfs& files,
                               const level::ShaderLibrary& shaders) {
    return Compiler(map, fileName, files, shaders).compile();
}

} // namespace pie::brushes
