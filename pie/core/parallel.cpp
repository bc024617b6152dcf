#include "pie/core/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>

namespace pie {
namespace {

std::atomic<unsigned> limit{0};

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

} // namespace

void setThreads(unsigned count) { limit = count; }

unsigned threads() {
    const unsigned chosen = limit;
    return chosen != 0 ? chosen : static_cast<unsigned>(std::max(1, tbb::this_task_arena::max_concurrency()));
}

void parallelChunks(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
    if (count == 0) return;
    const std::size_t size = std::max<std::size_t>(1, grain);
    const std::size_t chunks = (count - 1) / size + 1;
    const auto chunk = [&](std::size_t i) { body(i * size, std::min(count, (i + 1) * size)); };
    if (chunks == 1 || threads() == 1) {
        for (std::size_t i = 0; i < chunks; ++i) chunk(i);
        return;
    }
    // Isolated: a thread that waits here must not pick up another loop's chunk while it holds a caller's lock.
    arena()->execute([&] { tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, chunks, chunk); }); });
}

} // namespace pie
