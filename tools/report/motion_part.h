// SPDX-License-Identifier: MIT
// The motion part of a report: the error of extrapolation, each property of the link varied in turn.
#pragma once

#include "ig/geo/view_state.h"
#include "tools/report/records.h"

namespace report {

// Rows of integrator, flight, what was varied and its value, and the errors.
Json motionJson(const ig::ViewState& view);

} // namespace report
