#pragma once
// The bare cost of a frame's rays: what Embree alone takes for them, default scene and default build, hits not looked
// at. One at a time and in packets of 16 in the order in which the tracer made them; the faster of the two counts. Our
// own tracer takes its turn, with all that it does besides.

#include "apps/piebench/subject.h"

#include <cstdint>
#include <memory>

namespace piebench {

class EmbreeRays {
public:
    /// Records the rays of photons 0 … count − 1.
    EmbreeRays(const LoadedLevel& level, const pie::engine::Settings& settings,
               const pie::photons::TracerOptions& options, std::uint64_t count);
    ~EmbreeRays();
    EmbreeRays(const EmbreeRays&) = delete;
    EmbreeRays& operator=(const EmbreeRays&) = delete;

    struct Times {
        double single = 0, packets = 0, tracer = 0; ///< milliseconds of wall clock; tracer: ours, with the same rays
        double singleProcessor = 0, packetsProcessor = 0, tracerProcessor = 0; ///< of all threads together
    };
    [[nodiscard]] Times run() const;
    [[nodiscard]] std::size_t rays() const;
    [[nodiscard]] std::size_t stored() const; ///< photons, by our tracer

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace piebench
