// SPDX-License-Identifier: MIT
// GDAL as this tool uses it: registered once, silent, with its last complaint at hand. This header keeps
// GDAL's own headers, which our warnings do not fit, out of the way of ours.
#pragma once

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_alg.h>
#include <gdal_priv.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>
#pragma GCC diagnostic pop

#include <memory>
#include <string>
#include <vector>

namespace ig::terrain {

using RasterPtr = GDALDatasetUniquePtr;

// While it lives, GDAL's messages are kept instead of printed. One at a time, on one thread.
class GdalSession {
public:
    GdalSession();
    ~GdalSession();
    GdalSession(const GdalSession&) = delete;
    GdalSession& operator=(const GdalSession&) = delete;

    // The last error or warning as one line, or otherwise.
    std::string complaint(const std::string& otherwise) const;
    void forget() { _complaint.clear(); }
    bool hasWarned() const { return !_complaint.empty(); }

private:
    static void listen(CPLErr level, CPLErrorNum number, const char* text);
    std::string _complaint;
};

// Arguments as GDAL's utilities take them.
inline CPLStringList arguments(const std::vector<std::string>& words)
{
    CPLStringList list;
    for (const std::string& word : words)
        list.AddString(word.c_str());
    return list;
}

} // namespace ig::terrain
