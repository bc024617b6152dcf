#include "pie/core/parallel.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>

#ifdef __SANITIZE_THREAD__
#include <thread>
#include <vector>
#else
#include <tbb/parallel_for.h>

#include <memory>
#include <mutex>
#endif

namespace pie {
namespace {

std::atomic<unsigned> limit{0};

#ifdef __SANITIZE_THREAD__

/// oneTBB hands work over inside a library that the thread sanitizer does not see, and every result that comes back
/// would be called a race. Plain threads are as many and share as much; the sanitizer understands them.
template <class Chunk> void runParallel(std::size_t chunks, const Chunk& chunk) {
    std::atomic<std::size_t> next{0};
    std::vector<std::thread> workers;
    for (unsigned t = 0; t < threads(); ++t)
        workers.emplace_back([&] {
            for (std::size_t i = next++; i < chunks; i = next++) chunk(i);
        });
    for (std::thread& worker : workers) worker.join();
}

#else

/// One arena for every loop of the process, made again when the limit changes. Held by value so that a loop that is
/// still running keeps its own.
std::shared_ptr<tbb::task_arena> arena() {
    static std::mutex mutex;
    static std::shared_ptr<tbb::task_arena> current;
    static unsigned size = 0;
    const std::lock_guard lock(mutex);
    const unsigned wanted = threads();
    if (!current || size != wanted) {
        current = std::make_shared<tbb::task_arena>(static_cast<int>(wanted));
        size = wanted;
    }
    return current;
}

template <class Chunk> void runParallel(std::size_t chunks, const Chunk& chunk) {
    // Isolated: a thread that waits here must not pick up another loop's chunk while it holds a caller's lock.
    arena()->execute([&] { tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, chunks, chunk); }); });
}

#endif

} // namespace

void setThreads(unsigned count) { limit = count; }

unsigned threads() {
    const unsigned chosen = limit;
    return chosen != 0 ? chosen : static_cast<unsigned>(std::max(1, tbb::this_task_arena::max_concurrency()));
}

void detail::parallelChunks(std::size_t count, std::size_t grain, ChunkBody body) {
    if (count == 0) return;
    const std::size_t size = std::max<std::size_t>(1, grain);
    const std::size_t chunks = (count - 1) / size + 1;
    const auto chunk = [&](std::size_t i) { body(i * size, std::min(count, (i + 1) * size)); };
    if (chunks == 1 || threads() == 1) {
        for (std::size_t i = 0; i < chunks; ++i) chunk(i);
        return;
    }
    runParallel(chunks, chunk);
}

} // namespace pie
