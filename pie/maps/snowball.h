#pragma once
// The snowball feature (pi-engine 4.4, parameter 14): one hit fills several photons into the map, spread over a small
// circle around it, as if the circle had been hit by that many. No ray more is traced.
//
// Call it on the photons of a frame before they go into the map. Each photon becomes `size` of them with its flux in
// equal parts; the first stays where it is, the others lie on points of a low-discrepancy sequence in the disc, turned
// and shifted per photon. A point that would leave the photon's own triangle stays at the hit instead, so that none
// floats in the air or lands behind a corner. Flux, directions, bounces and the order of the photons stay; what a
// photon becomes depends on its position alone.

#include "pie/photons/photon.h"
#include "pie/scene/scene.h"

#include <vector>

namespace pie::maps {

/// `size` 0 or 1, or a radius that is not above 0: nothing happens. A frame is kept below 2^26 photons: where it would
/// grow past that, `size` is cut.
void snowball(std::vector<photons::Photon>& photons, const scene::Scene& scene, unsigned size, float radius);

} // namespace pie::maps
