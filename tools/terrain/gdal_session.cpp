// SPDX-License-Identifier: MIT
#include "tools/terrain/gdal_session.h"

#include <algorithm>

namespace ig::terrain {

GdalSession::GdalSession()
{
    GDALAllRegister();
    // GDAL would take 5 % of the machine's memory; strips of the widest grids fit in this.
    GDALSetCacheMax64(GIntBig{96} << 20);
    CPLPushErrorHandlerEx(listen, this);
}

GdalSession::~GdalSession()
{
    CPLPopErrorHandler();
}

void GdalSession::listen(CPLErr level, CPLErrorNum, const char* text)
{
    if (level < CE_Warning)
        return;
    auto* session = static_cast<GdalSession*>(CPLGetErrorHandlerUserData());
    session->_complaint = text;
    std::replace(session->_complaint.begin(), session->_complaint.end(), '\n', ' ');
    if (session->_complaint.ends_with('.')) // more may follow in the same line
        session->_complaint.pop_back();
}

std::string GdalSession::complaint(const std::string& otherwise) const
{
    return _complaint.empty() ? otherwise : _complaint;
}

} // namespace ig::terrain
