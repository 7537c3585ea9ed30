// SPDX-License-Identifier: MIT
// What a table of single fields cannot say about a message, whatever protocol carries it. Private to hostif's
// codecs. Each settle() takes the fault found so far and returns the final one.
#pragma once

#include "hostif/packet_fields.h"
#include "hostif/reason.h"

namespace hostif::detail {

Fault settle(EntityControl& entity, Fault fault, ReasonCounts& notes);
Fault settle(EntityAppearance& entity, Fault fault, ReasonCounts& notes);
Fault settle(EntityPosition& entity, Fault fault, ReasonCounts& notes);
Fault settle(ViewDefinition& view, Fault fault, ReasonCounts& notes);
Fault settle(CelestialSphereControl& sky, Fault fault, ReasonCounts& notes);
Fault settle(HatHotRequest& request, Fault fault, ReasonCounts& notes);
Fault settle(LosSegmentRequest& request, Fault fault, ReasonCounts& notes);
Fault settle(LosVectorRequest& request, Fault fault, ReasonCounts& notes);

template <class M>
Fault settle(M&, Fault fault, ReasonCounts&)
{
    return fault;
}

} // namespace hostif::detail
