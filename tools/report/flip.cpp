// SPDX-License-Identifier: MIT
#include "tools/report/flip.h"

#include "tools/report/filter.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

namespace report {

namespace {

// Constants of the paper: exponents and the redistribution of table 3, width of the feature detector in
// degrees (sec. 4.2).
constexpr double kColourExponent = 0.7;
constexpr double kFeatureExponent = 0.5;
constexpr double kKnee = 0.4;       // share of the largest difference that is spread out ...
constexpr double kKneeValue = 0.95; // ... over this share of the values
constexpr double kFeatureDeg = 0.082;
constexpr double kPi = 3.14159265358979323846;

using Colour = std::array<float, 3>;
using Channels = std::array<std::vector<float>, 3>;

constexpr float kWhiteX = 0.950428545F; // XYZ of linear RGB (1, 1, 1); Y is 1
constexpr float kWhiteZ = 1.088900371F;

// sRGB primaries (IEC 61966-2-1); Y of white is 1.
Colour xyzOf(const Colour& rgb)
{
    return {0.4124564F * rgb[0] + 0.3575761F * rgb[1] + 0.1804375F * rgb[2],
            0.2126729F * rgb[0] + 0.7151522F * rgb[1] + 0.0721750F * rgb[2],
            0.0193339F * rgb[0] + 0.1191920F * rgb[1] + 0.9503041F * rgb[2]};
}

Colour rgbOf(const Colour& xyz)
{
    return {3.2404542F * xyz[0] - 1.5371385F * xyz[1] - 0.4985314F * xyz[2],
            -0.9692660F * xyz[0] + 1.8760108F * xyz[1] + 0.0415560F * xyz[2],
            0.0556434F * xyz[0] - 0.2040259F * xyz[1] + 1.0572252F * xyz[2]};
}

// A linear opponent space: luminance, red to green, blue to yellow.
Colour opponentOf(const Colour& xyz)
{
    const float x = xyz[0] / kWhiteX;
    const float z = xyz[2] / kWhiteZ;
    return {116 * xyz[1] - 16, 500 * (x - xyz[1]), 200 * (xyz[1] - z)};
}

Colour xyzOfOpponent(const Colour& c)
{
    const float y = (c[0] + 16) / 116;
    return {(y + c[1] / 500) * kWhiteX, y, (y - c[2] / 200) * kWhiteZ};
}

// CIE L*a*b* with chroma scaled by lightness (Hunt effect).
Colour huntLabOf(const Colour& rgb)
{
    const auto f = [](float t) {
        constexpr float kDelta = 6.0F / 29.0F;
        return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0F / 29.0F;
    };
    const Colour xyz = xyzOf(rgb);
    const float x = f(xyz[0] / kWhiteX);
    const float y = f(xyz[1]);
    const float z = f(xyz[2] / kWhiteZ);
    const float lightness = 116 * y - 16;
    return {lightness, 0.01F * lightness * 500 * (x - y), 0.01F * lightness * 200 * (y - z)};
}

// HyAB: city block between lightness and chroma (Abasi, Amani Tehran & Fairchild 2020).
double hyAb(const Colour& a, const Colour& b)
{
    return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

Channels opponentChannels(const PictureView& picture)
{
    static const std::array<float, 256> kLinear = [] {
        std::array<float, 256> table{};
        for (size_t i = 0; i < table.size(); ++i) {
            const double v = static_cast<double>(i) / 255;
            table[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
        }
        return table;
    }();
    Channels out;
    for (std::vector<float>& channel : out) {
        channel.resize(picture.pixels());
    }
    for (size_t i = 0; i < picture.pixels(); ++i) {
        const auto linear = [&](size_t c) {
            return kLinear[std::to_integer<size_t>(picture.rgba[4 * i + c])];
        };
        const Colour opponent = opponentOf(xyzOf({linear(0), linear(1), linear(2)}));
        for (size_t c = 0; c < 3; ++c) {
            out[c][i] = opponent[c];
        }
    }
    return out;
}

// A sum of two Gaussians, the spatial form of a contrast sensitivity (table 1 of the paper).
struct Sensitivity {
    double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> kSensitivity{
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};
constexpr double kWidestB = 0.04;

// The Gaussian a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees, has sigma sqrt(b / 2) / pi.
double sigmaPx(double b, double pixelsPerDegree)
{
    return std::sqrt(b / 2) / kPi * pixelsPerDegree;
}

void seen(Channels& opponent, Filter& filter, double pixelsPerDegree)
{
    const int radius = static_cast<int>(std::ceil(3 * sigmaPx(kWidestB, pixelsPerDegree)));
    for (size_t c = 0; c < 3; ++c) {
        const Sensitivity& s = kSensitivity[c];
        // Volume of each Gaussian in the plane before both are brought to 1 together.
        const auto volume = [&](double a, double b) {
            const double sigma = sigmaPx(b, pixelsPerDegree);
            double sum = 0;
            for (int x = -radius; x <= radius; ++x) {
                sum += std::exp(-0.5 * x * x / (sigma * sigma));
            }
            return a * std::sqrt(kPi / b) * sum * sum;
        };
        const std::vector<float> first = gaussian(sigmaPx(s.b1, pixelsPerDegree), radius);
        std::vector<float> out = filter.apply(opponent[c], first, first);
        if (s.a2 > 0) {
            const std::vector<float> second = gaussian(sigmaPx(s.b2, pixelsPerDegree), radius);
            const std::vector<float> more = filter.apply(opponent[c], second, second);
            const double v1 = volume(s.a1, s.b1);
            const double v2 = volume(s.a2, s.b2);
            const auto w1 = static_cast<float>(v1 / (v1 + v2));
            for (size_t i = 0; i < out.size(); ++i) {
                out[i] = w1 * out[i] + (1 - w1) * more[i];
            }
        }
        opponent[c] = std::move(out);
    }
}

// Edges and points of the luminance: lengths of the first and second derivatives of a Gaussian, each kernel's
// positive and negative parts brought to 1.
struct Features {
    std::vector<float> edge, point;
};

std::vector<float> balanced(std::vector<float> kernel)
{
    float positive = 0;
    float negative = 0;
    for (const float value : kernel) {
        (value > 0 ? positive : negative) += std::abs(value);
    }
    for (float& value : kernel) {
        value /= value > 0 ? positive : negative;
    }
    return kernel;
}

Features featuresOf(const std::vector<float>& luminance, Filter& filter, double pixelsPerDegree)
{
    const double sigma = 0.5 * kFeatureDeg * pixelsPerDegree;
    const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
    const std::vector<float> smooth = gaussian(sigma, radius);
    std::vector<float> first = smooth;
    std::vector<float> second = smooth;
    for (int x = -radius; x <= radius; ++x) {
        const auto i = static_cast<size_t>(x + radius);
        first[i] *= static_cast<float>(-x);
        second[i] *= static_cast<float>(x * x / (sigma * sigma) - 1);
    }
    first[static_cast<size_t>(radius)] = 0;
    const auto lengths = [&](std::vector<float> kernel) {
        // Without a value of one sign (far too few pixels per degree) there is nothing to find.
        const auto [least, most] = std::minmax_element(kernel.begin(), kernel.end());
        if (!(*least < 0 && *most > 0)) {
            return std::vector<float>(luminance.size(), 0.0F);
        }
        kernel = balanced(std::move(kernel));
        std::vector<float> across = filter.apply(luminance, kernel, smooth);
        const std::vector<float> down = filter.apply(luminance, smooth, kernel);
        for (size_t i = 0; i < across.size(); ++i) {
            across[i] = std::sqrt(across[i] * across[i] + down[i] * down[i]);
        }
        return across;
    };
    return {lengths(first), lengths(second)};
}

// Small differences are spread out: they are what is to be told apart.
double redistributed(double difference, double most)
{
    const double knee = kKnee * most;
    return difference < knee ? kKneeValue / knee * difference
                             : kKneeValue + (difference - knee) / (most - knee) * (1 - kKneeValue);
}

} // namespace

FlipDifference flipDifference(const PictureView& truth, const PictureView& drawn, double pixelsPerDegree)
{
    assert(truth.widthPx == drawn.widthPx && truth.heightPx == drawn.heightPx && pixelsPerDegree > 0);
    const double most = std::pow(hyAb(huntLabOf({0, 1, 0}), huntLabOf({0, 0, 1})), kColourExponent);
    Filter filter(truth.widthPx, truth.heightPx);
    std::array<Channels, 2> opponent{opponentChannels(truth), opponentChannels(drawn)};
    std::array<Features, 2> features;
    for (size_t k = 0; k < 2; ++k) {
        std::vector<float> luminance = opponent[k][0];
        for (float& value : luminance) {
            value = (value + 16) / 116;
        }
        features[k] = featuresOf(luminance, filter, pixelsPerDegree);
        seen(opponent[k], filter, pixelsPerDegree);
    }
    const auto lab = [&](size_t k, size_t pixel) {
        Colour rgb =
            rgbOf(xyzOfOpponent({opponent[k][0][pixel], opponent[k][1][pixel], opponent[k][2][pixel]}));
        for (float& value : rgb) {
            value = std::clamp(value, 0.0F, 1.0F);
        }
        return huntLabOf(rgb);
    };
    FlipDifference difference;
    difference.map.resize(truth.pixels());
    double sum = 0;
    for (size_t i = 0; i < truth.pixels(); ++i) {
        const double colour = redistributed(std::pow(hyAb(lab(0, i), lab(1, i)), kColourExponent), most);
        const double feature = std::max(std::abs(features[0].edge[i] - features[1].edge[i]),
                                        std::abs(features[0].point[i] - features[1].point[i]));
        const double flip =
            std::pow(colour, 1 - std::min(1.0, std::pow(feature / std::sqrt(2.0), kFeatureExponent)));
        difference.map[i] = static_cast<float>(flip);
        sum += flip;
    }
    difference.mean = sum / static_cast<double>(truth.pixels());
    return difference;
}

} // namespace report
