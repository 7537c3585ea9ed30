// SPDX-License-Identifier: MIT
// Translates what a host says (degrees, per cent, wire structs) into statements about the world.
#pragma once

#include "hostif/session.h"
#include "ig/scene/world.h"

namespace ig::app {

class ToWorld {
public:
    // horizonS: how far entities may be moved on from what the host said, where it allows that; 0: not at
    // all.
    explicit ToWorld(double horizonS) : _horizonS(horizonS) {}

    // Events in order: a HostFrame gives the time of what follows.
    scene::Applied apply(const hostif::SessionEvent& event, scene::World& world);

private:
    double _horizonS;
    double _timeS = 0;
};

} // namespace ig::app
