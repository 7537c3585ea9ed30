// SPDX-License-Identifier: MIT
#include "ig/data/page_slots.h"

#include <algorithm>
#include <cassert>

namespace ig::data {

namespace {

uint64_t bitOf(uint32_t user)
{
    assert(user < PageSlots::kMaxUsers);
    return uint64_t{1} << user;
}

} // namespace

PageSlots::PageSlots(uint32_t pages, uint32_t slots)
    : _slotOfPage(pages, kNone), _slots(slots), _allFit(pages <= slots)
{
    assert(slots > 0);
}

void PageSlots::use(std::span<const uint32_t> pages, uint32_t user)
{
    if (_allFit) {
        return;
    }
    for (Slot& slot : _slots) {
        slot.users &= ~bitOf(user);
    }
    for (const uint32_t page : pages) {
        if (_slotOfPage[page] != kNone) {
            touch(page, user);
        }
    }
}

void PageSlots::keep(std::span<const uint32_t> pages, uint32_t user)
{
    if (_allFit) {
        return;
    }
    for (Slot& slot : _slots) {
        slot.keepers &= ~bitOf(user);
    }
    for (const uint32_t page : pages) {
        if (const int32_t slot = _slotOfPage[page]; slot != kNone) {
            _slots[static_cast<size_t>(slot)].keepers |= bitOf(user);
            makeNewest(slot);
        }
    }
}

void PageSlots::touch(uint32_t page, uint32_t user)
{
    const int32_t slot = _slotOfPage[page];
    assert(slot != kNone);
    if (!_allFit) {
        _slots[static_cast<size_t>(slot)].users |= bitOf(user);
        makeNewest(slot);
    }
}

bool PageSlots::isTaken(const Slot& slot, Claim claim) noexcept
{
    return slot.users != 0 || (claim == Claim::ahead && slot.keepers != 0);
}

uint32_t PageSlots::pagesInUse(Claim claim) const noexcept
{
    return static_cast<uint32_t>(std::count_if(_slots.begin(), _slots.end(),
                                               [claim](const Slot& slot) { return isTaken(slot, claim); }));
}

int32_t PageSlots::oldestFor(Claim claim) const noexcept
{
    int32_t slot = _oldest;
    while (slot != kNone && isTaken(_slots[static_cast<size_t>(slot)], claim)) {
        slot = _slots[static_cast<size_t>(slot)].newer;
    }
    return slot;
}

bool PageSlots::hasRoom(Claim claim) const noexcept
{
    return _resident < _slots.size() || oldestFor(claim) != kNone;
}

std::optional<PageSlots::Placement> PageSlots::place(uint32_t page, uint32_t user, Claim claim)
{
    assert(_slotOfPage[page] == kNone);
    int32_t slot = kNone;
    int32_t evicted = kNone;
    if (_resident < _slots.size()) {
        slot = static_cast<int32_t>(_resident++);
    } else {
        slot = oldestFor(claim);
        if (slot == kNone) {
            return std::nullopt;
        }
        evicted = _slots[static_cast<size_t>(slot)].page;
        _slotOfPage[static_cast<size_t>(evicted)] = kNone;
        unlink(slot);
    }
    Slot& placed = _slots[static_cast<size_t>(slot)];
    placed.page = static_cast<int32_t>(page);
    placed.users = !_allFit && claim == Claim::wanted ? bitOf(user) : 0;
    placed.keepers = !_allFit && claim == Claim::ahead ? bitOf(user) : 0;
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
