#pragma once
// Parallel loops over oneTBB. The number of threads never changes a result: a loop body writes only what belongs to its
// own index, and whoever needs an order concatenates chunks in chunk order.

#include <cstddef>

namespace pie {

/// Upper bound on the threads of all loops that start afterwards in this process; 0 = one per core (the default).
void setThreads(unsigned count);
[[nodiscard]] unsigned threads();

namespace detail {
/// A loop body by reference: a std::function may allocate, and frames run loops.
struct ChunkBody {
    const void* body;
    void (*call)(const void* body, std::size_t begin, std::size_t end);
    void operator()(std::size_t begin, std::size_t end) const { call(body, begin, end); }
};
void parallelChunks(std::size_t count, std::size_t grain, ChunkBody body);
} // namespace detail

/// Calls body(begin, end) for consecutive chunks of at most `grain` indices that cover [0, count). Chunk borders depend
/// on `count` and `grain` only. Runs in the calling thread when one thread is allowed or one chunk suffices.
template <class Body> void parallelChunks(std::size_t count, std::size_t grain, const Body& body) {
    detail::parallelChunks(count, grain, {&body, [](const void* what, std::size_t begin, std::size_t end) {
                                              (*static_cast<const Body*>(what))(begin, end);
                                          }});
}

} // namespace pie
