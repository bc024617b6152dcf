#pragma once
// A vector for much that is written at once, such as a picture. Two things differ from std::vector: resize() leaves
// new elements as they are, to be written by the caller; and large ones get all their pages from the system in one call
// instead of one interruption each, which costs as much as decoding a JPEG does.

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace pie {

/// Memory for `bytes` bytes, aligned for any type. Throws std::bad_alloc.
[[nodiscard]] void* allocateBulk(std::size_t bytes);
void freeBulk(void* memory, std::size_t bytes) noexcept;

template <class T> struct BulkAllocator {
    static_assert(std::is_trivially_destructible_v<T>); // bytes that are written over
    using value_type = T;

    BulkAllocator() = default;
    template <class Other>
    BulkAllocator(const BulkAllocator<Other>& /*other*/) {} // NOLINT(google-explicit-constructor)

    [[nodiscard]] T* allocate(std::size_t count) { return static_cast<T*>(allocateBulk(count * sizeof(T))); }
    void deallocate(T* memory, std::size_t count) noexcept { freeBulk(memory, count * sizeof(T)); }
    template <class Other, class... Arguments> void construct(Other* place, Arguments&&... arguments) {
        if constexpr (sizeof...(Arguments) > 0) std::construct_at(place, std::forward<Arguments>(arguments)...);
    }
    bool operator==(const BulkAllocator& /*other*/) const { return true; }
};

template <class T> using BulkVector = std::vector<T, BulkAllocator<T>>;

} // namespace pie
