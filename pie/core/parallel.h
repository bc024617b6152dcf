#pragma once
// Parallel loops over oneTBB. The number of threads never changes a result: a loop body writes only what belongs to its
// own index, and whoever needs an order concatenates chunks in chunk order.

#include <cstddef>
#include <functional>

namespace pie {

/// Upper bound on the threads of all loops that start afterwards in this process; 0 = one per core (the default).
void setThreads(unsigned count);
[[nodiscard]] unsigned threads();

/// Calls body(begin, end) for consecutive chunks of at most `grain` indices that cover [0, count). Chunk borders depend
/// on `count` and `grain` only. Runs in the calling thread when one thread is allowed or one chunk suffices.
void parallelChunks(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body);

} // namespace pie
