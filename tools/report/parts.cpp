// SPDX-License-Identifier: MIT
#include "tools/report/parts.h"

#include "ig/app/output_files.h"
#include "tools/report/compare.h"

namespace report {

Json Parts::keyOf(const Json& alsoWith) const
{
    Json key = _key;
    if (!alsoWith.is_null()) {
        key["also"] = alsoWith;
    }
    return key;
}

std::optional<Json> Parts::kept(const std::string& name, const Json& alsoWith) const
{
    if (!_resume) {
        return std::nullopt;
    }
    auto read = readJson(pathOf(name));
    const bool isOfTheSame = read && read->is_object() && read->contains("key") &&
                             (*read)["key"] == keyOf(alsoWith) && read->contains("measured");
    return isOfTheSame ? std::optional<Json>((*read)["measured"]) : std::nullopt;
}

ig::Result<void> Parts::keep(const std::string& name, const Json& measured, const Json& alsoWith) const
{
    return ig::app::writeFile(pathOf(name), Json{{"key", keyOf(alsoWith)}, {"measured", measured}}.dump());
}

} // namespace report
