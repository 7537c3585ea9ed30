// SPDX-License-Identifier: MIT
// What one frame cost and how wrong it was. Filled every frame; statistics, tools and benchmarks read this.
#pragma once

#include "ig/lod/draw_list.h"

#include <cstdint>

namespace ig::app {

struct FrameStats {
    uint64_t number = 0; // of its view's frames
    uint32_t view = 0;   // its place among the views of the process
    // The host has put there what the view sits on; else the picture is the last one, at first one from above
    // the middle of the terrain.
    bool placed = false;
    // Wall time of the stages, ns. frameNs runs from the frame's start until it is handed to the sinks;
    // waiting for that (output.hold_ms) and for the next slot does not count.
    int64_t frameNs = 0;
    int64_t hostNs = 0; // receive, apply, answer
    int64_t selectNs = 0;
    int64_t drawNs = 0; // until GL has taken the commands
    // Until the picture is here, or drawn where nobody reads it: with a deferring driver most of the drawing.
    int64_t readBackNs = 0;
    int64_t sinkNs = 0;
    int64_t loadNs = 0; // pages read, decoded and uploaded within the frame
    // From the kernel's receipt of the newest host message used to the frame in the sinks; -1 when no
    // message came in since the frame before.
    int64_t transportDelayNs = -1;
    // From the start of the slot to the frame in the sinks, with all that was waited for.
    int64_t handedOutNs = 0;
    uint32_t triangleBudget = 0; // that was in force
    lod::LodStats lod;
    uint32_t pageIns = 0;       // since the last frame
    uint64_t bytesUploaded = 0; // of pages
    uint64_t listBytes = 0;     // of indices, of lists and tiles, handed to GL
    bool selectionKept = false; // the view was that of the frame before: nothing was selected
    bool pictureKept = false;   // nor drawn
};

} // namespace ig::app
