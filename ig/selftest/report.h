// SPDX-License-Identifier: MIT
// What the self-test has measured, against what.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ig::selftest {

enum class Bound { atMost, atLeast };

struct Measurement {
    std::string area;     // "geodesy", "terrain", ...
    std::string name;     // of the case
    std::string quantity; // what was measured
    std::string unit;     // "" for counts and shares
    Bound bound = Bound::atMost;
    double limit = 0;
    double measured = 0;

    // Not a number never passes.
    bool passes() const noexcept { return bound == Bound::atMost ? measured <= limit : measured >= limit; }
};

class Report {
public:
    void atMost(std::string_view area, std::string_view name, std::string_view quantity,
                std::string_view unit, double limit, double measured);
    void atLeast(std::string_view area, std::string_view name, std::string_view quantity,
                 std::string_view unit, double limit, double measured);

    const std::vector<Measurement>& measurements() const noexcept { return _measurements; }
    size_t failures() const noexcept;
    // Nothing measured is no pass.
    bool passes() const noexcept { return !_measurements.empty() && failures() == 0; }

    // A line per measurement and a last one that sums up.
    std::string table() const;
    // {"passes": bool, "cases": [{area, case, quantity, unit, bound, limit, measured, passes}, ...], ...};
    // numbers that JSON has not are strings.
    std::string json(std::string_view target) const;

private:
    std::vector<Measurement> _measurements;
};

} // namespace ig::selftest
