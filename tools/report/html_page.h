// SPDX-License-Identifier: MIT
// The report as one page that is read without a network: plots as SVG, pictures inside, light and dark.
#pragma once

#include "ig/base/result.h"
#include "tools/report/records.h"

#include <string>

namespace report {

// report: as report.json has it. pictureDir: where the pictures that it names are. Errors (failed): one of
// them cannot be read.
ig::Result<std::string> htmlPage(const Json& report, const std::string& pictureDir);

} // namespace report
