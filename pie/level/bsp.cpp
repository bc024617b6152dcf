#include "pie/level/bsp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace pie::level {
namespace {

std::string magicOf(std::span<const std::byte> bytes) {
    std::string magic;
    for (const std::byte b : bytes.first(std::min<std::size_t>(4, bytes.size()))) magic += static_cast<char>(b);
    return magic;
}

std::int32_t wordAt(std::span<const std::byte> bytes, std::size_t offset) {
    std::int32_t value = -1;
    if (bytes.size() >= offset + sizeof value) std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

bool printable(std::span<const std::byte> bytes) {
    const auto head = bytes.first(std::min<std::size_t>(64, bytes.size()));
    return std::all_of(head.begin(), head.end(), [](std::byte b) {
        const auto c = std::to_integer<unsigned>(b);
        return c == '\t' || c == '\n' || c == '\r' || (c >= 0x20 && c < 0x7f);
    });
}

} // namespace

std::string_view lumpName(Lump lump) {
    static constexpr std::array<std::string_view, lumpCount> names = {
        "entities",     "shaders", "planes",    "nodes",         "leaves",    "leaf faces",
        "leaf brushes", "models",  "brushes",   "brush sides",   "vertices",  "mesh vertices",
        "effects",      "faces",   "lightmaps", "light volumes", "visibility"};
    return names.at(static_cast<std::size_t>(lump));
}

Format recognise(std::span<const std::byte> bytes) {
    const std::string magic = magicOf(bytes);
    const std::int32_t version = wordAt(bytes, 4);
    if (magic == "IBSP") {
        if (version == 46) return Format::Quake3;
        if (version == 47) return Format::QuakeLiveOrWolfenstein;
        return version == 38 ? Format::Quake2 : Format::Unknown;
    }
    if (magic == "RBSP") return Format::Raven;
    if (magic == "FBSP") return Format::Fusion;
    if (magic == "VBSP") return Format::Source;
    if (magic == "BSP2" || magic == "2PSB") return Format::Quake1;
    if (magic == std::string_view("PK\3\4", 4)) return Format::Archive;
    const std::int32_t first = wordAt(bytes, 0);
    if (bytes.size() >= 4 && (first == 29 || first == 30)) return Format::Quake1;
    return bytes.size() >= 4 && printable(bytes) ? Format::Text : Format::Unknown;
}

std::string dialect(std::span<const std::byte> bytes) {
    const std::string magic = magicOf(bytes);
    const std::int32_t version = wordAt(bytes, 4);
    switch (recognise(bytes)) {
    case Format::Quake3: return "IBSP 46 (Quake 3)";
    case Format::QuakeLiveOrWolfenstein: return "IBSP 47 (Return to Castle Wolfenstein, Enemy Territory or Quake Live)";
    case Format::Quake2: return "IBSP 38 (Quake 2)";
    case Format::Quake1:
        if (magic == "BSP2" || magic == "2PSB") return magic + " (Quake)";
        return wordAt(bytes, 0) == 29 ? "BSP 29 (Quake)" : "BSP 30 (Half-Life)";
    case Format::Raven: return fmt::format("RBSP {} (Raven: Soldier of Fortune 2, Jedi Knight)", version);
    case Format::Fusion: return fmt::format("FBSP {} (Fusion: Warsow)", version);
    case Format::Source: return fmt::format("VBSP {} (Valve Source)", version);
    case Format::Text: return "plain text";
    case Format::Archive: return "a zip (pk3) archive";
    case Format::Unknown: break;
    }
    if (bytes.size() < 8) return fmt::format("only {} bytes", bytes.size());
    if (magic == "IBSP") return fmt::format("IBSP {} (an unknown version)", version);
    std::string hex;
    for (const std::byte b : bytes.first(4)) hex += fmt::format("{:02x}", std::to_integer<unsigned>(b));
    return fmt::format("a file that starts with the bytes {}", hex);
}

} // namespace pie::level
