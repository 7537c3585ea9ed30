// SPDX-License-Identifier: MIT
#include "ig/data/page_slots.h"

#include <algorithm>
#include <cassert>

namespace ig::data {

PageSlots::PageSlots(uint32_t pages, uint32_t slots) : _slotOfPage(pages, kNone), _slots(slots)
{
    assert(slots > 0);
}

uint32_t PageSlots::pagesInUse() const noexcept
{
    return static_cast<uint32_t>(
        std::count_if(_slots.begin(), _slots.end(), [](const Slot& slot) { return slot.users != 0; }));
}

void PageSlots::use(std::span<const uint32_t> pages, uint32_t user)
{
    assert(user < kMaxUsers);
    for (Slot& slot : _slots) {
        slot.users &= ~(1U << user);
    }
    for (const uint32_t page : pages) {
        if (_slotOfPage[page] != kNone) {
            touch(page, user);
        }
    }
}

void PageSlots::touch(uint32_t page, uint32_t user)
{
    const int32_t slot = _slotOfPage[page];
    assert(slot != kNone);
    _slots[static_cast<size_t>(slot)].users |= 1U << user;
    unlink(slot);
    linkNewest(slot);
}

int32_t PageSlots::oldestUnused() const noexcept
{
    int32_t slot = _oldest;
    while (slot != kNone && _slots[static_cast<size_t>(slot)].users != 0) {
        slot = _slots[static_cast<size_t>(slot)].newer;
    }
    return slot;
}

bool PageSlots::hasRoom() const noexcept
{
    return _resident < _slots.size() || oldestUnused() != kNone;
}

std::optional<PageSlots::Placement> PageSlots::place(uint32_t page, uint32_t user)
{
    assert(_slotOfPage[page] == kNone);
    int32_t slot = kNone;
    int32_t evicted = kNone;
    if (_resident < _slots.size()) {
        slot = static_cast<int32_t>(_resident++);
    } else {
        slot = oldestUnused();
        if (slot == kNone) {
            return std::nullopt;
        }
        evicted = _slots[static_cast<size_t>(slot)].page;
        _slotOfPage[static_cast<size_t>(evicted)] = kNone;
        unlink(slot);
    }
    _slots[static_cast<size_t>(slot)].page = static_cast<int32_t>(page);
    _slots[static_cast<size_t>(slot)].users = 1U << user;
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
