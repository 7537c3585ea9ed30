// SPDX-License-Identifier: MIT
// CIGI 3.3 packet layouts as field tables. Private to the codec. Byte 0 is the id and byte 1 the size of
// every packet; offsets count from the packet's first byte; what is not listed is reserved.
#pragma once

#include "hostif/packet_fields.h"

#include <array>
#include <tuple>

namespace hostif::cigi33 {

using detail::Bits;
using detail::Constant;
using detail::Gated;
using detail::Number;

inline constexpr uint8_t kMajorVersion = 3;
inline constexpr uint16_t kByteSwapMagic = 0x8000; // in the sender's order
inline constexpr size_t kHeadSize = 24;
inline constexpr size_t kOldHeadSize = 16; // 3.0 and 3.1
inline constexpr float kTurnDeg = 360.0F;

template <class Message>
struct Layout;

template <>
struct Layout<IgControl> {
    using M = IgControl;
    static constexpr uint8_t kId = 1;
    static constexpr auto kFields = std::tuple{
        Constant{2, kMajorVersion},
        Number{3, &M::databaseNumber},
        Bits{4, 0, 2, &M::mode},
        Bits{4, 2, 1, &M::timestampValid},
        Bits{4, 3, 1, &M::extrapolationEnable},
        Bits{4, 4, 4, &M::minorVersion},
        Constant{6, kByteSwapMagic},
        Number{8, &M::hostFrameNumber},
        Number{12, &M::timestampTicks},
        Number{16, &M::lastIgFrameNumber},
    };
};

template <>
struct Layout<StartOfFrame> {
    using M = StartOfFrame;
    static constexpr uint8_t kId = 101;
    static constexpr auto kFields = std::tuple{
        Constant{2, kMajorVersion},
        Number{3, &M::databaseNumber},
        Number{4, &M::igStatus},
        Bits{5, 0, 2, &M::mode},
        Bits{5, 2, 1, &M::timestampValid},
        Bits{5, 3, 1, &M::hostEarthModel},
        Bits{5, 4, 4, &M::minorVersion},
        Constant{6, kByteSwapMagic},
        Number{8, &M::igFrameNumber},
        Number{12, &M::timestampTicks},
        Number{16, &M::lastHostFrameNumber},
    };
};

template <>
struct Layout<EntityControl> {
    using M = EntityControl;
    static constexpr uint8_t kId = 2;
    static constexpr size_t kSize = 48;
    static constexpr auto kFields = std::tuple{
        Number{2, &M::entityId},
        Bits{4, 0, 2, &M::state, 2},
        Bits{4, 2, 1, &M::attached},
        Bits{4, 3, 1, &M::collisionDetection},
        Bits{4, 4, 1, &M::inheritAlpha},
        Bits{4, 5, 2, &M::clamp, 2},
        Bits{5, 0, 1, &M::animationBackward},
        Bits{5, 1, 1, &M::animationLoops},
        Bits{5, 2, 2, &M::animation},
        Bits{5, 4, 1, &M::extrapolationEnable},
        Number{6, &M::alpha},
        Number{8, &M::entityType},
        Number{10, &M::parentId},
        Number<M, float>{12, &M::rollDeg, -kTurnDeg, kTurnDeg},
        Number<M, float>{16, &M::pitchDeg, -90, 90},
        Number<M, float>{20, &M::yawDeg, -kTurnDeg, kTurnDeg},
        Number{24, &M::latitudeDegOrXM},
        Number{32, &M::longitudeDegOrYM},
        Number{40, &M::altitudeOrZM},
    };
};

template <>
struct Layout<ViewControl> {
    using M = ViewControl;
    static constexpr uint8_t kId = 16;
    static constexpr size_t kSize = 32;
    static constexpr auto kFields = std::tuple{
        Number{2, &M::viewId},
        Number{4, &M::groupId},
        Number{6, &M::entityId},
        Gated<M>{5, 0, 8, &M::xOffsetM},
        Gated<M>{5, 1, 12, &M::yOffsetM},
        Gated<M>{5, 2, 16, &M::zOffsetM},
        Gated<M>{5, 3, 20, &M::rollDeg, -kTurnDeg, kTurnDeg},
        Gated<M>{5, 4, 24, &M::pitchDeg, -90, 90},
        Gated<M>{5, 5, 28, &M::yawDeg, -kTurnDeg, kTurnDeg},
    };
};

template <>
struct Layout<ViewDefinition> {
    using M = ViewDefinition;
    static constexpr uint8_t kId = 21;
    static constexpr size_t kSize = 32;
    // The protocol's limits are open intervals.
    static constexpr float kEdgeDeg = 89.9999F;
    static constexpr float kLeastM = std::numeric_limits<float>::min();
    static constexpr float kMostM = std::numeric_limits<float>::max();
    static constexpr auto kFields = std::tuple{
        Number{2, &M::viewId},
        Number{4, &M::groupId},
        Bits{5, 6, 2, &M::mirror},
        Bits{6, 0, 3, &M::pixelReplication},
        Bits{6, 3, 1, &M::orthographic},
        Bits{6, 4, 1, &M::reorder},
        Bits{6, 5, 3, &M::viewType},
        Gated<M>{5, 0, 8, &M::nearM, kLeastM, kMostM},
        Gated<M>{5, 1, 12, &M::farM, kLeastM, kMostM},
        Gated<M>{5, 2, 16, &M::leftDeg, -kEdgeDeg, kEdgeDeg},
        Gated<M>{5, 3, 20, &M::rightDeg, -kEdgeDeg, kEdgeDeg},
        Gated<M>{5, 4, 24, &M::topDeg, -kEdgeDeg, kEdgeDeg},
        Gated<M>{5, 5, 28, &M::bottomDeg, -kEdgeDeg, kEdgeDeg},
    };
};

// Sizes of all packets that have one size, by id; 0 for the rest. Ids 1 and 101 come first in a message
// and are looked at apart.
inline constexpr std::array<uint8_t, 256> kFixedSize = [] {
    std::array<uint8_t, 256> size{};
    constexpr std::array<uint8_t, 35> kFromHost{0,  48, 24, 32, 16, 32, 16, 32, 16, 32, 48, 56,
                                                24, 32, 8,  32, 24, 8,  24, 24, 32, 40, 48, 32,
                                                64, 56, 8,  32, 56, 0,  0,  0,  8,  40, 16}; // 1..35
    constexpr std::array<uint8_t, 17> kFromIg{0, 16, 40, 16, 56, 24, 48, 48, 32,
                                              8, 16, 8,  16, 16, 8,  16, 0}; // 101..117
    for (size_t i = 0; i < kFromHost.size(); ++i)
        size[1 + i] = kFromHost[i];
    for (size_t i = 0; i < kFromIg.size(); ++i)
        size[101 + i] = kFromIg[i];
    return size;
}();

// Ids that CIGI 3.3 gives a meaning.
constexpr bool isStandardId(uint8_t id) noexcept
{
    return (id >= 1 && id <= 35) || (id >= 101 && id <= 117);
}

} // namespace hostif::cigi33
