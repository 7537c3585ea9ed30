// SPDX-License-Identifier: MIT
#include "ig/data/dataset.h"

#include "ig/base/system_error.h"
#include "ig/data/ept_format.h"
#include "ig/data/hierarchy.h"
#include "ig/data/page_codec.h"
#include "ig/data/vertex_codes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace ig::data {

namespace {

class File {
public:
    explicit File(int descriptor) : _descriptor(descriptor) {}
    ~File()
    {
        if (_descriptor >= 0)
            ::close(_descriptor);
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    int descriptor() const noexcept { return _descriptor; }

    // Reads until out is full or the file ends. Not a mapping: a file cut short under a running program
    // is then a short read, not a SIGBUS. Returns the bytes read, or -1 with errno.
    ssize_t read(uint64_t offset, std::span<uint8_t> out) const
    {
        size_t done = 0;
        while (done < out.size()) {
            const ssize_t n =
                ::pread(_descriptor, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
            if (n < 0 && errno == EINTR)
                continue;
            if (n < 0)
                return -1;
            if (n == 0)
                break;
            done += static_cast<size_t>(n);
        }
        return static_cast<ssize_t>(done);
    }

private:
    int _descriptor;
};

float roundedDown(double value)
{
    const auto narrow = static_cast<float>(value);
    return static_cast<double>(narrow) > value
               ? std::nextafter(narrow, -std::numeric_limits<float>::infinity())
               : narrow;
}

// What is kept of a PagePlace, in half its size.
struct Payload {
    uint64_t checksum;
    uint64_t offset : 47; // of 2^32 pages of the largest size, too
    uint64_t bytes : 16;
    uint64_t hasHoles : 1;
};
static_assert(sizeof(Payload) == 16 && kMaxPayloadBytes < 1 << 15);
constexpr uint64_t kOffsetMask = (uint64_t{1} << 47) - 1;

std::string pageName(const lod::PageNode& node)
{
    return "page depth " + std::to_string(node.depth) + " x " + std::to_string(node.x) + " y " +
           std::to_string(node.y);
}

} // namespace

void PageHeights::reserve()
{
    post.reserve(kPagePostCount);
    errorCode.reserve(kPagePostCount);
    radiusCode.reserve(kPagePostCount);
    hole.reserve(kPageCellCount);
}

struct Dataset::Impl {
    Impl(std::string name, int descriptor) : path(std::move(name)), file(descriptor) {}
    Result<void> readIndex(const EptHeader& header);
    PageContent contentOf(uint32_t page) const;
    Unexpected<Error> bad(uint32_t page, const std::string& what) const;
    Result<std::span<const uint8_t>> readPayload(uint32_t page) const;

    std::string path;
    File file;
    DatasetInfo info;
    std::vector<lod::PageNode> pages;
    std::vector<Payload> payloads;
    std::vector<int32_t> parents;
    mutable std::atomic<uint64_t> bytesRead{0};
};

Result<void> Dataset::Impl::readIndex(const EptHeader& header)
{
    const auto damaged = [&](const std::string& what) {
        return fail(ErrorKind::dataset, path + ": damaged index (" + what + "); compile it again");
    };
    std::vector<uint8_t> index(size_t{header.pageCount} * kIndexRecordBytes);
    const ssize_t got = file.read(header.indexOffset, index);
    if (got != static_cast<ssize_t>(index.size()))
        return fail(ErrorKind::dataset,
                    path + ": cannot read the index: " +
                        (got < 0 ? systemError(errno) : "the file is cut short; compile it again"));
    if (checksum(index) != info.checksum)
        return damaged("checksum");

    pages = buildHierarchy(info.shape);
    payloads.resize(pages.size());
    uint64_t next = header.headerBytes;
    for (size_t i = 0; i < pages.size(); ++i) {
        const auto record = std::span(index).subspan(i * kIndexRecordBytes, kIndexRecordBytes);
        PagePlace place;
        if (!decodeRecord(record, pages[i], place) || place.offset != next ||
            (place.hasHoles && !info.hasHoles))
            return damaged("record " + std::to_string(i));
        next += place.bytes;
        payloads[i].checksum = place.checksum;
        payloads[i].offset = place.offset & kOffsetMask;
        payloads[i].bytes = place.bytes & 0xffff;
        payloads[i].hasHoles = place.hasHoles ? 1 : 0;
        pages[i].minHeightM = roundedDown(place.minPost * info.heightScaleM + info.heightOffsetM);
        pages[i].maxHeightM = -roundedDown(-(place.maxPost * info.heightScaleM + info.heightOffsetM));
    }
    if (next != header.indexOffset)
        return damaged("payloads do not fill the file");
    parents.assign(pages.size(), lod::kNoPage);
    for (size_t i = 0; i < pages.size(); ++i)
        for (const int32_t number : pages[i].child) {
            if (number == lod::kNoPage)
                continue;
            const auto child = static_cast<size_t>(number);
            parents[child] = static_cast<int32_t>(i);
            if (pages[child].errorM > pages[i].errorM)
                return damaged("errors do not fall with depth");
        }
    return {};
}

Result<Dataset> Dataset::open(const std::string& path)
{
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
        return fail(ErrorKind::dataset, path + ": cannot open: " + systemError(errno));
    auto impl = std::make_unique<Impl>(path, descriptor);
    struct stat status {};
    if (::fstat(descriptor, &status) != 0)
        return fail(ErrorKind::dataset, path + ": cannot read: " + systemError(errno));
    if (!S_ISREG(status.st_mode))
        return fail(ErrorKind::dataset, path + ": not a file; give an .ept terrain dataset");

    const auto fileBytes = static_cast<uint64_t>(status.st_size);
    std::vector<uint8_t> head(std::min<uint64_t>(fileBytes, kMaxHeaderBytes));
    const ssize_t got = impl->file.read(0, head);
    if (got < 0)
        return fail(ErrorKind::dataset, path + ": cannot read: " + systemError(errno));
    Result<EptHeader> header = decodeHeader(std::span(head).first(static_cast<size_t>(got)), fileBytes, path);
    if (!header)
        return Unexpected{header.error()};
    impl->info = header->info;
    if (Result<void> index = impl->readIndex(*header); !index)
        return Unexpected{index.error()};
    return Dataset(std::move(impl));
}

Dataset::Dataset(std::shared_ptr<const Impl> impl) : _impl(std::move(impl)) {}

const DatasetInfo& Dataset::info() const noexcept
{
    return _impl->info;
}
std::span<const lod::PageNode> Dataset::pages() const noexcept
{
    return _impl->pages;
}

int32_t Dataset::parentOf(uint32_t page) const noexcept
{
    return _impl->parents[page];
}

uint64_t Dataset::bytesRead() const noexcept
{
    return _impl->bytesRead.load(std::memory_order_relaxed);
}

namespace {

constexpr int kSide = lod::kPagePosts;
constexpr int kLast = lod::kPageIntervals;
constexpr int kHalf = kLast / 2;

size_t at(int column, int row)
{
    return static_cast<size_t>(row * kSide + column);
}

// Ends of the edge that a post of a page splits, of which one coordinate at least is half way, the others 0
// or 64: it lies in the middle of the page or of a side.
std::array<size_t, 2> endsOfMiddle(const lod::PageNode& page, int column, int row)
{
    if (row != kHalf)
        return {at(0, row), at(kLast, row)};
    if (column != kHalf)
        return {at(column, 0), at(column, kLast)};
    // A diagonal, from the corner whose coordinates on the grid are odd multiples of a page's width.
    const int oddColumn = page.x % 2 != 0 ? 0 : kLast;
    const int oddRow = page.y % 2 != 0 ? 0 : kLast;
    return {at(oddColumn, oddRow), at(kLast - oddColumn, kLast - oddRow)};
}

// What a page has from its parent.
void inherit(const lod::PageNode& page, const lod::PageNode& parentPage, const PageHeights& parent,
             PageHeights& out)
{
    const int firstColumn = kHalf * static_cast<int>(page.x % 2);
    const int firstRow = kHalf * static_cast<int>(page.y % 2);
    for (int row = 0; row <= kHalf; ++row)
        for (int column = 0; column <= kHalf; ++column) {
            const size_t from = at(firstColumn + column, firstRow + row);
            const size_t to = at(2 * column, 2 * row);
            out.post[to] = parent.post[from];
            out.errorCode[to] = parent.errorCode[from];
            out.radiusCode[to] = parent.radiusCode[from];
        }
    for (int corner = 0; corner < 4; ++corner) {
        const int column = firstColumn + kHalf * (corner % 2);
        const int row = firstRow + kHalf * (corner / 2);
        auto& ends = out.cornerEnds[static_cast<size_t>(corner)];
        if (column % kLast == 0 && row % kLast == 0) {
            ends = parent.cornerEnds[static_cast<size_t>(row / kLast * 2 + column / kLast)];
            continue;
        }
        const std::array<size_t, 2> posts = endsOfMiddle(parentPage, column, row);
        ends = {parent.post[posts[0]], parent.post[posts[1]]};
    }
}

// Codes of the vertices that the file leaves out.
void computeFinest(const DatasetInfo& info, const lod::PageNode& page, PageHeights& out)
{
    struct FinestScratch {
        PagePlaces places;
        std::vector<double> ownErrorM = std::vector<double>(kPagePostCount);
    };
    thread_local FinestScratch scratch;
    const PageFrame frame(info.shape, page);
    size_t post = 0;
    for (size_t row = 0; row < kSide; ++row)
        for (size_t column = 0; column < kSide; ++column, ++post)
            scratch.places.set(post, placeOf(frame.row[row], frame.column[column],
                                             out.post[post] * info.heightScaleM + info.heightOffsetM));
    const auto lastPost = [](uint32_t posts, uint32_t pageAlong) {
        return std::min<int64_t>(int64_t{posts} - 1 - int64_t{pageAlong} * kLast, kLast);
    };
    measureFinest(scratch.places, lastPost(info.shape.cols, page.x), lastPost(info.shape.rows, page.y),
                  scratch.ownErrorM, out.errorCode, out.radiusCode);
}

} // namespace

PageContent Dataset::Impl::contentOf(uint32_t page) const
{
    return {page == 0, pages[page].depth == info.shape.deepestPage, payloads[page].hasHoles != 0};
}

Unexpected<Error> Dataset::Impl::bad(uint32_t page, const std::string& what) const
{
    return fail(ErrorKind::dataset, path + ": " + pageName(pages[page]) + ": " + what);
}

// The bytes lie in a buffer of the thread, until its next call.
Result<std::span<const uint8_t>> Dataset::Impl::readPayload(uint32_t page) const
{
    const Payload& place = payloads[page];
    thread_local std::vector<uint8_t> buffer(kMaxPayloadBytes);
    const auto payload = std::span(buffer).first(place.bytes);
    const ssize_t got = file.read(place.offset, payload);
    bytesRead.fetch_add(static_cast<uint64_t>(std::max<ssize_t>(got, 0)), std::memory_order_relaxed);
    if (got < 0)
        return bad(page, std::string("cannot read: ") + systemError(errno));
    if (got != static_cast<ssize_t>(payload.size()))
        return bad(page, "the file is cut short");
    if (checksum(payload) != place.checksum)
        return bad(page, "damaged (checksum)");
    return std::span<const uint8_t>(payload);
}

Result<void> Dataset::checkPage(uint32_t page) const
{
    const auto payload = _impl->readPayload(page);
    if (!payload)
        return Unexpected{payload.error()};
    if (!isPage(*payload, _impl->contentOf(page)))
        return _impl->bad(page, "damaged (content)");
    return {};
}

Result<void> Dataset::readPage(uint32_t page, const PageHeights* parent, PageHeights& out) const
{
    assert(page < _impl->pages.size());
    assert((parent == nullptr) == (page == 0));
    const lod::PageNode& node = _impl->pages[page];
    const auto payload = _impl->readPayload(page);
    if (!payload)
        return Unexpected{payload.error()};
    out.post.resize(kPagePostCount);
    out.errorCode.resize(kPagePostCount);
    out.radiusCode.resize(kPagePostCount);
    if (parent != nullptr)
        inherit(node, _impl->pages[static_cast<size_t>(_impl->parents[page])], *parent, out);
    else
        out.cornerEnds = {};
    const PageContent content = _impl->contentOf(page);
    if (!decodePage(*payload, content, out))
        return _impl->bad(page, "damaged (content)");
    if (content.isDeepest)
        computeFinest(_impl->info, node, out);
    return {};
}

PageReader::PageReader(const Dataset& dataset)
    : _dataset(dataset), _heights(static_cast<size_t>(dataset.info().shape.deepestPage) + 1),
      _page(_heights.size(), lod::kNoPage)
{
}

Result<const PageHeights*> PageReader::read(uint32_t page)
{
    std::array<uint32_t, lod::kMaxPageDepth + 1> chain; // by depth
    const size_t depth = _dataset.pages()[page].depth;
    for (auto ancestor = static_cast<int32_t>(page); ancestor != lod::kNoPage;
         ancestor = _dataset.parentOf(static_cast<uint32_t>(ancestor)))
        chain[_dataset.pages()[static_cast<size_t>(ancestor)].depth] = static_cast<uint32_t>(ancestor);
    for (size_t d = 0; d <= depth; ++d) {
        if (_page[d] == static_cast<int32_t>(chain[d]))
            continue;
        _page[d] = lod::kNoPage;
        if (Result<void> read = _dataset.readPage(chain[d], d > 0 ? &_heights[d - 1] : nullptr, _heights[d]);
            !read)
            return Unexpected{read.error()};
        _page[d] = static_cast<int32_t>(chain[d]);
    }
    return &_heights[depth];
}

} // namespace ig::data
