// SPDX-License-Identifier: MIT
// A renderer without EGL that counts what it is asked for: frame loops run in tests and benchmarks on
// machines without a driver.
#pragma once

#include "ig/gl/renderer.h"

namespace ig::gl {

class NullRenderer final : public Renderer {
public:
    struct Counts {
        uint64_t uploads = 0;
        uint64_t begun = 0; // ahead of their lists
        uint64_t draws = 0; // frames
        uint64_t reads = 0;
        uint64_t finishes = 0;
        uint64_t tiles = 0;     // over all frames
        uint64_t lists = 0;     // over all frames
        uint64_t triangles = 0; // over all frames
        uint64_t badTiles = 0;  // of a page without a slot, or whose slot was never uploaded
        uint64_t badLists = 0;  // the same, or with indices that there are not
    };

    // Only the number of slots and the morph matter.
    explicit NullRenderer(const RendererSettings& settings);

    Result<void> setVisibility(const Context&, double) override { return {}; }
    void setPicture(size_t) override {}
    uint64_t upload(uint32_t slot, const data::PageMesh& mesh) override;
    void begin(const ViewState&) override { ++_counts.begun; }
    void draw(const ViewState& view, const lod::DrawList& list, std::span<const int32_t> slotOfPage) override;
    uint64_t listBytes() const noexcept override { return _listBytes; }
    // Fills with the low byte of the number of draws, so that frames differ.
    void read(std::span<std::byte> rgba) override;
    void finish() override { ++_counts.finishes; }
    void readDepth(std::span<float> depthM) override; // infinity
    double depthAt(int xPx, int yPx) override;        // infinity
    uint64_t gpuBytes() const noexcept override { return 0; }

    const Counts& counts() const noexcept { return _counts; }

private:
    bool hasVertices(uint32_t page, std::span<const int32_t> slotOfPage) const;

    std::vector<bool> _uploaded; // by slot
    Morph _morph;
    uint64_t _listBytes = 0;
    uint64_t _lastNumber = 0; // of the list drawn last
    Counts _counts;
};

} // namespace ig::gl
