// SPDX-License-Identifier: MIT
#include "ig/data/dataset.h"

#include "ig/data/ept_format.h"
#include "ig/data/hierarchy.h"
#include "ig/data/page_codec.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
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

std::string pageName(const lod::PageNode& node)
{
    return "page depth " + std::to_string(node.depth) + " x " + std::to_string(node.x) + " y " +
           std::to_string(node.y);
}

} // namespace

struct Dataset::Impl {
    Impl(std::string name, int descriptor) : path(std::move(name)), file(descriptor) {}
    Result<void> readIndex(const EptHeader& header);

    std::string path;
    File file;
    DatasetInfo info;
    std::vector<lod::PageNode> pages;
    std::vector<PagePlace> places;
};

Result<void> Dataset::Impl::readIndex(const EptHeader& header)
{
    const auto damaged = [&](const std::string& what) {
        return fail(ErrorKind::dataset, path + ": damaged index (" + what + "); compile it again");
    };
    std::vector<uint8_t> index(size_t{header.pageCount} * kIndexRecordBytes);
    const ssize_t got = file.read(header.indexOffset, index);
    if (got != static_cast<ssize_t>(index.size()))
        return fail(ErrorKind::dataset, path + ": cannot read the index: " +
                                            (got < 0 ? std::strerror(errno) : "the file is cut short"));
    if (checksum(index) != info.checksum)
        return damaged("checksum");

    pages = buildHierarchy(info.shape);
    places.resize(pages.size());
    uint64_t next = header.headerBytes;
    for (size_t i = 0; i < pages.size(); ++i) {
        const auto record = std::span(index).subspan(i * kIndexRecordBytes, kIndexRecordBytes);
        if (!decodeRecord(record, pages[i], places[i]) || places[i].offset != next ||
            (places[i].hasHoles && !info.hasHoles))
            return damaged("record " + std::to_string(i));
        next += places[i].bytes;
        pages[i].minHeightM = roundedDown(places[i].minPost * info.heightScaleM + info.heightOffsetM);
        pages[i].maxHeightM = -roundedDown(-(places[i].maxPost * info.heightScaleM + info.heightOffsetM));
    }
    if (next != header.indexOffset)
        return damaged("payloads do not fill the file");
    for (const lod::PageNode& node : pages)
        for (const int32_t child : node.child)
            if (child != lod::kNoPage && pages[static_cast<size_t>(child)].errorM > node.errorM)
                return damaged("errors do not fall with depth");
    return {};
}

Result<Dataset> Dataset::open(const std::string& path)
{
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
        return fail(ErrorKind::dataset, path + ": cannot open: " + std::strerror(errno));
    auto impl = std::make_unique<Impl>(path, descriptor);
    struct stat status {};
    if (::fstat(descriptor, &status) != 0)
        return fail(ErrorKind::dataset, path + ": cannot read: " + std::strerror(errno));
    if (!S_ISREG(status.st_mode))
        return fail(ErrorKind::dataset, path + ": not a file; give an .ept terrain dataset");

    const auto fileBytes = static_cast<uint64_t>(status.st_size);
    std::vector<uint8_t> head(std::min<uint64_t>(fileBytes, kMaxHeaderBytes));
    const ssize_t got = impl->file.read(0, head);
    if (got < 0)
        return fail(ErrorKind::dataset, path + ": cannot read: " + std::strerror(errno));
    Result<EptHeader> header = decodeHeader(std::span(head).first(static_cast<size_t>(got)), fileBytes, path);
    if (!header)
        return Unexpected{header.error()};
    impl->info = header->info;
    if (Result<void> index = impl->readIndex(*header); !index)
        return Unexpected{index.error()};
    return Dataset(std::move(impl));
}

Dataset::Dataset(std::unique_ptr<Impl> impl) : _impl(std::move(impl)) {}
Dataset::Dataset(Dataset&&) noexcept = default;
Dataset& Dataset::operator=(Dataset&&) noexcept = default;
Dataset::~Dataset() = default;

const DatasetInfo& Dataset::info() const noexcept
{
    return _impl->info;
}
std::span<const lod::PageNode> Dataset::pages() const noexcept
{
    return _impl->pages;
}

Result<void> Dataset::readPage(uint32_t page, PageHeights& heights) const
{
    assert(page < _impl->pages.size());
    const PagePlace& place = _impl->places[page];
    const auto bad = [&](const std::string& what) {
        return fail(ErrorKind::dataset, _impl->path + ": " + pageName(_impl->pages[page]) + ": " + what);
    };
    thread_local std::vector<uint8_t> buffer(kMaxPayloadBytes);
    const auto payload = std::span(buffer).first(place.bytes);
    const ssize_t got = _impl->file.read(place.offset, payload);
    if (got < 0)
        return bad(std::string("cannot read: ") + std::strerror(errno));
    if (got != static_cast<ssize_t>(payload.size()))
        return bad("the file is cut short");
    if (checksum(payload) != place.checksum)
        return bad("damaged (checksum)");
    if (!decodePage(payload, place.hasHoles, heights))
        return bad("damaged (content)");
    return {};
}

} // namespace ig::data
