// SPDX-License-Identifier: MIT
// Which pages are resident and where: a fixed number of slots, the least recently used page leaves first,
// and never one that somebody uses. Users are the views, each with the pages of its newest selection and
// those that it may need soon. Bookkeeping only; who loads and uploads asks for a slot.
//
// Where all pages of the dataset fit, none ever leaves and nobody's use is noted.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ig::data {

// Whom a page may push out.
enum class Claim : uint8_t {
    wanted, // a picture lacks it: any page that nobody uses
    ahead   // it may be needed soon: pages that nobody uses or keeps
};

class PageSlots {
public:
    static constexpr int32_t kNone = -1;
    static constexpr uint32_t kMaxUsers = 64;

    // pages: of the dataset. slots: resident at one time, at least 1.
    PageSlots(uint32_t pages, uint32_t slots);

    // Slot of every page, kNone where not resident: what selection and drawing take.
    std::span<const int32_t> slotOfPage() const noexcept { return _slotOfPage; }
    uint32_t slots() const noexcept { return static_cast<uint32_t>(_slots.size()); }
    uint32_t residentPages() const noexcept { return _resident; }
    bool allFit() const noexcept { return _allFit; }
    // Pages that the claim must leave; none where all fit. O(slots).
    uint32_t pagesInUse(Claim claim = Claim::wanted) const noexcept;

    // Says that a user (< kMaxUsers) uses these resident pages and no others, the last named last: until its
    // next call they are not evicted. Who names children before their parents never loses a parent before its
    // children. O(slots).
    void use(std::span<const uint32_t> pages, uint32_t user = 0);
    // The same of pages that the user may need soon: nothing that comes ahead of need pushes them out. To be
    // called before use(). O(slots).
    void keep(std::span<const uint32_t> pages, uint32_t user = 0);

    // Whether place() would give a slot. O(pages in use).
    bool hasRoom(Claim claim = Claim::wanted) const noexcept;

    struct Placement {
        uint32_t slot = 0;
        int32_t evicted = kNone; // page that had the slot
    };
    // A slot for a page that is not resident, evicting the least recently used; nothing when all slots
    // hold pages that the claim must leave. The page counts as resident and, by its claim, used or kept from
    // now on. O(pages in use).
    std::optional<Placement> place(uint32_t page, uint32_t user = 0, Claim claim = Claim::wanted);
    // Says that a resident page is used, too, now.
    void touch(uint32_t page, uint32_t user = 0);

private:
    struct Slot {
        int32_t page = kNone;
        int32_t newer = kNone, older = kNone; // list by use
        uint64_t users = 0, keepers = 0;      // a bit each
    };

    void makeNewest(int32_t slot);
    void unlink(int32_t slot);
    void linkNewest(int32_t slot);
    static bool isTaken(const Slot& slot, Claim claim) noexcept;
    int32_t oldestFor(Claim claim) const noexcept;

    std::vector<int32_t> _slotOfPage;
    std::vector<Slot> _slots;
    int32_t _newest = kNone;
    int32_t _oldest = kNone;
    uint32_t _resident = 0;
    bool _allFit;
};

} // namespace ig::data
