// SPDX-License-Identifier: MIT
#include "ig/data/page_slots.h"

#include <cassert>

namespace ig::data {

PageSlots::PageSlots(uint32_t pages, uint32_t slots) : _slotOfPage(pages, kNone), _slots(slots)
{
    assert(slots > 0);
}

void PageSlots::use(std::span<const uint32_t> pages)
{
    ++_now;
    for (const uint32_t page : pages) {
        if (_slotOfPage[page] != kNone) {
            touch(page);
        }
    }
}

void PageSlots::touch(uint32_t page)
{
    const int32_t slot = _slotOfPage[page];
    assert(slot != kNone);
    _slots[static_cast<size_t>(slot)].usedAt = _now;
    unlink(slot);
    linkNewest(slot);
}

bool PageSlots::hasRoom() const noexcept
{
    return _resident < _slots.size() || _slots[static_cast<size_t>(_oldest)].usedAt != _now;
}

std::optional<PageSlots::Placement> PageSlots::place(uint32_t page)
{
    assert(_slotOfPage[page] == kNone);
    if (!hasRoom()) {
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
    _slots[static_cast<size_t>(slot)].page = static_cast<int32_t>(page);
    _slots[static_cast<size_t>(slot)].usedAt = _now;
    _slotOfPage[page] = slot;
    linkNewest(slot);
    return Placement{static_cast<uint32_t>(slot), evicted};
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
