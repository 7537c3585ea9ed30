// SPDX-License-Identifier: MIT
#include "ig/data/page_slots.h"

#include <cassert>

namespace ig::data {

PageSlots::PageSlots(uint32_t pages, uint32_t slots)
    : _slotOfPage(pages, kNone), _slots(slots), _allFit(pages <= slots)
{
    assert(slots > 0);
}

void PageSlots::keep(std::span<const uint32_t> pages)
{
    if (_allFit) {
        return;
    }
    for (const uint32_t page : pages) {
        if (const int32_t slot = _slotOfPage[page]; slot != kNone) {
            _slots[static_cast<size_t>(slot)].keptAt = _now;
            makeNewest(slot);
        }
    }
}

void PageSlots::use(std::span<const uint32_t> pages)
{
    if (_allFit) {
        return;
    }
    for (const uint32_t page : pages) {
        if (_slotOfPage[page] != kNone) {
            use(page);
        }
    }
}

void PageSlots::use(uint32_t page)
{
    const int32_t slot = _slotOfPage[page];
    assert(slot != kNone);
    if (!_allFit) {
        _slots[static_cast<size_t>(slot)].usedAt = _now;
        makeNewest(slot);
    }
}

bool PageSlots::hasRoom(Claim claim) const noexcept
{
    if (_resident < _slots.size()) {
        return true;
    }
    const Slot& oldest = _slots[static_cast<size_t>(_oldest)];
    return oldest.usedAt != _now && (claim == Claim::wanted || oldest.keptAt != _now);
}

std::optional<PageSlots::Placement> PageSlots::place(uint32_t page, Claim claim)
{
    assert(_slotOfPage[page] == kNone);
    if (!hasRoom(claim)) {
        return std::nullopt;
    }
    int32_t slot = kNone;
    int32_t evicted = kNone;
    if (_resident < _slots.size()) {
        slot = static_cast<int32_t>(_resident++);
    } else {
        slot = _oldest;
        evicted = _slots[static_cast<size_t>(slot)].page;
        _slotOfPage[static_cast<size_t>(evicted)] = kNone;
        unlink(slot);
    }
    Slot& placed = _slots[static_cast<size_t>(slot)];
    placed.page = static_cast<int32_t>(page);
    (claim == Claim::wanted ? placed.usedAt : placed.keptAt) = _now;
    _slotOfPage[page] = slot;
    linkNewest(slot);
    return Placement{static_cast<uint32_t>(slot), evicted};
}

void PageSlots::makeNewest(int32_t slot)
{
    unlink(slot);
    linkNewest(slot);
}

void PageSlots::unlink(int32_t index)
{
    Slot& slot = _slots[static_cast<size_t>(index)];
    (slot.newer != kNone ? _slots[static_cast<size_t>(slot.newer)].older : _newest) = slot.older;
    (slot.older != kNone ? _slots[static_cast<size_t>(slot.older)].newer : _oldest) = slot.newer;
    slot.newer = slot.older = kNone;
}

void PageSlots::linkNewest(int32_t index)
{
    Slot& slot = _slots[static_cast<size_t>(index)];
    slot.older = _newest;
    if (_newest != kNone) {
        _slots[static_cast<size_t>(_newest)].newer = index;
    }
    _newest = index;
    if (_oldest == kNone) {
        _oldest = index;
    }
}

} // namespace ig::data
