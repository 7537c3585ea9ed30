// SPDX-License-Identifier: MIT
#include "tools/terrain/warp_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

namespace ig::terrain {

namespace {

Ellipsoid ellipsoidOf(const OGRSpatialReference& system)
{
    const double inverse = system.GetInvFlattening();
    return {system.GetSemiMajor(), inverse > 0 ? 1.0 / inverse : 0.0};
}

bool isOnEarth(const Ellipsoid& ellipsoid)
{
    return std::abs(ellipsoid.semiMajorM / kWgs84.semiMajorM - 1) < 0.01;
}

// The host speaks WGS 84: another ellipsoid of the Earth would put it a hundred metres off.
bool isUsable(const Ellipsoid& ellipsoid)
{
    return !isOnEarth(ellipsoid) || (std::abs(ellipsoid.semiMajorM - kWgs84.semiMajorM) < 1.0 &&
                                     std::abs(ellipsoid.flattening - kWgs84.flattening) < 1e-8);
}

bool isInDegrees(const OGRSpatialReference& system)
{
    return system.IsGeographic() != 0 && system.IsDerivedGeographic() == 0 &&
           system.GetPrimeMeridian() == 0 && std::abs(system.GetAngularUnits() - kRadPerDeg) < 1e-12;
}

// Degrees of longitude and latitude from map units, where both are proportional.
struct DegreesFrom {
    double perX = 1, perY = 1, x0 = 0, y0 = 0; // lon = x0 + x * perX
};

std::optional<DegreesFrom> equirectangular(const OGRSpatialReference& system, const Ellipsoid& ellipsoid)
{
    const char* projection = system.GetAttrValue("PROJECTION");
    if (projection == nullptr || !EQUAL(projection, SRS_PT_EQUIRECTANGULAR) || ellipsoid.flattening != 0 ||
        system.GetPrimeMeridian() != 0 || system.GetNormProjParm(SRS_PP_LATITUDE_OF_ORIGIN, 0.0) != 0)
        return std::nullopt;
    const double parallel = system.GetNormProjParm(SRS_PP_STANDARD_PARALLEL_1, 0.0) * kRadPerDeg;
    const double unit = system.GetLinearUnits() / ellipsoid.semiMajorM * kDegPerRad;
    DegreesFrom out;
    out.perX = unit / std::cos(parallel);
    out.perY = unit;
    out.x0 = system.GetNormProjParm(SRS_PP_CENTRAL_MERIDIAN, 0.0) -
             system.GetProjParm(SRS_PP_FALSE_EASTING, 0.0) * out.perX;
    out.y0 = -system.GetProjParm(SRS_PP_FALSE_NORTHING, 0.0) * out.perY;
    return out;
}

} // namespace

std::string wktOf(const OGRSpatialReference& system)
{
    char* text = nullptr;
    const char* const options[] = {"FORMAT=WKT2_2018", nullptr};
    system.exportToWkt(&text, options);
    std::string out = text != nullptr ? text : "";
    CPLFree(text);
    return out;
}

std::optional<GeoGrid> exactGrid(GDALDataset& raster, const OGRSpatialReference& system)
{
    std::array<double, 6> t{};
    raster.GetGeoTransform(t.data());
    const Ellipsoid ellipsoid = ellipsoidOf(system);
    if (t[2] != 0 || t[4] != 0 || !(t[1] > 0) || !(t[5] < 0) || !isUsable(ellipsoid))
        return std::nullopt;
    DegreesFrom degrees;
    if (!isInDegrees(system)) {
        const std::optional<DegreesFrom> from = equirectangular(system, ellipsoid);
        if (!from)
            return std::nullopt;
        degrees = *from;
    }
    GeoGrid grid;
    grid.ellipsoid = ellipsoid;
    grid.longitudeStepDeg = t[1] * degrees.perX;
    grid.latitudeStepDeg = -t[5] * degrees.perY;
    grid.westDeg = degrees.x0 + (t[0] + 0.5 * t[1]) * degrees.perX;
    grid.northDeg = degrees.y0 + (t[3] + 0.5 * t[5]) * degrees.perY;
    return grid;
}

namespace {

struct Transformer {
    void operator()(void* transformer) const { GDALDestroyGenImgProjTransformer(transformer); }
};
using TransformerPtr = std::unique_ptr<void, Transformer>;

// Smallest degrees between neighbouring samples over a net of places: on each axis the larger of the steps
// along a row and along a column, which for a turned raster is what still keeps every sample apart.
void findSteps(GDALDataset& raster, void* transformer, GeoGrid& grid)
{
    constexpr int kNet = 24;
    double lonStep = std::numeric_limits<double>::infinity();
    double latStep = lonStep;
    for (int j = 0; j <= kNet; ++j)
        for (int i = 0; i <= kNet; ++i) {
            const double px = 0.5 + i * (raster.GetRasterXSize() - 2.0) / kNet;
            const double py = 0.5 + j * (raster.GetRasterYSize() - 2.0) / kNet;
            std::array<double, 3> x{px, px + 1, px};
            std::array<double, 3> y{py, py, py + 1};
            std::array<double, 3> z{};
            std::array<int, 3> fine{};
            GDALGenImgProjTransform(transformer, FALSE, 3, x.data(), y.data(), z.data(), fine.data());
            if (fine[0] == 0 || fine[1] == 0 || fine[2] == 0)
                continue;
            const auto lonBetween = [&](size_t a) { return std::abs(std::remainder(x[a] - x[0], 360.0)); };
            lonStep = std::min(lonStep, std::max(lonBetween(1), lonBetween(2)));
            latStep = std::min(latStep, std::max(std::abs(y[1] - y[0]), std::abs(y[2] - y[0])));
        }
    grid.longitudeStepDeg = lonStep;
    grid.latitudeStepDeg = latStep;
}

} // namespace

std::optional<WarpGrid> warpGrid(GDALDataset& raster, const OGRSpatialReference& system)
{
    OGRSpatialReference target;
    const Ellipsoid body = ellipsoidOf(system);
    if (isOnEarth(body))
        target.importFromEPSG(4326);
    else {
        const std::unique_ptr<OGRSpatialReference> own(system.CloneGeogCS());
        if (!own)
            return std::nullopt;
        target = *own;
    }
    target.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);

    WarpGrid out;
    out.wkt = wktOf(target);
    out.grid.ellipsoid = ellipsoidOf(target);
    CPLStringList options;
    options.SetNameValue("SRC_SRS", wktOf(system).c_str());
    options.SetNameValue("DST_SRS", out.wkt.c_str());
    const TransformerPtr transformer(
        GDALCreateGenImgProjTransformer2(GDALDataset::ToHandle(&raster), nullptr, options.List()));
    if (!transformer)
        return std::nullopt;
    std::array<double, 6> suggested{};
    std::array<double, 4> extent{}; // west, south, east, north
    int width = 0;
    int height = 0;
    if (GDALSuggestedWarpOutput2(GDALDataset::ToHandle(&raster), GDALGenImgProjTransform, transformer.get(),
                                 suggested.data(), &width, &height, extent.data(), 0) != CE_None)
        return std::nullopt;
    findSteps(raster, transformer.get(), out.grid);
    GeoGrid& grid = out.grid;
    if (!(grid.longitudeStepDeg > 0) || !(grid.latitudeStepDeg > 0) || !std::isfinite(grid.longitudeStepDeg))
        return std::nullopt;
    const double north = std::min(extent[3], 90.0);
    const double south = std::max(extent[1], -90.0);
    const double cols = std::ceil(std::min(extent[2] - extent[0], 360.0) / grid.longitudeStepDeg - 1e-6);
    const double rows = std::ceil((north - south) / grid.latitudeStepDeg - 1e-6);
    if (!(cols >= 1) || !(rows >= 1) || !(cols < 1e9) || !(rows < 1e9))
        return std::nullopt;
    out.cols = std::max(2U, static_cast<uint32_t>(cols));
    out.rows = std::max(2U, static_cast<uint32_t>(rows));
    grid.westDeg = extent[0] + grid.longitudeStepDeg / 2;
    grid.northDeg = north - grid.latitudeStepDeg / 2;
    return out;
}

} // namespace ig::terrain
