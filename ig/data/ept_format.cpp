// SPDX-License-Identifier: MIT
#include "ig/data/ept_format.h"

#include "ig/data/hierarchy.h"
#include "ig/data/page_codec.h"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace ig::data {

static_assert(std::endian::native == std::endian::little, "files are little-endian and read in place");

namespace {

constexpr uint32_t kFlagHoles = 1;

class Writer {
public:
    explicit Writer(std::span<uint8_t> out) : _out(out) {}
    template <class T>
    void put(T value)
    {
        std::memcpy(_out.data() + _at, &value, sizeof value);
        _at += sizeof value;
    }

private:
    std::span<uint8_t> _out;
    size_t _at = 0;
};

class Reader {
public:
    explicit Reader(std::span<const uint8_t> in) : _in(in) {}
    template <class T>
    T take()
    {
        T value;
        std::memcpy(&value, _in.data() + _at, sizeof value);
        _at += sizeof value;
        return value;
    }

private:
    std::span<const uint8_t> _in;
    size_t _at = 0;
};

// Comparisons are written so that NaN fails them.
bool within(double value, double low, double high)
{
    return value >= low && value <= high;
}

bool isPlausible(const lod::TerrainShape& s)
{
    constexpr double kSlackRad = 1e-9; // 6 mm on the Earth: degrees to radians and back
    if (!within(s.ellipsoid.semiMajorM, 1.0, 1e9) || !within(s.ellipsoid.flattening, 0.0, 0.9))
        return false;
    if (s.cols < 2 || s.rows < 2 || s.cols > kMaxGridPosts || s.rows > kMaxGridPosts)
        return false;
    if (s.deepestPage != deepestPageOf(s.cols, s.rows))
        return false;
    if (!(s.latitudeStepRad > 0) || !(s.longitudeStepRad > 0))
        return false;
    const double southRad = s.northRad - s.latitudeStepRad * (s.rows - 1);
    const double widthRad = s.longitudeStepRad * (s.cols - 1);
    return within(s.northRad, -kPi / 2, kPi / 2 + kSlackRad) &&
           within(southRad, -kPi / 2 - kSlackRad, kPi / 2) && within(s.westRad, -2 * kPi, 2 * kPi) &&
           within(widthRad, 0, 2 * kPi + kSlackRad);
}

bool isLength(float value)
{
    return value >= 0 && value <= std::numeric_limits<float>::max();
}

Unexpected<Error> damaged(const std::string& name, const std::string& what)
{
    return fail(ErrorKind::dataset, name + ": " + what + "; compile it again with eyepoint-terrain build");
}

} // namespace

uint64_t checksum(std::span<const uint8_t> bytes) noexcept
{
    return XXH3_64bits(bytes.data(), bytes.size());
}

bool isPlausible(const DatasetInfo& info) noexcept
{
    constexpr double kFarM = 1e9;
    return isPlausible(info.shape) && within(info.heightScaleM, 1e-6, 1e6) &&
           within(info.heightOffsetM, -kFarM, kFarM) && within(info.minHeightM, -kFarM, kFarM) &&
           within(info.maxHeightM, info.minHeightM, kFarM);
}

std::vector<uint8_t> encodeHeader(const EptHeader& header)
{
    const DatasetInfo& info = header.info;
    const lod::TerrainShape& shape = info.shape;
    const std::string text = info.verticalDatum + info.source;
    std::vector<uint8_t> bytes(kFixedHeaderBytes + text.size() + kChecksumBytes);
    Writer out(bytes);
    for (const uint8_t byte : kEptMagic)
        out.put(byte);
    out.put(kEptVersion);
    out.put(static_cast<uint32_t>(bytes.size()));
    out.put(info.fileBytes);
    out.put(header.indexOffset);
    out.put(header.pageCount);
    out.put(static_cast<uint32_t>(kIndexRecordBytes));
    out.put(info.checksum);
    out.put(shape.ellipsoid.semiMajorM);
    out.put(shape.ellipsoid.flattening);
    out.put(shape.northRad * kDegPerRad);
    out.put(shape.westRad * kDegPerRad);
    out.put(shape.latitudeStepRad * kDegPerRad);
    out.put(shape.longitudeStepRad * kDegPerRad);
    out.put(shape.cols);
    out.put(shape.rows);
    out.put(static_cast<uint32_t>(lod::kPageIntervals));
    out.put(static_cast<uint32_t>(shape.deepestPage));
    out.put(info.heightScaleM);
    out.put(info.heightOffsetM);
    out.put(info.minHeightM);
    out.put(info.maxHeightM);
    out.put(info.hasHoles ? kFlagHoles : 0U);
    out.put(static_cast<uint32_t>(info.verticalDatum.size()));
    out.put(static_cast<uint32_t>(info.source.size()));
    out.put(0U);
    std::copy(text.begin(), text.end(), bytes.begin() + kFixedHeaderBytes);
    const size_t covered = bytes.size() - kChecksumBytes;
    const uint64_t sum = checksum(std::span(bytes).first(covered));
    std::memcpy(bytes.data() + covered, &sum, sizeof sum);
    return bytes;
}

Result<EptHeader> decodeHeader(std::span<const uint8_t> bytes, uint64_t fileBytes, const std::string& name)
{
    if (bytes.size() < kEptMagic.size() || !std::equal(kEptMagic.begin(), kEptMagic.end(), bytes.begin()))
        return fail(ErrorKind::dataset,
                    name + ": not an .ept terrain dataset; make one with eyepoint-terrain build");
    if (bytes.size() < kFixedHeaderBytes)
        return damaged(name, "cut short within its header");
    Reader in(bytes.subspan(kEptMagic.size()));
    const auto version = in.take<uint32_t>();
    if (version != kEptVersion)
        return damaged(name, "format version " + std::to_string(version) + ", this program reads version " +
                                 std::to_string(kEptVersion));

    EptHeader header;
    DatasetInfo& info = header.info;
    lod::TerrainShape& shape = info.shape;
    header.headerBytes = in.take<uint32_t>();
    info.fileBytes = in.take<uint64_t>();
    header.indexOffset = in.take<uint64_t>();
    header.pageCount = in.take<uint32_t>();
    const auto recordBytes = in.take<uint32_t>();
    info.checksum = in.take<uint64_t>();
    shape.ellipsoid.semiMajorM = in.take<double>();
    shape.ellipsoid.flattening = in.take<double>();
    shape.northRad = in.take<double>() * kRadPerDeg;
    shape.westRad = in.take<double>() * kRadPerDeg;
    shape.latitudeStepRad = in.take<double>() * kRadPerDeg;
    shape.longitudeStepRad = in.take<double>() * kRadPerDeg;
    shape.cols = in.take<uint32_t>();
    shape.rows = in.take<uint32_t>();
    const auto pageIntervals = in.take<uint32_t>();
    const auto deepest = in.take<uint32_t>();
    info.heightScaleM = in.take<double>();
    info.heightOffsetM = in.take<double>();
    info.minHeightM = in.take<double>();
    info.maxHeightM = in.take<double>();
    const auto flags = in.take<uint32_t>();
    const uint64_t datumBytes = in.take<uint32_t>();
    const uint64_t sourceBytes = in.take<uint32_t>();
    const auto reserved = in.take<uint32_t>();

    if (datumBytes + sourceBytes > kMaxHeaderTextBytes ||
        header.headerBytes != kFixedHeaderBytes + datumBytes + sourceBytes + kChecksumBytes)
        return damaged(name, "damaged header (lengths)");
    if (header.headerBytes > bytes.size())
        return damaged(name, "cut short within its header");
    const size_t covered = static_cast<size_t>(header.headerBytes) - kChecksumBytes;
    if (Reader(bytes.subspan(covered)).take<uint64_t>() != checksum(bytes.first(covered)))
        return damaged(name, "damaged header (checksum)");
    if (info.fileBytes > fileBytes)
        return damaged(name, "cut short, " + std::to_string(fileBytes) + " of " +
                                 std::to_string(info.fileBytes) + " bytes");
    if (info.fileBytes < fileBytes)
        return damaged(name, std::to_string(fileBytes - info.fileBytes) + " bytes too long");

    shape.deepestPage = static_cast<int>(std::min<uint32_t>(deepest, lod::kMaxPageDepth + 1));
    info.hasHoles = flags == kFlagHoles;
    const uint64_t indexBytes = uint64_t{header.pageCount} * kIndexRecordBytes;
    if (flags > kFlagHoles || reserved != 0 || recordBytes != kIndexRecordBytes ||
        pageIntervals != lod::kPageIntervals || !isPlausible(info) ||
        header.pageCount != pageCountOf(shape) || header.indexOffset < header.headerBytes ||
        indexBytes > info.fileBytes || header.indexOffset != info.fileBytes - indexBytes)
        return damaged(name, "damaged header (values out of range)");
    const char* text = reinterpret_cast<const char*>(bytes.data()) + kFixedHeaderBytes;
    info.verticalDatum.assign(text, static_cast<size_t>(datumBytes));
    info.source.assign(text + datumBytes, static_cast<size_t>(sourceBytes));
    return header;
}

namespace {

uint8_t childMask(const lod::PageNode& node)
{
    unsigned mask = 0;
    for (unsigned i = 0; i < 4; ++i)
        mask |= node.child[i] != lod::kNoPage ? 1U << i : 0U;
    return static_cast<uint8_t>(mask);
}

} // namespace

void encodeRecord(const lod::PageNode& node, const PagePlace& place, std::span<uint8_t> record) noexcept
{
    Writer out(record);
    out.put(place.offset);
    out.put(place.checksum);
    out.put(place.bytes);
    out.put(node.x);
    out.put(node.y);
    out.put(node.depth);
    out.put(childMask(node));
    out.put(static_cast<uint8_t>(place.hasHoles ? 1 : 0));
    out.put(uint8_t{0});
    out.put(node.errorM);
    out.put(node.stitchedErrorM);
    for (const float error : node.quarterErrorM)
        out.put(error);
    out.put(place.minPost);
    out.put(place.maxPost);
}

bool decodeRecord(std::span<const uint8_t> record, lod::PageNode& node, PagePlace& place) noexcept
{
    Reader in(record);
    place.offset = in.take<uint64_t>();
    place.checksum = in.take<uint64_t>();
    place.bytes = in.take<uint32_t>();
    const auto x = in.take<uint32_t>();
    const auto y = in.take<uint32_t>();
    const auto depth = in.take<uint8_t>();
    const auto mask = in.take<uint8_t>();
    const auto flags = in.take<uint8_t>();
    const auto reserved = in.take<uint8_t>();
    if (x != node.x || y != node.y || depth != node.depth || mask != childMask(node) || flags > 1 ||
        reserved != 0)
        return false;
    place.hasHoles = flags == 1;
    bool fine = place.bytes > 0 && place.bytes <= kMaxPayloadBytes;
    node.errorM = in.take<float>();
    node.stitchedErrorM = in.take<float>();
    fine = fine && isLength(node.errorM) && isLength(node.stitchedErrorM);
    for (float& error : node.quarterErrorM) {
        error = in.take<float>();
        fine = fine && isLength(error) && error <= node.errorM;
    }
    place.minPost = in.take<int16_t>();
    place.maxPost = in.take<int16_t>();
    return fine && place.minPost <= place.maxPost;
}

} // namespace ig::data
