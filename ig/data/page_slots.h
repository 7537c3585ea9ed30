// SPDX-License-Identifier: MIT
// Which pages are resident and where: a fixed number of slots, the least recently used page leaves first,
// and never one that the current frame draws. Bookkeeping only; who loads and uploads asks for a slot.
//
// Where all pages of the dataset fit, none ever leaves and no order is kept.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ig::data {

// Whom a page may push out.
enum class Claim : uint8_t {
    wanted, // a picture lacks it: any page that is not in use
    ahead   // it may be needed soon: pages that are neither in use nor kept
};

class PageSlots {
public:
    static constexpr int32_t kNone = -1;

    // pages: of the dataset. slots: resident at one time, at least 1.
    PageSlots(uint32_t pages, uint32_t slots);

    // Slot of every page, kNone where not resident: what selection and drawing take.
    std::span<const int32_t> slotOfPage() const noexcept { return _slotOfPage; }
    uint32_t residentPages() const noexcept { return _resident; }
    uint32_t slots() const noexcept { return static_cast<uint32_t>(_slots.size()); }
    bool allFit() const noexcept { return _allFit; }

    // Begins a frame: no page is in use or kept. The pages of the frame before leave before those that this
    // one names. Who names children before their parents never loses a parent before its children.
    void beginFrame() noexcept { ++_now; }
    // Pages (those not resident are passed over) that may be needed soon: nothing that is loaded ahead pushes
    // them out in this frame. To be named before those in use. O(pages).
    void keep(std::span<const uint32_t> pages);
    // Pages that this frame needs, the last named last: not evicted in this frame. O(pages).
    void use(std::span<const uint32_t> pages);
    // The same for one resident page.
    void use(uint32_t page);

    // Whether place() would give a slot.
    bool hasRoom(Claim claim = Claim::wanted) const noexcept;

    struct Placement {
        uint32_t slot = 0;
        int32_t evicted = kNone; // page that had the slot
    };
    // A slot for a page that is not resident, evicting the least recently used; nothing when all slots
    // hold pages that the claim must leave. The page counts as resident and, by its claim, used or kept from
    // now on. O(1).
    std::optional<Placement> place(uint32_t page, Claim claim = Claim::wanted);

private:
    struct Slot {
        int32_t page = kNone;
        int32_t newer = kNone, older = kNone; // list by use
        uint64_t usedAt = 0;                  // frame
        uint64_t keptAt = 0;
    };

    void makeNewest(int32_t slot);
    void unlink(int32_t slot);
    void linkNewest(int32_t slot);

    std::vector<int32_t> _slotOfPage;
    std::vector<Slot> _slots;
    int32_t _newest = kNone;
    int32_t _oldest = kNone;
    uint32_t _resident = 0;
    uint64_t _now = 1;
    bool _allFit;
};

} // namespace ig::data
