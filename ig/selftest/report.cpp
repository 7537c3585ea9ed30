// SPDX-License-Identifier: MIT
#include "ig/selftest/report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace ig::selftest {

void Report::atMost(std::string_view area, std::string_view name, std::string_view quantity,
                    std::string_view unit, double limit, double measured)
{
    _measurements.push_back({std::string(area), std::string(name), std::string(quantity), std::string(unit),
                             Bound::atMost, limit, measured});
}

void Report::atLeast(std::string_view area, std::string_view name, std::string_view quantity,
                     std::string_view unit, double limit, double measured)
{
    atMost(area, name, quantity, unit, limit, measured);
    _measurements.back().bound = Bound::atLeast;
}

size_t Report::failures() const noexcept
{
    return static_cast<size_t>(std::count_if(_measurements.begin(), _measurements.end(),
                                             [](const Measurement& m) { return !m.passes(); }));
}

std::string Report::table() const
{
    size_t nameWidth = 4;
    size_t quantityWidth = 8;
    for (const Measurement& m : _measurements) {
        nameWidth = std::max(nameWidth, m.name.size());
        quantityWidth = std::max(quantityWidth, m.quantity.size());
    }
    std::string text = fmt::format("{:<9}  {:<{}}  {:<{}}  {:>13}  {:>11}  {:<5}\n", "area", "case",
                                   nameWidth, "quantity", quantityWidth, "limit", "measured", "unit");
    for (const Measurement& m : _measurements) {
        text +=
            fmt::format("{:<9}  {:<{}}  {:<{}}  {} {:>10.4g}  {:>11.4g}  {:<5}  {}\n", m.area, m.name,
                        nameWidth, m.quantity, quantityWidth, m.bound == Bound::atMost ? "<=" : ">=", m.limit,
                        m.measured, m.unit, m.passes() ? "pass" : "FAIL");
    }
    return text + fmt::format("{} measured, {} failed\n", _measurements.size(), failures());
}

std::string Report::json(std::string_view target) const
{
    using Json = nlohmann::ordered_json;
    const auto number = [](double value) {
        return std::isfinite(value) ? Json(value) : Json(fmt::format("{}", value));
    };
    Json cases = Json::array();
    for (const Measurement& m : _measurements) {
        cases.push_back({{"area", m.area},
                         {"case", m.name},
                         {"quantity", m.quantity},
                         {"unit", m.unit},
                         {"bound", m.bound == Bound::atMost ? "at most" : "at least"},
                         {"limit", number(m.limit)},
                         {"measured", number(m.measured)},
                         {"passes", m.passes()}});
    }
    const Json json{{"passes", passes()},
                    {"measured", _measurements.size()},
                    {"failed", failures()},
                    {"target", target},
                    {"cases", std::move(cases)}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace ig::selftest
