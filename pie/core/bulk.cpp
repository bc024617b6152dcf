#include "pie/core/bulk.h"

#include <sys/mman.h>

#include <new>

namespace pie {
namespace {

/// Below this, the heap's own reserves do better.
constexpr std::size_t large = std::size_t{1} << 16;

/// The address sanitizer guards what comes from the heap.
constexpr bool fromSystem(std::size_t bytes) {
#ifdef __SANITIZE_ADDRESS__
    static_cast<void>(bytes);
    return false;
#else
    return bytes >= large;
#endif
}

} // namespace

void* allocateBulk(std::size_t bytes) {
    if (!fromSystem(bytes)) return ::operator new(bytes);
    void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    return memory;
}

void freeBulk(void* memory, std::size_t bytes) noexcept {
    if (fromSystem(bytes))
        munmap(memory, bytes);
    else
        ::operator delete(memory);
}

} // namespace pie
