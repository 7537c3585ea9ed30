// SPDX-License-Identifier: MIT
// ig/data: terrain datasets (.ept, see FORMAT.md) for the run-time: the index as the selection wants it and
// pages decoded one by one. It knows no GL. The compiler that writes such files is in tools/terrain.
#pragma once

#include "ig/base/result.h"
#include "ig/lod/terrain_shape.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace ig::data {

// Heights of one page: post (col, row) at [row * 65 + col], row 0 in the north. Metres are
// value * heightScaleM + heightOffsetM of the dataset.
struct PageHeights {
    std::vector<int16_t> post; // kPagePosts * kPagePosts
    // Codes of each post as a vertex of the bin-tree, see ig/lod/vertex_error.h; as long as post. Of the
    // posts that ancestors introduce, too: a shared vertex has the same codes in every page.
    std::vector<uint8_t> errorCode, radiusCode;
    // Values of the two ends of the edge that each corner post splits (north-west, north-east, south-west,
    // south-east): the only posts of a page whose ends lie outside of it. 0 for corners of the grid.
    std::array<std::array<int16_t, 2>, 4> cornerEnds{};
    // Cells (row * 64 + col) that are a hole; empty when the page has none.
    std::vector<bool> hole;

    // Memory for any page.
    void reserve();
};

struct DatasetInfo {
    lod::TerrainShape shape;
    double heightScaleM = 1;
    double heightOffsetM = 0;
    double minHeightM = 0;
    double maxHeightM = 0;
    bool hasHoles = false;
    std::string verticalDatum; // as the source named it, or "unknown"
    std::string source;        // file names the dataset was compiled from
    uint64_t checksum = 0;     // over the index, which holds the checksum of every page
    uint64_t fileBytes = 0;
};

// Where pages come from, one by one.
class PageSource {
public:
    virtual ~PageSource() = default;

    // Reads, checks and decodes a page into out (resized on first use, then reused: no allocation). parent:
    // the parent page as readPage decoded it, which has every fourth post; nullptr for the root and only
    // there. Thread-safe for different outputs. Errors (dataset): unreadable or damaged; the message names
    // the page.
    virtual Result<void> readPage(uint32_t page, const PageHeights* parent, PageHeights& out) const = 0;
};

// Copies are of one open file and one index.
class Dataset final : public PageSource {
public:
    // Opens a file and reads header and index. Errors (dataset): missing, not an .ept file, another
    // version, cut short, a checksum that does not match; the message says which and what to do.
    static Result<Dataset> open(const std::string& path);

    const DatasetInfo& info() const noexcept;
    // All pages, coarse to fine; page 0 is the root. Page numbers index this span.
    std::span<const lod::PageNode> pages() const noexcept;

    // Page that has this one for a child; kNoPage for the root.
    int32_t parentOf(uint32_t page) const noexcept;

    // Of pages' payloads, read from the file since it was opened.
    uint64_t bytesRead() const noexcept;
    Result<void> readPage(uint32_t page, const PageHeights* parent, PageHeights& out) const override;

    // Whether readPage would succeed, whatever state the page's ancestors are in. The same errors.
    Result<void> checkPage(uint32_t page) const;

private:
    struct Impl;
    explicit Dataset(std::shared_ptr<const Impl> impl);
    std::shared_ptr<const Impl> _impl; // whoever reads pages keeps the file open
};

// Pages in any order, for callers that keep no parents: reads the ancestors that the page before had not.
class PageReader {
public:
    // dataset must outlive the reader.
    explicit PageReader(const Dataset& dataset);

    // Valid until the next call. Errors (dataset): of the page, or of an ancestor.
    Result<const PageHeights*> read(uint32_t page);

private:
    const Dataset& _dataset;
    std::vector<PageHeights> _heights; // by depth: the last page and its ancestors
    std::vector<int32_t> _page;        // what they are of, kNoPage where nothing was read
};

} // namespace ig::data
