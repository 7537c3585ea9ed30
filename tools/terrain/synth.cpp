// SPDX-License-Identifier: MIT
#include "tools/terrain/synth.h"

#include <algorithm>
#include <cmath>

namespace ig::terrain {

namespace {

struct Gradient {
    double x, y;
};

// Sixteen directions, of a length that makes the noise about -1 .. 1.
constexpr double kA = 1.5, kB = 1.38581929876693, kC = 1.06066017177982, kD = 0.57402514854763;
constexpr Gradient kCircle[16] = {{kA, 0},   {kB, kD},  {kC, kC},  {kD, kB},   {0, kA},    {-kD, kB},
                                  {-kC, kC}, {-kB, kD}, {-kA, 0},  {-kB, -kD}, {-kC, -kC}, {-kD, -kB},
                                  {0, -kA},  {kD, -kB}, {kC, -kC}, {kB, -kD}};

// At a lattice point: one of them (finaliser of SplitMix64: Steele et al. 2014).
Gradient lattice(uint64_t seed, int64_t x, int64_t y)
{
    uint64_t z = seed ^ (static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15ULL) ^
                 (static_cast<uint64_t>(y) * 0xd1342543de82ef95ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return kCircle[z >> 60];
}

struct Noise {
    double value, dx, dy;
};

// Gradient noise with quintic blending (Perlin 2002) and its derivative; value about -1 .. 1.
Noise noise(uint64_t seed, double x, double y)
{
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    const auto ix = static_cast<int64_t>(fx);
    const auto iy = static_cast<int64_t>(fy);
    const double u = x - fx;
    const double v = y - fy;
    const double su = u * u * u * (u * (u * 6 - 15) + 10);
    const double sv = v * v * v * (v * (v * 6 - 15) + 10);
    const double du = 30 * u * u * (u * (u - 2) + 1);
    const double dv = 30 * v * v * (v * (v - 2) + 1);
    const Gradient ga = lattice(seed, ix, iy);
    const Gradient gb = lattice(seed, ix + 1, iy);
    const Gradient gc = lattice(seed, ix, iy + 1);
    const Gradient gd = lattice(seed, ix + 1, iy + 1);
    const double a = ga.x * u + ga.y * v;
    const double b = gb.x * (u - 1) + gb.y * v;
    const double c = gc.x * u + gc.y * (v - 1);
    const double d = gd.x * (u - 1) + gd.y * (v - 1);
    const double twist = a - b - c + d;
    const double gx = ga.x - gb.x - gc.x + gd.x;
    const double gy = ga.y - gb.y - gc.y + gd.y;
    return {a + (b - a) * su + (c - a) * sv + twist * su * sv,
            ga.x + (gb.x - ga.x) * su + (gc.x - ga.x) * sv + gx * su * sv + du * ((b - a) + twist * sv),
            ga.y + (gb.y - ga.y) * su + (gc.y - ga.y) * sv + gy * su * sv + dv * ((c - a) + twist * su)};
}

// Octaves are turned against each other by the angle of a 3-4-5 triangle, so that no lattice shows.
struct Turn {
    double x, y;
    void next(double lacunarity)
    {
        const double tx = (0.8 * x - 0.6 * y) * lacunarity;
        y = (0.6 * x + 0.8 * y) * lacunarity;
        x = tx;
    }
};

double fractal(uint64_t seed, double x, double y, int octaves)
{
    double sum = 0;
    double weight = 0.5;
    for (Turn at{x, y}; octaves > 0; --octaves, at.next(2.03), weight *= 0.5, seed += 0x51ed27)
        sum += weight * noise(seed, at.x, at.y).value;
    return sum;
}

// Fractal whose octaves fade where the ground is steep already: smooth valley floors under rough flanks, as
// erosion leaves them.
double eroded(uint64_t seed, double x, double y, int octaves)
{
    double sum = 0;
    double weight = 0.5;
    double slopeX = 0;
    double slopeY = 0;
    for (Turn at{x, y}; octaves > 0; --octaves, at.next(1.97), weight *= 0.45, seed += 0x8f1bbd) {
        const Noise n = noise(seed, at.x, at.y);
        slopeX += n.dx * weight;
        slopeY += n.dy * weight;
        sum += weight * n.value / (1 + 2.2 * (slopeX * slopeX + slopeY * slopeY));
    }
    return sum;
}

// Ridged multifractal, after Musgrave (in Ebert et al., "Texturing and Modeling", ch. 16): 0 .. about 1.
double ridged(uint64_t seed, double x, double y, int octaves)
{
    double sum = 0;
    double weight = 0.5;
    double gate = 1;
    for (Turn at{x, y}; octaves > 0; --octaves, at.next(2.07), weight *= 0.43, seed += 0x2545f5) {
        const double ridge = 1 - std::abs(noise(seed, at.x, at.y).value);
        sum += weight * ridge * ridge * gate;
        gate = std::clamp(ridge * ridge * 1.6, 0.0, 1.0);
    }
    return sum;
}

double step(double low, double high, double value)
{
    const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

} // namespace

double SyntheticTerrain::heightM(double eastM, double northM) const noexcept
{
    const double km = 1e-3;
    const uint64_t seed = _seed * 0x2127599bf4325c37ULL;
    // Coordinates are bent a little, so that ridges wander.
    const double x = eastM * km + 3.0 * fractal(seed + 11, eastM * km / 9 + 5.3, northM * km / 9, 3);
    const double y = northM * km + 3.0 * fractal(seed + 12, eastM * km / 9, northM * km / 9 + 8.1, 3);

    const double farKm2 = (eastM * eastM + northM * northM) * km * km;
    const double shore =
        0.62 - 0.75 * farKm2 / (farKm2 + 90 * 90) + 0.9 * fractal(seed + 1, x / 38, y / 38, 6);
    if (shore <= 0)
        return 0;
    const double inland = step(0.0, 0.35, shore);
    const double range =
        step(-0.12, 0.38,
             fractal(seed + 2, x / 30 + 3.7, y / 30 - 1.9, 3) + 0.3 - 0.25 * farKm2 / (farKm2 + 40 * 40)) *
        inland;
    const double plain = 4 + 150 * inland * (0.5 + eroded(seed + 3, x / 7, y / 7, 7)) + 60 * shore;
    const double mountain = range > 0 ? range * (1450 * ridged(seed + 4, x / 11, y / 11, 7) +
                                                 420 * eroded(seed + 5, x / 4.5, y / 4.5, 6))
                                      : 0.0;
    double height = std::max(plain + mountain, 0.0) * step(0.0, 0.05, shore);

    // Along part of the coast, and along scarps inland, the ground breaks off.
    const double cliffs = step(0.05, 0.2, fractal(seed + 6, x / 14, y / 14, 2));
    height += 55 * cliffs * step(0.004, 0.012, shore);
    const double scarps = inland * step(0.1, 0.25, fractal(seed + 8, x / 17, y / 17, 2));
    if (scarps > 0)
        height += 70 * scarps * step(-0.003, 0.003, fractal(seed + 7, x / 21, y / 21, 5));
    return height;
}

} // namespace ig::terrain
