#pragma once
// Parts of model.cpp: one reader per format. They throw level::Damage.

#include "pie/brushes/model.h"

#include <string_view>

namespace pie::brushes {

[[nodiscard]] Model readMd3(std::span<const std::byte> bytes, int frame);
[[nodiscard]] Model readAse(std::string_view text);
[[nodiscard]] Model readObj(std::string_view text);

} // namespace pie::brushes
