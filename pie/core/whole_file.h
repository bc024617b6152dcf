#pragma once
// Files that appear whole or not at all.

#include "pie/core/result.h"

#include <filesystem>
#include <optional>
#include <string_view>

namespace pie {

/// Written beside its target and renamed; what stood there before stays when something goes wrong.
[[nodiscard]] std::optional<Error> writeWhole(const std::filesystem::path& target, std::string_view content);

} // namespace pie
