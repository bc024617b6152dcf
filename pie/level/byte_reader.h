#pragma once
// Little-endian records out of untrusted bytes. A reader never leaves its span: reading past the end throws Damage,
// which stays inside the file that reads.

#include "pie/core/vec.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace pie::level {

static_assert(std::endian::native == std::endian::little, "records are copied as they stand in the file");

/// A defect of a file; what() is the reason without the file's name.
class Damage : public std::runtime_error {
public:
    Damage(std::string where, const std::string& why) : std::runtime_error(why), place(std::move(where)) {}
    std::string place; ///< "lump faces, record 12"
};

class ByteReader {
public:
    explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

    template <class T> T read() {
        static_assert(std::is_trivially_copyable_v<T>);
        T value;
        copy(&value, sizeof value);
        return value;
    }
    std::int32_t integer() { return read<std::int32_t>(); }
    float real() { return read<float>(); }
    Vec2 vec2() {
        const float x = real();
        return {x, real()};
    }
    Vec3 vec3() {
        const float x = real();
        const float y = real();
        return {x, y, real()};
    }
    /// A name in a field of fixed length, ended by NUL or by the field.
    std::string name(std::size_t length) {
        std::string text(length, '\0');
        copy(text.data(), length);
        text.resize(std::min(text.find('\0'), length));
        return text;
    }
    void copy(void* into, std::size_t size) {
        if (size > left()) throw Damage("", "ends too early");
        if (size != 0) std::memcpy(into, bytes_.data() + at_, size);
        at_ += size;
    }

private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
};

} // namespace pie::level
