// SPDX-License-Identifier: MIT
#include "ig/app/terrain_residency.h"

#include "ig/app/steady_clock.h"
#include "ig/lod/page_graph.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace ig::app {

namespace {

constexpr uint32_t kFewestSlots = 16;
// Background pages on top of what views ask for: the threads always have the next ones.
constexpr size_t kRemainingAtOnce = 32;
// What is left before a frame for a page that takes long to upload: usually a fifth of it.
constexpr int64_t kTakeOverNs = 1'000'000;

} // namespace

gl::Morph rendererMorph(lod::Method method, bool morph) noexcept
{
    const gl::Morph moved = method == lod::Method::geomip ? gl::Morph::tiles : gl::Morph::lists;
    return morph ? moved : gl::Morph::none;
}

uint64_t residentPageBytes(gl::Morph morph) noexcept
{
    constexpr uint64_t kHeights = lod::kPagePostTotal * (sizeof(int16_t) + 2 * sizeof(uint8_t));
    constexpr uint64_t kSelector = lod::kPagePostTotal * 2 * sizeof(uint8_t) + sizeof(lod::PageGraph::Slot);
    return gl::bytesPerPage(morph) + kHeights + kSelector;
}

uint32_t pageSlotsFor(uint64_t limitBytes, gl::Morph morph, size_t datasetPages) noexcept
{
    const uint64_t fit = std::max<uint64_t>(limitBytes / residentPageBytes(morph), kFewestSlots);
    return static_cast<uint32_t>(std::min<uint64_t>(fit, datasetPages));
}

TerrainResidency::TerrainResidency(data::Dataset dataset, const TerrainSettings& settings,
                                   gl::Renderer& renderer, LogSink& log, const data::PageSource* source)
    : _dataset(std::move(dataset)), _settings(settings), _renderer(renderer), _log(log),
      _slots(static_cast<uint32_t>(_dataset.pages().size()), settings.pageSlots),
      _reaches(settings.pageSlots), _heights(settings.pageSlots), _lost(_dataset.pages().size(), false),
      _loader(
          source != nullptr ? *source : _dataset, _dataset.info(), _dataset.pages(),
          {.shading = settings.shading,
           .texels = settings.texels,
           .morph = rendererMorph(settings.selection.method, settings.selection.morph) != gl::Morph::none})
{
    // Room for any page now, so that loading never allocates.
    for (data::PageHeights& heights : _heights) {
        heights.reserve();
    }
    _requests.reserve(data::PageLoader::kMaxRequests);
    _taken.reserve(data::PageLoaderSettings{}.buffers);
    _pinned.reserve((data::PageLoader::kMaxRequests + data::PageLoaderSettings{}.buffers) *
                    (static_cast<size_t>(info().shape.deepestPage) + 1));
}

uint32_t TerrainResidency::attach(lod::Selector& selector)
{
    auto* const place = std::find(_selectors.begin(), _selectors.end(), nullptr);
    assert(place != _selectors.end());
    *place = &selector;
    const std::span<const int32_t> slotOfPage = _slots.slotOfPage();
    for (uint32_t page = 0; page < slotOfPage.size(); ++page) { // parents have the smaller numbers
        if (slotOfPage[page] >= 0) {
            addTo(selector, page, static_cast<uint32_t>(slotOfPage[page]));
        }
    }
    const auto view = static_cast<uint32_t>(place - _selectors.begin());
    _wishes[view].wanted.reserve(data::PageLoader::kMaxRequests);
    _wishes[view].ahead.reserve(data::PageLoader::kMaxRequests);
    return view;
}

void TerrainResidency::detach(uint32_t view)
{
    _selectors[view] = nullptr;
    _wishes[view] = {};
    _slots.keep({}, view);
    _slots.use({}, view);
}

void TerrainResidency::addTo(lod::Selector& selector, uint32_t page, uint32_t slot) const
{
    const data::DatasetInfo& info = _dataset.info();
    const data::PageHeights& heights = _heights[slot];
    selector.addPage(
        page, slot,
        {heights.post, info.heightScaleM, info.heightOffsetM, heights.errorCode, heights.radiusCode});
}

void TerrainResidency::keep(uint32_t view, std::span<const uint32_t> pages)
{
    _slots.keep(pages, view);
}

void TerrainResidency::use(uint32_t view, std::span<const uint32_t> pages)
{
    _slots.use(pages, view);
}

void TerrainResidency::takeOver(FrameStats& stats)
{
    const int64_t start = steadyNs();
    _isBetween = false;
    const size_t amongFirst = _restWaits ? _wantedRequests : data::PageLoader::kMaxRequests;
    while (stats.pageIns < _settings.pageLoadsPerFrame && takeNext(amongFirst, stats)) {
    }
    stats.pageIns += std::exchange(_betweenFrames.pageIns, 0);
    stats.bytesUploaded += std::exchange(_betweenFrames.bytesUploaded, 0);
    stats.loadNs += steadyNs() - start;
}

bool TerrainResidency::takeOverBefore(int64_t nextFrameNs)
{
    if (_settings.waitForPages) {
        return false;
    }
    const auto isTime = [nextFrameNs] { return steadyNs() + kTakeOverNs < nextFrameNs; };
    const bool hadTime = isTime();
    _restWaits = hadTime || (_isBetween && _restWaits);
    _isBetween = true;
    while (_betweenFrames.pageIns < _settings.pageLoadsPerFrame && isTime() &&
           takeNext(data::PageLoader::kMaxRequests, _betweenFrames)) {
    }
    return hadTime;
}

// A finished page, of the first so many requests. Its buffer stays until the next requests: the loader would
// fill it while the frame is drawn.
bool TerrainResidency::takeNext(size_t amongFirst, FrameStats& stats)
{
    data::LoadedPage* const loaded = _loader.take(amongFirst);
    if (loaded != nullptr) {
        place(*loaded, stats);
        _taken.push_back(loaded);
    }
    return loaded != nullptr;
}

void TerrainResidency::giveBackTaken()
{
    for (data::LoadedPage* const loaded : _taken) {
        _loader.giveBack(loaded);
    }
    _taken.clear();
}

void TerrainResidency::request(uint32_t view, std::span<const uint32_t> wanted,
                               std::span<const uint32_t> ahead)
{
    const auto copy = [](std::span<const uint32_t> from, std::vector<uint32_t>& to) {
        const size_t count = std::min(from.size(), data::PageLoader::kMaxRequests);
        to.assign(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
    };
    copy(wanted, _wishes[view].wanted);
    copy(ahead, _wishes[view].ahead);
    sendRequests();
}

uint32_t TerrainResidency::loadNow(uint32_t view, std::span<const uint32_t> wanted, FrameStats& stats,
                                   data::PageLoader::Clock::time_point deadline)
{
    const int64_t start = steadyNs();
    const uint32_t before = stats.pageIns;
    for (Wishes& wishes : _wishes) { // nobody else's, so that what comes is what this view lacks
        wishes.wanted.clear();
        wishes.ahead.clear();
    }
    request(view, wanted, {});
    while (data::LoadedPage* const loaded = _loader.waitAndTake(deadline)) {
        place(*loaded, stats);
        _loader.giveBack(loaded);
    }
    stats.loadNs += steadyNs() - start;
    return stats.pageIns - before;
}

bool TerrainResidency::allLoaded() const noexcept
{
    return _slots.allFit() && _remaining == _dataset.pages().size();
}

bool TerrainResidency::loadsAhead() const noexcept
{
    return _settings.prefetch && !_settings.waitForPages && !allLoaded();
}

void TerrainResidency::sendRequests()
{
    _requests.clear();
    const auto room = [this](data::Claim claim) { return size_t{_slots.slots()} - _slots.pagesInUse(claim); };
    addRequests(&Wishes::wanted, room(data::Claim::wanted));
    _wantedRequests = _requests.size();
    if (!_settings.waitForPages) {
        addRequests(&Wishes::ahead, _requests.size() + room(data::Claim::ahead));
        if (_slots.allFit()) {
            addRemaining();
        }
    }
    giveBackTaken();
    pinParents(_loader.request(_requests));
    if (allLoaded()) {
        _loader.stop();
    }
}

// The views' pages, one of each in turn, until there are `most` requests.
void TerrainResidency::addRequests(std::vector<uint32_t> Wishes::*list, size_t most)
{
    most = std::min(most, data::PageLoader::kMaxRequests);
    size_t longest = 0;
    for (const Wishes& wishes : _wishes) {
        longest = std::max(longest, (wishes.*list).size());
    }
    for (size_t i = 0; i < longest; ++i) {
        for (const Wishes& wishes : _wishes) {
            if (i < (wishes.*list).size() && _requests.size() < most) {
                addRequest((wishes.*list)[i]);
            }
        }
    }
}

// A page whose parent is not resident waits for it, and the parent is asked for instead.
void TerrainResidency::addRequest(uint32_t page)
{
    const std::span<const int32_t> slotOfPage = _slots.slotOfPage();
    int32_t parent = _dataset.parentOf(page);
    while (parent != lod::kNoPage && slotOfPage[static_cast<size_t>(parent)] < 0) {
        page = static_cast<uint32_t>(parent);
        parent = _dataset.parentOf(page);
    }
    const bool isAskedFor = std::any_of(_requests.begin(), _requests.end(),
                                        [page](const data::PageRequest& r) { return r.page == page; });
    if (slotOfPage[page] >= 0 || _lost[page] || isAskedFor) {
        return;
    }
    const data::PageHeights* parentHeights =
        parent != lod::kNoPage ? &_heights[static_cast<size_t>(slotOfPage[static_cast<size_t>(parent)])]
                               : nullptr;
    _requests.push_back({page, parentHeights});
}

// All fit: the next ones of the whole dataset.
void TerrainResidency::addRemaining()
{
    const std::span<const int32_t> slotOfPage = _slots.slotOfPage();
    const auto pages = static_cast<uint32_t>(_dataset.pages().size());
    const auto isSettled = [&](uint32_t page) {
        const int32_t parent = _dataset.parentOf(page);
        if (parent != lod::kNoPage && _lost[static_cast<size_t>(parent)]) {
            _lost[page] = true;
        }
        return slotOfPage[page] >= 0 || _lost[page];
    };
    while (_remaining < pages && isSettled(_remaining)) {
        ++_remaining;
    }
    const size_t most = std::min(_requests.size() + kRemainingAtOnce, data::PageLoader::kMaxRequests);
    for (uint32_t page = _remaining; page < pages && _requests.size() < most; ++page) {
        const int32_t parent = _dataset.parentOf(page);
        if (parent != lod::kNoPage && slotOfPage[static_cast<size_t>(parent)] < 0) {
            break; // nothing below it yet, and the next ones wait for its neighbours
        }
        addRequest(page);
    }
}

// What is read stands on its parent, and that on its own. Children before parents, as use() wants it.
void TerrainResidency::pinParents(std::span<const uint32_t> alsoRead)
{
    if (_slots.allFit()) {
        return;
    }
    _pinned.clear();
    const auto pin = [this](uint32_t page) {
        for (int32_t above = _dataset.parentOf(page); above != lod::kNoPage;
             above = _dataset.parentOf(static_cast<uint32_t>(above))) {
            _pinned.push_back(static_cast<uint32_t>(above));
        }
    };
    for (const data::PageRequest& request : _requests) {
        pin(request.page);
    }
    for (const uint32_t page : alsoRead) {
        pin(page);
    }
    _slots.keep({}, kLoadingUser); // views keep what has come ahead
    _slots.use(_pinned, kLoadingUser);
}

bool TerrainResidency::isWanted(uint32_t page) const noexcept
{
    return std::any_of(_wishes.begin(), _wishes.end(), [page](const Wishes& wishes) {
        return std::find(wishes.wanted.begin(), wishes.wanted.end(), page) != wishes.wanted.end();
    });
}

void TerrainResidency::place(data::LoadedPage& loaded, FrameStats& stats)
{
    const uint32_t page = loaded.page;
    if (loaded.error) {
        _lost[page] = true;
        ++_changes;
        ++_damagedCount;
        _log.write(LogLevel::error, loaded.error->message + "; drawn by its coarser ancestor");
        return;
    }
    const data::Claim claim = isWanted(page) ? data::Claim::wanted : data::Claim::ahead;
    const auto placement = _slots.place(page, kLoadingUser, claim);
    if (!placement) {
        ++_changes; // whoever wants it asks again
        return;
    }
    // Older than its ancestors, which it needs as long as it is resident.
    for (int32_t above = _dataset.parentOf(page); above != lod::kNoPage;
         above = _dataset.parentOf(static_cast<uint32_t>(above))) {
        _slots.touch(static_cast<uint32_t>(above), kLoadingUser);
    }
    const uint32_t slot = placement->slot;
    for (lod::Selector* selector : _selectors) {
        if (selector != nullptr && placement->evicted != data::PageSlots::kNone) {
            selector->removePage(static_cast<uint32_t>(placement->evicted), slot);
        }
    }
    ++_changes;
    std::swap(_heights[slot], loaded.heights);
    _reaches[slot] = lod::pageReach(page == 0, _heights[slot].errorCode, _heights[slot].radiusCode);
    for (lod::Selector* selector : _selectors) {
        if (selector != nullptr) {
            addTo(*selector, page, slot);
        }
    }
    ++stats.pageIns;
    stats.bytesUploaded += _renderer.upload(slot, loaded.mesh);
}

} // namespace ig::app
