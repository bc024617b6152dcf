// Searching allocates nothing: every operator new of this program is counted.

#include "pie/maps/exact.h"
#include "pie/maps/kd_tree.h"
#include "tests/maps/clouds.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::size_t> allocations{0};

void* allocate(std::size_t size, std::size_t alignment) {
    ++allocations;
    void* const memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}
} // namespace

// Not inlined: a compiler that sees only one of a pair takes free for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
[[gnu::noinline]] void* operator new[](std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
    return allocate(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void* operator new[](std::size_t size, std::align_val_t alignment) {
    return allocate(size, static_cast<std::size_t>(alignment));
}
// std::stable_sort asks like this.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
    return ::operator new(size);
}
[[gnu::noinline]] void* operator new[](std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
    return ::operator new(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace pie::maps {
namespace {

template <class Map> void expectNoAllocation() {
    const auto cloud = test::clouds(2000, 500).front();
    Map map;
    map.build(cloud.photons);
    NearestQueue queue;
    queue.reserve(200);
    std::size_t found = 0;
    const std::size_t before = allocations;
    for (const Vec3& query : cloud.queries) {
        map.nearest(
            query, 200, 3.0F, [](const photons::Photon&) { return true; }, queue);
        found += queue.found().size();
        map.forEachWithin(query, 1.0F, [&](const photons::Photon&, float) { ++found; });
    }
    EXPECT_EQ(allocations - before, 0U);
    EXPECT_GT(found, 50000U);
}

TEST(Allocations, AreCounted) {
    const std::size_t before = allocations;
    const std::vector<int> some(100);
    EXPECT_EQ(some.size(), 100U);
    EXPECT_EQ(allocations - before, 1U);
}

TEST(Allocations, NoneWhileSearchingTheKdTree) { expectNoAllocation<KdTree>(); }
TEST(Allocations, NoneWhileSearchingTheExactMap) { expectNoAllocation<ExactMap>(); }

} // namespace
} // namespace pie::maps
