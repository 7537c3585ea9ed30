// SPDX-License-Identifier: MIT
#include "counted_new.h"
#include "ig/data/dataset.h"
#include "ig/data/ept_format.h"
#include "ig/data/page_codec.h"
#include "ig/data/page_mesh.h"
#include "temp_dir.h"
#include "terrain_files.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <thread>

using namespace ig;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double hills(uint32_t c, uint32_t r)
{
    return 300 + 200 * std::sin(c * 0.11) * std::cos(r * 0.07) + 9 * std::sin(c * r * 1.7);
}

void compile(const std::string& path, uint32_t cols, uint32_t rows, double scaleM = 0.1)
{
    const auto made = terrain::compileHeights(cols, rows, test::somePlace(scaleM), hills, path);
    INFO((made ? "" : made.error().message));
    REQUIRE(made);
}

data::Dataset opened(const std::string& path)
{
    Result<data::Dataset> dataset = data::Dataset::open(path);
    INFO((dataset ? "" : dataset.error().message));
    REQUIRE(dataset);
    return std::move(*dataset);
}

// Whether open refuses the file or a page of it does not read, each with words.
bool isNoticed(const std::string& path)
{
    const Result<data::Dataset> dataset = data::Dataset::open(path);
    if (!dataset)
        return dataset.error().kind == ErrorKind::dataset && dataset.error().message.find(path) == 0;
    data::PageReader reader(*dataset);
    for (uint32_t page = 0; page < dataset->pages().size(); ++page)
        if (const auto read = reader.read(page); !read)
            return read.error().kind == ErrorKind::dataset &&
                   read.error().message.find("page depth") != std::string::npos;
    return false;
}

} // namespace

TEST_CASE("every page has the posts of the grid, padding repeats the last ones")
{
    const test::TempDir dir;
    const std::string path = dir.file("a.ept");
    for (const auto& [cols, rows] : {std::pair(2U, 2U), {65U, 65U}, {66U, 3U}, {200U, 131U}, {2U, 300U}}) {
        compile(path, cols, rows);
        const data::Dataset dataset = opened(path);
        const data::DatasetInfo& info = dataset.info();
        REQUIRE(info.shape.cols == cols);
        REQUIRE(info.shape.rows == rows);
        data::PageReader reader(dataset);
        int wrong = 0;
        for (uint32_t page = 0; page < dataset.pages().size(); ++page) {
            const lod::PageNode& node = dataset.pages()[page];
            const auto read = reader.read(page);
            REQUIRE(read);
            const data::PageHeights& heights = **read;
            for (uint32_t j = 0; j < 65; ++j)
                for (uint32_t i = 0; i < 65; ++i) {
                    const int shift = info.shape.deepestPage - node.depth;
                    const uint32_t c = std::min((node.x * 64 + i) << shift, cols - 1);
                    const uint32_t r = std::min((node.y * 64 + j) << shift, rows - 1);
                    wrong += heights.post[j * 65 + i] != std::lround(hills(c, r) / 0.1) ? 1 : 0;
                    const double h = heights.post[j * 65 + i] * info.heightScaleM;
                    wrong +=
                        h < static_cast<double>(node.minHeightM) || h > static_cast<double>(node.maxHeightM)
                            ? 1
                            : 0;
                }
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("the pages are the quadtree over the grid, coarse to fine, each child listed once")
{
    const test::TempDir dir;
    compile(dir.file("a.ept"), 300, 140);
    const data::Dataset dataset = opened(dir.file("a.ept"));
    std::map<int, int> perDepth;
    std::vector<int> listed(dataset.pages().size());
    for (const lod::PageNode& node : dataset.pages()) {
        ++perDepth[node.depth];
        for (uint32_t q = 0; q < 4; ++q) {
            if (node.child[q] == lod::kNoPage)
                continue;
            const lod::PageNode& child = dataset.pages()[static_cast<size_t>(node.child[q])];
            ++listed[static_cast<size_t>(node.child[q])];
            CHECK(child.depth == node.depth + 1);
            CHECK(child.x == node.x * 2 + q % 2);
            CHECK(child.y == node.y * 2 + q / 2);
            CHECK(child.errorM <= node.errorM);
        }
    }
    // 299 x 139 intervals: 64 * 8 wide at depth 0; 256 per page at depth 1, 128, 64.
    CHECK(perDepth == std::map<int, int>{{0, 1}, {1, 2 * 1}, {2, 3 * 2}, {3, 5 * 3}});
    CHECK(listed[0] == 0);
    CHECK(std::all_of(listed.begin() + 1, listed.end(), [](int times) { return times == 1; }));
}

namespace {

// A page of each sort of ground, with codes as wild as the heights.
data::PageHeights wildPage(int kind, test::Dice& dice)
{
    data::PageHeights page;
    for (size_t i = 0; i < data::kPagePostCount; ++i) {
        page.post.push_back(
            static_cast<int16_t>(kind == 0   ? 0
                                 : kind == 1 ? static_cast<int>(dice.next())
                                 : kind == 2 ? (i % 2 == 0 ? -32768 : 32767)
                                 : kind == 3 ? static_cast<int>(i % 65) * 3 - static_cast<int>(i / 65) * 7
                                             : static_cast<int>(dice.next() % 5)));
        page.errorCode.push_back(static_cast<uint8_t>(kind == 3 ? 77 : dice.next()));
        page.radiusCode.push_back(static_cast<uint8_t>(kind == 3 ? 99 : dice.next()));
    }
    return page;
}

// What a page has before its payload is decoded: its parent's posts, the rest is anything.
data::PageHeights beforeDecoding(const data::PageHeights& page, const data::PageContent& content)
{
    data::PageHeights before = page;
    for (size_t i = 0; i < data::kPagePostCount; ++i)
        if (content.isRoot || i % 65 % 2 != 0 || i / 65 % 2 != 0) {
            before.post[i] = 12345;
            before.errorCode[i] = before.radiusCode[i] = 123;
        }
    return before;
}

} // namespace

TEST_CASE("any 16-bit heights and any codes survive the page codec, in bounded space")
{
    test::Dice dice(7);
    std::vector<uint8_t> payload;
    for (int kind = 0; kind < 5; ++kind)
        for (int which = 0; which < 8; ++which) {
            const data::PageContent content{(which & 1) != 0, (which & 2) != 0, (which & 4) != 0};
            data::PageHeights in = wildPage(kind, dice);
            in.hole.assign(content.hasHoles ? data::kPageCellCount : 0, false);
            for (size_t i = 0; i < in.hole.size(); ++i)
                in.hole[i] = dice.next() % 3 == 0;
            data::encodePage(in, content, payload);
            CHECK(payload.size() <= data::kMaxPayloadBytes);
            data::PageHeights out = beforeDecoding(in, content);
            REQUIRE(data::decodePage(payload, content, out));
            CHECK(in.post == out.post);
            CHECK(in.hole == out.hole);
            int wrong = 0;
            for (size_t i = 0; i < data::kPagePostCount; ++i)
                if (!content.isDeepest || (i % 65 % 2 == 0 && i / 65 % 2 == 0))
                    wrong += in.errorCode[i] != out.errorCode[i] || in.radiusCode[i] != out.radiusCode[i];
            CHECK(wrong == 0);
            for (int other = 0; other < 8; ++other)
                if (other != which)
                    CHECK_FALSE(data::decodePage(
                        payload, {(other & 1) != 0, (other & 2) != 0, (other & 4) != 0}, out));
        }
}

TEST_CASE("no payload, however it is broken, crashes the page codec")
{
    test::Dice dice(3);
    for (int which = 0; which < 8; ++which) {
        const data::PageContent content{(which & 1) != 0, (which & 2) != 0, (which & 4) != 0};
        data::PageHeights heights = wildPage(3, dice);
        heights.hole.assign(content.hasHoles ? data::kPageCellCount : 0, true);
        std::vector<uint8_t> payload;
        data::encodePage(heights, content, payload);
        for (size_t length = 0; length < payload.size(); ++length) {
            const std::vector<uint8_t> cut(payload.begin(),
                                           payload.begin() + static_cast<std::ptrdiff_t>(length));
            CHECK_FALSE(data::decodePage(cut, content, heights));
        }
        for (int i = 0; i < 1000; ++i) {
            std::vector<uint8_t> broken = payload;
            broken[dice.next() % broken.size()] = static_cast<uint8_t>(dice.next());
            (void)data::decodePage(broken, content, heights);
        }
    }
}

TEST_CASE("the header comes back as compiled")
{
    const test::TempDir dir;
    terrain::GridPlace place = test::somePlace(0.5);
    place.ellipsoid = {1737400.0, 0.0};
    place.heightOffsetM = -100;
    place.verticalDatum = "mean lunar radius";
    place.source = "a.tif, b.tif";
    REQUIRE(terrain::compileHeights(
        70, 9, place, [](uint32_t c, uint32_t) { return c * 2.0 - 50; }, dir.file("a.ept")));
    const data::Dataset dataset = opened(dir.file("a.ept"));
    const data::DatasetInfo& info = dataset.info();
    CHECK(info.shape.ellipsoid == place.ellipsoid);
    CHECK(info.shape.northRad == Approx(57.5 * kRadPerDeg).epsilon(1e-15));
    CHECK(info.shape.westRad == Approx(-5.0 * kRadPerDeg).epsilon(1e-15));
    CHECK(info.shape.latitudeStepRad == Approx(0.00045 * kRadPerDeg).epsilon(1e-15));
    CHECK(info.shape.longitudeStepRad == Approx(0.0008 * kRadPerDeg).epsilon(1e-15));
    CHECK(info.heightScaleM == 0.5);
    CHECK(info.heightOffsetM == -100);
    CHECK(info.minHeightM == -50);
    CHECK(info.maxHeightM == 88);
    CHECK(info.verticalDatum == "mean lunar radius");
    CHECK(info.source == "a.tif, b.tif");
    CHECK_FALSE(info.hasHoles);
    CHECK(info.fileBytes == std::filesystem::file_size(dir.file("a.ept")));
}

TEST_CASE("a file cut short at any byte, or longer, is refused")
{
    const test::TempDir dir;
    compile(dir.file("a.ept"), 70, 5, 1.0);
    const std::vector<uint8_t> bytes = test::bytesOf(dir.file("a.ept"));
    const std::string path = dir.file("cut.ept");
    int unnoticed = 0;
    for (size_t length = 0; length < bytes.size(); ++length) {
        test::writeBytes(path, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)});
        const Result<data::Dataset> dataset = data::Dataset::open(path);
        unnoticed += dataset || dataset.error().kind != ErrorKind::dataset ? 1 : 0;
    }
    CHECK(unnoticed == 0);
    std::vector<uint8_t> longer = bytes;
    longer.push_back(0);
    test::writeBytes(path, longer);
    CHECK_FALSE(data::Dataset::open(path));
}

TEST_CASE("every flipped byte is noticed, when opening or when reading its page")
{
    const test::TempDir dir;
    compile(dir.file("a.ept"), 70, 5, 1.0);
    const std::vector<uint8_t> bytes = test::bytesOf(dir.file("a.ept"));
    const std::string path = dir.file("flipped.ept");
    test::writeBytes(path, bytes);
    REQUIRE_FALSE(isNoticed(path));
    int unnoticed = 0;
    for (size_t at = 0; at < bytes.size(); ++at)
        for (const uint8_t mask : {uint8_t{1}, uint8_t{0x80}, uint8_t{0xff}}) {
            std::vector<uint8_t> flipped = bytes;
            flipped[at] ^= mask;
            test::writeBytes(path, flipped);
            unnoticed += isNoticed(path) ? 0 : 1;
        }
    CHECK(unnoticed == 0);
}

TEST_CASE("what is no dataset is refused with words that say so")
{
    const test::TempDir dir;
    const auto message = [](const std::string& path) {
        const Result<data::Dataset> dataset = data::Dataset::open(path);
        REQUIRE_FALSE(dataset);
        CHECK(dataset.error().kind == ErrorKind::dataset);
        CHECK(dataset.error().message.find('\n') == std::string::npos);
        return dataset.error().message;
    };
    CHECK_THAT(message(dir.file("missing.ept")),
               Catch::EndsWith(": No such file or directory; check the path"));
    CHECK_THAT(message(dir.path().string()), Catch::Contains("not a file"));
    test::writeBytes(dir.file("text.ept"), {'h', 'e', 'l', 'l', 'o'});
    CHECK_THAT(message(dir.file("text.ept")), Catch::Contains("not an .ept terrain dataset"));
    compile(dir.file("a.ept"), 5, 5);
    std::vector<uint8_t> bytes = test::bytesOf(dir.file("a.ept"));
    for (const uint8_t version : {uint8_t{data::kEptVersion - 1}, uint8_t{data::kEptVersion + 1}}) {
        bytes[8] = version;
        test::writeBytes(dir.file("other.ept"), bytes);
        CHECK_THAT(message(dir.file("other.ept")),
                   Catch::Contains("format version " + std::to_string(version)) &&
                       Catch::Contains("reads version " + std::to_string(data::kEptVersion)) &&
                       Catch::Contains("compile it again"));
    }
}

TEST_CASE("values that no compiler writes are refused though the checksums are right")
{
    const test::TempDir dir;
    compile(dir.file("a.ept"), 140, 90);
    const std::vector<uint8_t> bytes = test::bytesOf(dir.file("a.ept"));
    const Result<data::EptHeader> header = data::decodeHeader(bytes, bytes.size(), "a");
    REQUIRE(header);
    const std::string path = dir.file("hostile.ept");

    using Change = void (*)(data::EptHeader&);
    const std::vector<Change> changes{[](data::EptHeader& h) { h.info.shape.cols = 0xffffffffU; },
                                      [](data::EptHeader& h) { h.info.shape.cols = 1; },
                                      [](data::EptHeader& h) { h.info.shape.rows = 0; },
                                      [](data::EptHeader& h) { h.info.shape.deepestPage = 24; },
                                      [](data::EptHeader& h) { h.info.shape.northRad = kNan; },
                                      [](data::EptHeader& h) { h.info.shape.northRad = 2; },
                                      [](data::EptHeader& h) { h.info.shape.westRad = kInfinity; },
                                      [](data::EptHeader& h) { h.info.shape.latitudeStepRad = 0; },
                                      [](data::EptHeader& h) { h.info.shape.latitudeStepRad = 1; },
                                      [](data::EptHeader& h) { h.info.shape.longitudeStepRad = -1e-5; },
                                      [](data::EptHeader& h) { h.info.shape.ellipsoid.semiMajorM = 0; },
                                      [](data::EptHeader& h) { h.info.shape.ellipsoid.flattening = kNan; },
                                      [](data::EptHeader& h) { h.info.heightScaleM = 0; },
                                      [](data::EptHeader& h) { h.info.heightOffsetM = kNan; },
                                      [](data::EptHeader& h) { h.info.minHeightM = h.info.maxHeightM + 1; },
                                      [](data::EptHeader& h) { h.info.fileBytes = ~uint64_t{0}; },
                                      [](data::EptHeader& h) { h.indexOffset = ~uint64_t{0} - 10; },
                                      [](data::EptHeader& h) { h.indexOffset = 0; },
                                      [](data::EptHeader& h) { h.pageCount = 0; },
                                      [](data::EptHeader& h) { h.pageCount = 0xffffffffU; }};
    for (size_t i = 0; i < changes.size(); ++i) {
        INFO("change " << i);
        data::EptHeader hostile = *header;
        changes[i](hostile);
        const std::vector<uint8_t> encoded = data::encodeHeader(hostile);
        std::vector<uint8_t> file = bytes;
        std::copy(encoded.begin(), encoded.end(), file.begin());
        test::writeBytes(path, file);
        CHECK_FALSE(data::Dataset::open(path));
    }
}

TEST_CASE("an index that does not fit its pages is refused though the checksums are right")
{
    const test::TempDir dir;
    compile(dir.file("a.ept"), 140, 90);
    const std::vector<uint8_t> bytes = test::bytesOf(dir.file("a.ept"));
    const Result<data::EptHeader> header = data::decodeHeader(bytes, bytes.size(), "a");
    REQUIRE(header);
    const std::string path = dir.file("hostile.ept");
    struct Put {
        size_t record, at;
        std::vector<uint8_t> bytes;
    };
    const std::vector<uint8_t> nan{0, 0, 0xc0, 0x7f};
    const std::vector<uint8_t> huge{0xff, 0xff, 0xff, 0x7e};
    // Offset, size, key, children, flags, errors, heights: see FORMAT.md.
    const std::vector<Put> puts{{1, 0, {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff}},
                                {1, 16, {0xff, 0xff}},
                                {1, 16, {0, 0, 0, 0}},
                                {1, 20, {7}},
                                {2, 24, {7}},
                                {1, 28, {9}},
                                {0, 29, {0}},
                                {1, 30, {1}},
                                {1, 31, {1}},
                                {0, 32, nan},
                                {1, 32, huge},
                                {4, 36, nan},
                                {4, 40, huge},
                                {4, 56, {0xff, 0x7f, 0, 0x80}}};
    for (const Put& put : puts) {
        INFO("record " << put.record << " at " << put.at);
        std::vector<uint8_t> file = bytes;
        const auto index = file.begin() + static_cast<std::ptrdiff_t>(header->indexOffset);
        std::copy(put.bytes.begin(), put.bytes.end(),
                  index + static_cast<std::ptrdiff_t>(put.record * data::kIndexRecordBytes + put.at));
        data::EptHeader hostile = *header;
        hostile.info.checksum =
            data::checksum(std::span(file).subspan(static_cast<size_t>(header->indexOffset)));
        const std::vector<uint8_t> encoded = data::encodeHeader(hostile);
        std::copy(encoded.begin(), encoded.end(), file.begin());
        test::writeBytes(path, file);
        CHECK_FALSE(data::Dataset::open(path));
    }
}

TEST_CASE("a file that is cut while open gives errors, not signals")
{
    const test::TempDir dir;
    compile(dir.file("a.ept"), 200, 200);
    const data::Dataset dataset = opened(dir.file("a.ept"));
    const auto last = static_cast<uint32_t>(dataset.pages().size() - 1);
    data::PageReader reader(dataset);
    const auto parent = reader.read(static_cast<uint32_t>(dataset.parentOf(last)));
    REQUIRE(parent);
    std::filesystem::resize_file(dir.file("a.ept"), 300);
    data::PageHeights heights;
    const Result<void> read = dataset.readPage(last, *parent, heights);
    REQUIRE_FALSE(read);
    CHECK_THAT(read.error().message, Catch::Contains("page depth 2 x 3 y 3") && Catch::Contains("cut short"));
}

TEST_CASE("threads read pages at the same time, and reading again allocates nothing")
{
    const test::TempDir dir;
    compile(dir.file("a.ept"), 400, 400);
    const data::Dataset dataset = opened(dir.file("a.ept"));
    std::vector<int16_t> sums(4);
    std::vector<std::thread> threads;
    for (size_t t = 0; t < sums.size(); ++t)
        threads.emplace_back([&, t] {
            data::PageReader reader(dataset);
            for (uint32_t page = 0; page < dataset.pages().size(); ++page)
                if (const auto heights = reader.read(page))
                    for (size_t i = 0; i < data::kPagePostCount; ++i)
                        sums[t] = static_cast<int16_t>(sums[t] * 31 + (*heights)->post[i] +
                                                       (*heights)->errorCode[i] + (*heights)->radiusCode[i]);
        });
    for (std::thread& thread : threads)
        thread.join();
    CHECK(sums[0] != 0);
    CHECK(std::count(sums.begin(), sums.end(), sums[0]) == 4);

    std::vector<data::PageHeights> heights(dataset.pages().size());
    data::PageMesh mesh;
    bool fine = true;
    const auto readAll = [&] {
        for (uint32_t page = 0; page < dataset.pages().size(); ++page) {
            const data::PageHeights* parent =
                page == 0 ? nullptr : &heights[static_cast<size_t>(dataset.parentOf(page))];
            fine = fine && static_cast<bool>(dataset.readPage(page, parent, heights[page]));
            data::buildPageMesh(dataset.info(), dataset.pages()[page], heights[page], {}, mesh);
        }
    };
    readAll();
    const size_t before = test::allocations();
    readAll();
    const size_t after = test::allocations();
    CHECK(fine);
    CHECK(after == before);
}

TEST_CASE("vertices are the posts in ECEF, the same bits on both sides of a border and at every depth")
{
    const test::TempDir dir;
    compile(dir.file("a.ept"), 150, 140);
    const data::Dataset dataset = opened(dir.file("a.ept"));
    const data::DatasetInfo& info = dataset.info();
    data::PageReader reader(dataset);
    data::PageMesh mesh;
    std::map<std::pair<uint32_t, uint32_t>, glm::dvec3> seen;
    int different = 0;
    double farthest = 0;
    for (uint32_t page = 0; page < dataset.pages().size(); ++page) {
        const lod::PageNode& node = dataset.pages()[page];
        const auto read = reader.read(page);
        REQUIRE(read);
        const data::PageHeights& heights = **read;
        data::buildPageMesh(info, node, heights, {}, mesh);
        REQUIRE(mesh.vertex.size() == data::kPagePostCount);
        for (int j = 0; j < 65; ++j)
            for (int i = 0; i < 65; ++i) {
                const auto at = static_cast<size_t>(j * 65 + i);
                const uint32_t c = data::postColumn(info.shape, node.depth, node.x, i);
                const uint32_t r = data::postRow(info.shape, node.depth, node.y, j);
                const auto [known, isNew] = seen.emplace(std::pair(c, r), mesh.vertex[at].m);
                different += known->second == mesh.vertex[at].m ? 0 : 1;
                const Geodetic place{info.shape.northRad - r * info.shape.latitudeStepRad,
                                     info.shape.westRad + c * info.shape.longitudeStepRad,
                                     heights.post[at] * info.heightScaleM};
                const glm::dvec3 off = toEcef(place, info.shape.ellipsoid).m - mesh.vertex[at].m;
                farthest = std::max({farthest, std::abs(off.x), std::abs(off.y), std::abs(off.z)});
            }
    }
    CHECK(different == 0);
    CHECK(farthest < 1e-8);
}

namespace {

int red(uint32_t texel)
{
    return static_cast<int>(texel & 0xff);
}
int green(uint32_t texel)
{
    return static_cast<int>(texel >> 8 & 0xff);
}
int blue(uint32_t texel)
{
    return static_cast<int>(texel >> 16 & 0xff);
}
int brightness(uint32_t texel)
{
    return red(texel) + green(texel) + blue(texel);
}

// The texel in the middle of a page over a plane that rises by these metres per post.
uint32_t litPlane(double eastwards, double southwards, double azimuthDeg, double elevationDeg)
{
    const test::TempDir dir;
    REQUIRE(terrain::compileHeights(
        65, 65, test::somePlace(),
        [&](uint32_t c, uint32_t r) { return 500 + eastwards * (c - 32.0) + southwards * (r - 32.0); },
        dir.file("p.ept")));
    const data::Dataset dataset = opened(dir.file("p.ept"));
    data::PageHeights heights;
    REQUIRE(dataset.readPage(0, nullptr, heights));
    data::ShadingSettings shading;
    shading.sunAzimuthRad = azimuthDeg * kRadPerDeg;
    shading.sunElevationRad = elevationDeg * kRadPerDeg;
    data::PageMesh mesh;
    data::buildPageMesh(dataset.info(), dataset.pages()[0], heights, shading, mesh);
    return mesh.texel[32 * 64 + 32];
}

} // namespace

TEST_CASE("slopes towards the sun are brighter than level ground, slopes away from it darker")
{
    // Posts are about 48 m (east) and 50 m (north) apart: 15 m a post is a slope of about 17 degrees.
    const int level = brightness(litPlane(0, 0, 90, 40));
    CHECK(brightness(litPlane(-15, 0, 90, 40)) > level + 15); // falls to the east, sun in the east
    CHECK(brightness(litPlane(15, 0, 90, 40)) < level - 15);
    CHECK(brightness(litPlane(0, 15, 0, 40)) > level + 15); // rises to the south, sun in the north
    CHECK(brightness(litPlane(0, -15, 0, 40)) < level - 15);
    CHECK(brightness(litPlane(0, 15, 180, 40)) < level - 15);
    CHECK(brightness(litPlane(15, 0, 90, -10)) ==
          brightness(litPlane(-15, 0, 90, -10))); // night: no direction
}

TEST_CASE("sea is blue, lowland green, summits white, a hole transparent")
{
    const test::TempDir dir;
    REQUIRE(terrain::compileHeights(
        65, 65, test::somePlace(),
        [](uint32_t c, uint32_t r) {
            return c == 60 && r == 60 ? kNan : c < 16 ? 0.0 : c < 32 ? 120.0 : 3100.0;
        },
        dir.file("a.ept")));
    const data::Dataset dataset = opened(dir.file("a.ept"));
    CHECK(dataset.info().hasHoles);
    data::PageHeights heights;
    REQUIRE(dataset.readPage(0, nullptr, heights));
    data::ShadingSettings shading;
    shading.sunElevationRad = 0.8;
    data::PageMesh mesh;
    data::buildPageMesh(dataset.info(), dataset.pages()[0], heights, shading, mesh);
    const auto at = [&](size_t col, size_t row) { return mesh.texel[row * 64 + col]; };
    CHECK(blue(at(5, 5)) > red(at(5, 5)) + 60);
    CHECK(green(at(24, 5)) > std::max(red(at(24, 5)), blue(at(24, 5))) + 20);
    CHECK(brightness(at(40, 5)) > brightness(at(24, 5)) + 150);
    CHECK(std::abs(red(at(40, 5)) - blue(at(40, 5))) < 40);
    for (size_t row = 0; row < 64; ++row)
        for (size_t col = 0; col < 64; ++col) {
            const bool isHole = (col == 59 || col == 60) && (row == 59 || row == 60);
            REQUIRE(at(col, row) >> 24 == (isHole ? 0U : 255U));
        }
}

TEST_CASE("another body's colours follow its own range of heights, without sea")
{
    const test::TempDir dir;
    terrain::GridPlace place = test::somePlace(1.0);
    place.ellipsoid = {1737400.0, 0.0};
    REQUIRE(terrain::compileHeights(
        65, 65, place, [](uint32_t c, uint32_t) { return c < 32 ? -3000.0 : -1000.0; }, dir.file("a.ept")));
    const data::Dataset dataset = opened(dir.file("a.ept"));
    data::PageHeights heights;
    REQUIRE(dataset.readPage(0, nullptr, heights));
    data::ShadingSettings shading;
    shading.sunElevationRad = 0.8;
    data::PageMesh mesh;
    data::buildPageMesh(dataset.info(), dataset.pages()[0], heights, shading, mesh);
    CHECK(brightness(mesh.texel[5]) + 150 < brightness(mesh.texel[50]));
    CHECK(std::abs(red(mesh.texel[5]) - blue(mesh.texel[5])) < 40);
}

TEST_CASE("where all texels would be alike, one colour stands for them, and nowhere else")
{
    const test::TempDir dir;
    data::ShadingSettings day;
    day.sunElevationRad = 0.6;
    data::ShadingSettings dark;
    dark.sunElevationRad = -0.1;
    dark.ambient = 0;
    int files = 0;
    const auto compiled = [&](const std::function<double(uint32_t, uint32_t)>& heightM) {
        const std::string path = dir.file(std::to_string(files++) + ".ept");
        REQUIRE(terrain::compileHeights(100, 80, test::somePlace(), heightM, path));
        return opened(path);
    };
    const auto hills = [](uint32_t c, uint32_t r) { return 10.0 * (c % 7) + r; };
    const auto isUniform = [](const data::Dataset& dataset, const data::ShadingSettings& shading) {
        const auto colour = data::uniformTexel(dataset.info(), shading);
        std::vector<data::PageHeights> heights(dataset.pages().size());
        for (uint32_t page = 0; colour && page < dataset.pages().size(); ++page) {
            const int32_t parent = dataset.parentOf(page);
            REQUIRE(dataset.readPage(page, parent >= 0 ? &heights[static_cast<size_t>(parent)] : nullptr,
                                     heights[page]));
            data::PageMesh mesh;
            data::buildPageMesh(dataset.info(), dataset.pages()[page], heights[page], shading, mesh);
            CHECK(std::all_of(mesh.texel.begin(), mesh.texel.end(),
                              [&](uint32_t texel) { return texel == *colour; }));
            data::PageMesh bare;
            data::buildPageVertices(dataset.info(), dataset.pages()[page], heights[page], bare);
            CHECK(bare.texel.empty());
            CHECK(bare.vertex.size() == mesh.vertex.size());
            CHECK(bare.vertex.back().m == mesh.vertex.back().m);
        }
        return colour.has_value();
    };
    for (const double levelM : {0.0, -3.2, 1'234.5}) {
        CHECK(isUniform(compiled([levelM](uint32_t, uint32_t) { return levelM; }), day));
    }
    CHECK(isUniform(compiled(hills), dark));
    CHECK_FALSE(isUniform(compiled(hills), day));
    const data::Dataset holed =
        compiled([](uint32_t c, uint32_t r) { return c > 40 && c < 60 && r > 40 ? std::nan("") : 0.0; });
    CHECK(holed.info().hasHoles);
    CHECK_FALSE(isUniform(holed, day));
    CHECK_FALSE(isUniform(holed, dark));
}
