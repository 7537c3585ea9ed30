// SPDX-License-Identifier: MIT
// What a report has measured so far, kept in files so that an interrupted run can go on (--resume).
#pragma once

#include "ig/base/result.h"
#include "tools/report/records.h"

#include <optional>
#include <string>
#include <utility>

namespace report {

class Parts {
public:
    // directory: there. resume: take what is there and was measured alike; else all is measured again. key:
    // what all parts were measured with, an object.
    Parts(std::string directory, bool resume, Json key)
        : _directory(std::move(directory)), _resume(resume), _key(std::move(key))
    {
    }

    // What is kept under a name good for a file, if it was measured with the same key and alsoWith.
    std::optional<Json> kept(const std::string& name, const Json& alsoWith = {}) const;
    // Errors (failed): it cannot be written.
    ig::Result<void> keep(const std::string& name, const Json& measured, const Json& alsoWith = {}) const;

    const std::string& directory() const noexcept { return _directory; }

private:
    std::string pathOf(const std::string& name) const { return _directory + '/' + name + ".json"; }
    Json keyOf(const Json& alsoWith) const;

    std::string _directory;
    bool _resume;
    Json _key;
};

} // namespace report
