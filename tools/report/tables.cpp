// SPDX-License-Identifier: MIT
#include "tools/report/tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

namespace report {

namespace {

std::string cellOf(const Json& value)
{
    if (value.is_number_float()) {
        return fmt::format("{:.6g}", value.get<double>());
    }
    if (!value.is_string()) {
        return value.is_null() ? std::string() : value.dump();
    }
    const auto text = value.get<std::string>();
    return text.find(',') == std::string::npos ? text : '"' + text + '"';
}

// Columns in the order in which the rows bring them; empty where a row has none.
std::string csvOfRows(const Json& rows)
{
    std::vector<std::string> names;
    for (const Json& row : rows) {
        for (const auto& [name, value] : row.items()) {
            if (std::find(names.begin(), names.end(), name) == names.end()) {
                names.push_back(name);
            }
        }
    }
    std::string csv = fmt::format("{}\n", fmt::join(names, ","));
    for (const Json& row : rows) {
        std::string separator;
        for (const std::string& name : names) {
            csv += separator + (row.contains(name) ? cellOf(row[name]) : std::string());
            separator = ",";
        }
        csv += '\n';
    }
    return csv;
}

// What lies in objects as "outer.inner"; what lies in lists is left out.
void flatten(const Json& object, const std::string& prefix, Json& row)
{
    for (const auto& [name, value] : object.items()) {
        if (value.is_object()) {
            flatten(value, prefix + name + '.', row);
        } else if (!value.is_array()) {
            row[prefix + name] = value;
        }
    }
}

} // namespace

std::string numberText(const Json& value)
{
    if (!value.is_number()) {
        return "-";
    }
    const auto plain = value.get<double>();
    return plain >= 1000 && plain < 1e6 ? fmt::format("{:.0f}", plain) : fmt::format("{:.3g}", plain);
}

std::string settingsCsv(const Json& settings)
{
    Json rows = Json::array();
    for (const Json& setting : settings) {
        Json row = Json::object();
        flatten(setting, {}, row);
        rows.push_back(std::move(row));
    }
    return csvOfRows(rows);
}

std::string scalingCsv(const Json& axes)
{
    Json rows = Json::array();
    for (const Json& axis : axes) {
        for (const Json& place : axis["places"]) {
            Json row{{"axis", axis["axis"]}};
            row.update(place);
            flatten(axis, {}, row); // the slopes
            rows.push_back(std::move(row));
        }
    }
    return csvOfRows(rows);
}

std::string motionCsv(const Json& motion)
{
    return csvOfRows(motion["rows"]);
}

std::string scalingText(const Json& axes)
{
    std::string text;
    for (const Json& axis : axes) {
        const Json& places = axis["places"];
        if (places.empty()) {
            continue;
        }
        const auto part = [&](const char* what, const char* cost, const char* exponent, const char* perUnit) {
            return fmt::format("{} {} - {} ms, exponent {}, {} ms per unit", what,
                               numberText(places.front()[cost]), numberText(places.back()[cost]),
                               numberText(axis[exponent]), numberText(axis[perUnit]));
        };
        text += fmt::format("scaling     {} {} - {}: {}; {}\n", axis["axis"].get<std::string>(),
                            numberText(places.front()["value"]), numberText(places.back()["value"]),
                            part("frame", "total_ms_p50", "total_exponent", "total_ms_per_unit"),
                            part("selection", "select_ms_p50", "select_exponent", "select_ms_per_unit"));
    }
    return text;
}

} // namespace report
