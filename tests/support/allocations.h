#pragma once
// Counts every operator new of a test program that has allocations.cpp among its sources.

#include <cstddef>

namespace pie::test {

/// So far, in all threads.
[[nodiscard]] std::size_t allocations();

} // namespace pie::test
