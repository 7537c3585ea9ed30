// SPDX-License-Identifier: MIT
// Terrain from nothing that looks like some: an island of ridged mountains with eroded valleys, plains, a
// coast with bays and cliffs, and sea at 0 m. Integer hashes and plain arithmetic only: the same on every
// machine.
#pragma once

#include <cstdint>

namespace ig::terrain {

class SyntheticTerrain {
public:
    explicit SyntheticTerrain(uint64_t seed) noexcept : _seed(seed) {}
    // Metres, 0 to about 2000, at a place in metres from the island's middle. About a microsecond.
    double heightM(double eastM, double northM) const noexcept;

private:
    uint64_t _seed;
};

} // namespace ig::terrain
