// SPDX-License-Identifier: MIT
#include "tools/terrain/compile.h"

#include "ig/data/ept_format.h"
#include "ig/data/hierarchy.h"
#include "ig/data/page_codec.h"
#include "tools/terrain/code_planes.h"
#include "tools/terrain/grid_trig.h"
#include "tools/terrain/parallel.h"
#include "tools/terrain/partial_file.h"
#include "tools/terrain/vertex_errors.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

namespace ig::terrain {

namespace {

using data::postColumn;
using data::postRow;

// Pages made between two writes; also what the grid's memory is kept for. Coarse ones, and those along its
// end, reach over so much of it that they go in small batches.
constexpr size_t kBatchPages = 512;
constexpr size_t kCoarseBatchPages = 16;
constexpr int kFineDepths = 2;

float roundedUp(double value)
{
    const auto narrow = static_cast<float>(value);
    return static_cast<double>(narrow) < value
               ? std::nextafter(narrow, std::numeric_limits<float>::infinity())
               : narrow;
}

class Compiler {
public:
    Compiler(const GridStore& grid, const GridBits& holeCells, const GridPlace& place,
             const Monitor& monitor);
    Result<void> run(const std::string& path);

private:
    void fillPage(const lod::PageNode& node, data::PageHeights& heights) const;
    void fillHoles(const lod::PageNode& node, data::PageHeights& heights) const;
    void fillCodes(const lod::PageNode& node, const CodePlanes& planes, data::PageHeights& heights) const;
    Result<void> measurePages(CodePlanes& planes);
    Result<void> writePages(PartialFile& file, const CodePlanes& planes);
    void addMeasure(size_t page, const LeafMeasure& measure);
    void joinChildren();
    Result<void> writeIndex(PartialFile& file);
    Result<void> verify(const std::string& path) const;

    const GridStore& _grid;
    const GridBits& _holeCells;
    const Monitor& _monitor;
    data::EptHeader _header;
    GridTrig _trig;
    std::vector<lod::PageNode> _pages;
    std::vector<data::PagePlace> _places;
    std::vector<uint32_t> _parent;
    std::vector<double> _tileErrorM; // of each page's stride-4 tile
    uint64_t _end = 0;               // of what has been written
};

// An angle as the file gives it back, which holds degrees: what is measured here must be the same bits there.
double storedRad(double angleDeg)
{
    double angleRad = angleDeg * kRadPerDeg;
    for (double again = angleRad * kDegPerRad * kRadPerDeg; again != angleRad;
         again = angleRad * kDegPerRad * kRadPerDeg)
        angleRad = again;
    return angleRad;
}

lod::TerrainShape shapeOf(const GridPlace& place, uint32_t cols, uint32_t rows)
{
    lod::TerrainShape shape;
    shape.ellipsoid = place.ellipsoid;
    shape.northRad = storedRad(place.northDeg);
    shape.westRad = storedRad(place.westDeg);
    shape.latitudeStepRad = storedRad(place.latitudeStepDeg);
    shape.longitudeStepRad = storedRad(place.longitudeStepDeg);
    shape.cols = cols;
    shape.rows = rows;
    shape.deepestPage = data::deepestPageOf(cols, rows);
    return shape;
}

Compiler::Compiler(const GridStore& grid, const GridBits& holeCells, const GridPlace& place,
                   const Monitor& monitor)
    : _grid(grid), _holeCells(holeCells), _monitor(monitor),
      _trig(shapeOf(place, grid.cols(), grid.rows()), place.heightScaleM, place.heightOffsetM)
{
    data::DatasetInfo& info = _header.info;
    info.shape = shapeOf(place, grid.cols(), grid.rows());
    info.heightScaleM = place.heightScaleM;
    info.heightOffsetM = place.heightOffsetM;
    info.hasHoles = !holeCells.empty();
    info.verticalDatum = place.verticalDatum.substr(0, 256);
    info.source = place.source.substr(0, 32768);
    _pages = data::buildHierarchy(info.shape);
    _places.resize(_pages.size());
    _parent.assign(_pages.size(), 0);
    _tileErrorM.assign(_pages.size(), 0);
    for (size_t i = 0; i < _pages.size(); ++i)
        for (const int32_t child : _pages[i].child)
            if (child != lod::kNoPage)
                _parent[static_cast<size_t>(child)] = static_cast<uint32_t>(i);
    for (data::PagePlace& p : _places) {
        p.minPost = std::numeric_limits<int16_t>::max();
        p.maxPost = std::numeric_limits<int16_t>::min();
    }
    _header.pageCount = static_cast<uint32_t>(_pages.size());
}

void Compiler::fillPage(const lod::PageNode& node, data::PageHeights& heights) const
{
    const lod::TerrainShape& shape = _header.info.shape;
    heights.post.resize(data::kPagePostCount);
    size_t at = 0;
    for (int j = 0; j < lod::kPagePosts; ++j) {
        const auto row = _grid.row(postRow(shape, node.depth, node.y, j));
        for (int i = 0; i < lod::kPagePosts; ++i)
            heights.post[at++] = row[postColumn(shape, node.depth, node.x, i)];
    }
    fillHoles(node, heights);
}

// A coarse cell is a hole where most of the grid's cells in it are.
void Compiler::fillHoles(const lod::PageNode& node, data::PageHeights& heights) const
{
    heights.hole.clear();
    if (_holeCells.empty())
        return;
    const lod::TerrainShape& shape = _header.info.shape;
    bool any = false;
    heights.hole.assign(data::kPageCellCount, false);
    for (int j = 0; j < lod::kPageIntervals; ++j)
        for (int i = 0; i < lod::kPageIntervals; ++i) {
            const uint32_t c0 = postColumn(shape, node.depth, node.x, i);
            const uint32_t c1 = postColumn(shape, node.depth, node.x, i + 1);
            const uint32_t r0 = postRow(shape, node.depth, node.y, j);
            const uint32_t r1 = postRow(shape, node.depth, node.y, j + 1);
            const uint64_t cells = uint64_t{c1 - c0} * (r1 - r0);
            if (2 * _holeCells.count(c0, c1, r0, r1) > cells) {
                heights.hole[static_cast<size_t>(j * lod::kPageIntervals + i)] = true;
                any = true;
            }
        }
    if (!any)
        heights.hole.clear();
}

void Compiler::addMeasure(size_t page, const LeafMeasure& measure)
{
    lod::PageNode& node = _pages[page];
    node.stitchedErrorM = roundedUp(measure.stitchedErrorM);
    for (size_t i = 0; i < 4; ++i)
        node.quarterErrorM[i] = std::max(node.stitchedErrorM, roundedUp(measure.quarterErrorM[i]));
    _places[page].minPost = measure.minPost;
    _places[page].maxPost = measure.maxPost;
    size_t ancestor = page;
    for (int depth = node.depth; depth >= 0; --depth) {
        _tileErrorM[ancestor] =
            std::max(_tileErrorM[ancestor], measure.tileErrorM[static_cast<size_t>(depth)]);
        ancestor = _parent[ancestor];
    }
}

// The codes that the payload holds; those of the finest vertices are left out.
void Compiler::fillCodes(const lod::PageNode& node, const CodePlanes& planes,
                         data::PageHeights& heights) const
{
    const int pageLevel = _header.info.shape.deepestPage - node.depth;
    heights.errorCode.assign(data::kPagePostCount, 0);
    heights.radiusCode.assign(data::kPagePostCount, 0);
    size_t post = 0;
    for (int64_t j = 0; j < lod::kPagePosts; ++j)
        for (int64_t i = 0; i < lod::kPagePosts; ++i, ++post) {
            const int64_t column = int64_t{node.x} * lod::kPageIntervals + i;
            const int64_t row = int64_t{node.y} * lod::kPageIntervals + j;
            // Corners of the grid have no spacing and the finest vertices no plane.
            const int finer = std::min(std::countr_zero(static_cast<uint64_t>(column | row)),
                                       std::countr_zero(uint64_t{lod::kPageIntervals}) + node.depth);
            const int level = pageLevel + finer;
            if (level == 0 || level > _header.info.shape.deepestPage + 5)
                continue;
            heights.errorCode[post] = planes.errorCode(level, column >> finer, row >> finer);
            heights.radiusCode[post] = planes.radiusCode(level, column >> finer, row >> finer);
        }
}

Result<void> Compiler::measurePages(CodePlanes& planes)
{
    const lod::TerrainShape& shape = _header.info.shape;
    std::vector<PageMeasurer> measurers(workerCount(), PageMeasurer(shape, _grid, _trig, planes));
    std::vector<LeafMeasure> measures(std::min(kBatchPages, _pages.size()));
    size_t first = 0;
    while (_pages[first].depth < shape.deepestPage)
        ++first;
    const size_t leaves = _pages.size() - first;
    for (size_t done = 0, count = 0; done < leaves; done += count) {
        if (_monitor.isCancelled())
            return interrupted();
        count = std::min(kBatchPages, leaves - done);
        parallelFor(count, [&](size_t i, unsigned worker) {
            const lod::PageNode& node = _pages[first + done + i];
            measures[i] = measurers[worker].measure(node.x, node.y);
        });
        for (size_t i = 0; i < count; ++i)
            addMeasure(first + done + i, measures[i]);
        _grid.release();
        planes.release();
        _monitor.report("measuring", static_cast<double>(done + count) / static_cast<double>(leaves));
    }
    // Children of vertices near the grid's end lie behind it.
    const auto pagesOver = [&](uint64_t posts) {
        return static_cast<uint32_t>(std::min((posts + lod::kPageIntervals - 1) / lod::kPageIntervals,
                                              uint64_t{1} << shape.deepestPage));
    };
    const uint32_t across = pagesOver(uint64_t{shape.cols} - 1);
    const uint32_t down = pagesOver(uint64_t{shape.rows} - 1);
    const uint32_t paddedAcross = pagesOver(uint64_t{shape.cols} - 1 + CodePlanes::kFinestMargin);
    const uint32_t paddedDown = pagesOver(uint64_t{shape.rows} - 1 + CodePlanes::kFinestMargin);
    std::vector<std::pair<uint32_t, uint32_t>> padding;
    for (uint32_t y = 0; y < paddedDown; ++y)
        for (uint32_t x = y < down ? across : 0; x < paddedAcross; ++x)
            padding.emplace_back(x, y);
    for (size_t done = 0; done < padding.size(); done += kCoarseBatchPages) {
        parallelFor(std::min(kCoarseBatchPages, padding.size() - done), [&](size_t i, unsigned worker) {
            measurers[worker].measurePadding(padding[done + i].first, padding[done + i].second);
        });
        _grid.release();
        planes.release();
    }
    return planes.nest(_grid, _trig, _monitor);
}

Result<void> Compiler::writePages(PartialFile& file, const CodePlanes& planes)
{
    struct Slot {
        data::PageHeights heights;
        std::vector<uint8_t> payload;
    };
    const int deepest = _header.info.shape.deepestPage;
    std::vector<Slot> slots(std::min(kBatchPages, _pages.size()));
    std::vector<uint8_t> bytes;
    for (size_t first = 0, count = 0; first < _pages.size(); first += count) {
        if (_monitor.isCancelled())
            return interrupted();
        const bool isFine = _pages[first].depth > deepest - kFineDepths;
        count = std::min(isFine ? kBatchPages : kCoarseBatchPages, _pages.size() - first);
        parallelFor(count, [&](size_t i, unsigned) {
            const lod::PageNode& node = _pages[first + i];
            Slot& slot = slots[i];
            fillPage(node, slot.heights);
            fillCodes(node, planes, slot.heights);
            data::encodePage(slot.heights,
                             {node.depth == 0, node.depth == deepest, !slot.heights.hole.empty()},
                             slot.payload);
        });
        bytes.clear();
        for (size_t i = 0; i < count; ++i) {
            const Slot& slot = slots[i];
            data::PagePlace& place = _places[first + i];
            place.offset = _end + bytes.size();
            place.bytes = static_cast<uint32_t>(slot.payload.size());
            place.checksum = data::checksum(slot.payload);
            place.hasHoles = !slot.heights.hole.empty();
            bytes.insert(bytes.end(), slot.payload.begin(), slot.payload.end());
        }
        if (Result<void> written = file.write(_end, bytes); !written)
            return written;
        _end += bytes.size();
        _grid.release();
        planes.release();
        _monitor.report("compiling", static_cast<double>(first + count) / static_cast<double>(_pages.size()));
    }
    return {};
}

// From the deepest pages up: errors that never grow with depth, and height ranges.
void Compiler::joinChildren()
{
    for (size_t page = _pages.size(); page-- > 0;) {
        lod::PageNode& node = _pages[page];
        node.errorM = roundedUp(_tileErrorM[page]);
        const bool isLeaf = node.depth == _header.info.shape.deepestPage;
        if (isLeaf)
            for (const float quarter : node.quarterErrorM)
                node.errorM = std::max(node.errorM, quarter);
        for (const int32_t number : node.child) {
            if (number == lod::kNoPage)
                continue;
            const auto child = static_cast<size_t>(number);
            node.errorM = std::max(node.errorM, _pages[child].errorM);
            _places[page].minPost = std::min(_places[page].minPost, _places[child].minPost);
            _places[page].maxPost = std::max(_places[page].maxPost, _places[child].maxPost);
        }
    }
}

Result<void> Compiler::writeIndex(PartialFile& file)
{
    data::DatasetInfo& info = _header.info;
    std::vector<uint8_t> index(_pages.size() * data::kIndexRecordBytes);
    for (size_t i = 0; i < _pages.size(); ++i)
        data::encodeRecord(_pages[i], _places[i],
                           std::span(index).subspan(i * data::kIndexRecordBytes, data::kIndexRecordBytes));
    _header.indexOffset = _end;
    info.checksum = data::checksum(index);
    info.fileBytes = _end + index.size();
    info.minHeightM = _places[0].minPost * info.heightScaleM + info.heightOffsetM;
    info.maxHeightM = _places[0].maxPost * info.heightScaleM + info.heightOffsetM;
    if (Result<void> written = file.write(_end, index); !written)
        return written;
    return file.write(0, data::encodeHeader(_header));
}

Result<void> Compiler::verify(const std::string& path) const
{
    const Result<data::Dataset> dataset = data::Dataset::open(path);
    if (!dataset)
        return Unexpected{dataset.error()};
    std::mutex mutex;
    Result<void> outcome;
    for (size_t first = 0; first < _pages.size() && outcome; first += kBatchPages) {
        if (_monitor.isCancelled())
            return interrupted();
        parallelFor(std::min(kBatchPages, _pages.size() - first), [&](size_t i, unsigned) {
            Result<void> sound = dataset->checkPage(static_cast<uint32_t>(first + i));
            if (sound)
                return;
            const std::lock_guard lock(mutex);
            outcome = std::move(sound);
        });
        _monitor.report("verifying", static_cast<double>(first) / static_cast<double>(_pages.size()));
    }
    return outcome;
}

Result<void> Compiler::run(const std::string& path)
{
    Result<PartialFile> file = PartialFile::create(path);
    if (!file)
        return Unexpected{file.error()};
    _end = data::encodeHeader(_header).size();
    _header.headerBytes = _end;
    Result<CodePlanes> planes = CodePlanes::create(_header.info.shape, folderOf(path));
    if (!planes)
        return Unexpected{planes.error()};
    if (Result<void> done = measurePages(*planes); !done)
        return done;
    joinChildren();
    if (Result<void> done = writePages(*file, *planes); !done)
        return done;
    if (Result<void> done = writeIndex(*file); !done)
        return done;
    if (Result<void> done = verify(file->partialPath()); !done)
        return done;
    return file->commit();
}

Result<void> checkPlace(const GridPlace& place, uint32_t cols, uint32_t rows)
{
    if (cols < 2 || rows < 2 || cols > data::kMaxGridPosts || rows > data::kMaxGridPosts)
        return fail(ErrorKind::usage, "a grid of " + std::to_string(cols) + " x " + std::to_string(rows) +
                                          " posts: 2 to " + std::to_string(data::kMaxGridPosts) +
                                          " per axis are possible");
    data::DatasetInfo info;
    info.shape = shapeOf(place, cols, rows);
    info.heightScaleM = place.heightScaleM;
    info.heightOffsetM = place.heightOffsetM;
    if (!data::isPlausible(info))
        return fail(ErrorKind::usage, "the grid does not fit on its globe: latitudes -90 to 90, at most 360 "
                                      "degrees of longitude, steps above 0");
    return {};
}

} // namespace

Result<void> compileGrid(const GridStore& grid, const GridBits& holeCells, const GridPlace& place,
                         const std::string& path, const Monitor& monitor)
{
    if (Result<void> fine = checkPlace(place, grid.cols(), grid.rows()); !fine)
        return fine;
    return Compiler(grid, holeCells, place, monitor).run(path);
}

Result<void> compileHeights(uint32_t cols, uint32_t rows, const GridPlace& place,
                            const std::function<double(uint32_t col, uint32_t row)>& heightM,
                            const std::string& path)
{
    if (Result<void> fine = checkPlace(place, cols, rows); !fine)
        return fine;
    Result<GridStore> grid = GridStore::create(cols, rows, folderOf(path));
    if (!grid)
        return Unexpected{grid.error()};
    GridBits voids;
    for (uint32_t r = 0; r < rows; ++r)
        for (uint32_t c = 0; c < cols; ++c) {
            const double value = std::round((heightM(c, r) - place.heightOffsetM) / place.heightScaleM);
            int16_t& post = grid->row(r)[c];
            post = 0;
            if (std::isnan(value)) {
                if (voids.empty())
                    voids = GridBits(cols, rows);
                voids.set(c, r);
            } else if (!(std::abs(value) <= 32767))
                return fail(ErrorKind::usage, "a height does not fit 16 bits at this height scale");
            else
                post = static_cast<int16_t>(value);
        }
    return compileGrid(*grid, cellsOfVoids(voids, cols, rows), place, path);
}

GridBits cellsOfVoids(const GridBits& voidPosts, uint32_t cols, uint32_t rows)
{
    if (voidPosts.empty())
        return {};
    GridBits cells(cols, rows);
    for (uint32_t r = 0; r + 1 < rows; ++r)
        for (uint32_t c = 0; c + 1 < cols; ++c)
            if (voidPosts.test(c, r) || voidPosts.test(c + 1, r) || voidPosts.test(c, r + 1) ||
                voidPosts.test(c + 1, r + 1))
                cells.set(c, r);
    return cells;
}

} // namespace ig::terrain
