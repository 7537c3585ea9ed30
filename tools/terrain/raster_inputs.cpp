// SPDX-License-Identifier: MIT
#include "tools/terrain/raster_inputs.h"

#include "ig/base/system_error.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>

namespace ig::terrain {

namespace {

bool endsWith(std::string_view text, std::string_view end)
{
    return text.size() >= end.size() &&
           EQUALN(text.data() + text.size() - end.size(), end.data(), end.size());
}

RasterPtr openRaster(const std::string& name)
{
    return RasterPtr(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
}

// The first raster in a zip archive: SRTM tiles come as one file each.
RasterPtr openZipped(const std::string& file)
{
    const std::string archive = "/vsizip/{" + file + "}";
    const CPLStringList entries(VSIReadDirRecursive(archive.c_str()), TRUE);
    for (int i = 0; i < entries.Count(); ++i)
        if (RasterPtr raster = openRaster(archive + "/" + entries[i]))
            return raster;
    return nullptr;
}

Result<void> checkBand(const std::string& file, GDALDataset& raster)
{
    const int bands = raster.GetRasterCount();
    if (bands == 0)
        return fail(ErrorKind::dataset, file + ": holds no raster band; give an elevation raster");
    GDALRasterBand* band = raster.GetRasterBand(1);
    const GDALColorInterp meaning = band->GetColorInterpretation();
    if (bands > 1 || meaning == GCI_PaletteIndex || meaning == GCI_RedBand)
        return fail(ErrorKind::dataset, file + ": " + std::to_string(bands) +
                                            (bands > 1 ? " bands, a picture rather than heights"
                                                       : " band of colours rather than heights") +
                                            "; give a raster with one band of elevations");
    if (GDALDataTypeIsComplex(band->GetRasterDataType()) != 0)
        return fail(ErrorKind::dataset,
                    file + ": complex numbers; give a raster with one band of elevations");
    return {};
}

bool hasPlace(GDALDataset& raster)
{
    std::array<double, 6> transform{};
    return raster.GetGeoTransform(transform.data()) == CE_None;
}

// The raster with the extent and coordinate system of the options put on, if it needs them.
Result<RasterPtr> placed(RasterPtr raster, const std::string& file, const RasterOptions& options,
                         std::vector<RasterPtr>& parts, const GdalSession& gdal)
{
    const bool hasCrs = raster->GetSpatialRef() != nullptr && !raster->GetSpatialRef()->IsLocal();
    if (!options.extent && !hasPlace(*raster))
        return fail(
            ErrorKind::usage,
            file +
                ": does not say where it lies; give --extent W,S,E,N (outer cell edges) and --crs EPSG:code");
    if (options.crs.empty() && !hasCrs)
        return fail(ErrorKind::usage,
                    file + ": states no coordinate system; give --crs, for example --crs EPSG:4326");
    if (!options.extent && options.crs.empty())
        return raster;
    std::vector<std::string> words{"-of", "VRT"};
    if (!options.crs.empty())
        words.insert(words.end(), {"-a_srs", options.crs});
    if (options.extent) {
        const auto [west, south, east, north] = *options.extent;
        words.emplace_back("-a_ullr");
        for (const double edge : {west, north, east, south})
            words.emplace_back(CPLSPrintf("%.17g", edge));
    }
    CPLStringList list = arguments(words);
    GDALTranslateOptions* translate = GDALTranslateOptionsNew(list.List(), nullptr);
    RasterPtr out;
    if (translate != nullptr)
        out.reset(GDALDataset::FromHandle(
            GDALTranslate("", GDALDataset::ToHandle(raster.get()), translate, nullptr)));
    GDALTranslateOptionsFree(translate);
    if (!out || out->GetSpatialRef() == nullptr)
        return fail(ErrorKind::usage,
                    "--crs " + options.crs + ": " + gdal.complaint("not a coordinate system"));
    parts.push_back(std::move(raster));
    return out;
}

Result<void> checkAlike(GDALDataset& first, GDALDataset& other, const std::string& file)
{
    if (first.GetSpatialRef()->IsSame(other.GetSpatialRef()) == 0)
        return fail(
            ErrorKind::usage,
            file +
                ": another coordinate system than the first raster's; bring them to one with gdalwarp first");
    GDALRasterBand* a = first.GetRasterBand(1);
    GDALRasterBand* b = other.GetRasterBand(1);
    if (a->GetScale() != b->GetScale() || a->GetOffset() != b->GetOffset() ||
        std::string_view(a->GetUnitType()) != b->GetUnitType())
        return fail(ErrorKind::usage,
                    file + ": another height scale, offset or unit than the first raster's");
    return {};
}

Result<RasterPtr> mosaicOf(std::vector<RasterPtr>& parts, GdalSession& gdal)
{
    std::vector<GDALDatasetH> handles;
    for (const RasterPtr& part : parts)
        handles.push_back(GDALDataset::ToHandle(part.get()));
    CPLStringList list = arguments({"-resolution", "highest", "-r", "bilinear", "-strict"});
    GDALBuildVRTOptions* build = GDALBuildVRTOptionsNew(list.List(), nullptr);
    gdal.forget();
    RasterPtr out(GDALDataset::FromHandle(
        GDALBuildVRT("", static_cast<int>(handles.size()), handles.data(), nullptr, build, nullptr)));
    GDALBuildVRTOptionsFree(build);
    if (!out)
        return fail(ErrorKind::usage,
                    "cannot mosaic the rasters: " + gdal.complaint("GDAL does not say why"));
    return out;
}

} // namespace

Result<RasterInputs> openInputs(const RasterOptions& options, GdalSession& gdal)
{
    if (options.extent && options.files.size() != 1)
        return fail(ErrorKind::usage, "--extent places one raster; give one");
    RasterInputs inputs;
    std::vector<RasterPtr> rasters;
    for (const std::string& file : options.files) {
        gdal.forget();
        RasterPtr raster = endsWith(file, ".zip") ? openZipped(file) : openRaster(file);
        if (!raster) {
            // GDAL takes more than paths (a layer within a file), so whether one exists is asked last.
            std::error_code ignored;
            const bool exists = std::filesystem::exists(file, ignored);
            return fail(
                ErrorKind::dataset,
                file + ": cannot read: " +
                    gdal.complaint(exists ? "no raster in it that GDAL knows; give one that gdalinfo opens"
                                          : systemError(ENOENT)));
        }
        if (Result<void> fine = checkBand(file, *raster); !fine)
            return Unexpected{fine.error()};
        Result<RasterPtr> out = placed(std::move(raster), file, options, inputs.parts, gdal);
        if (!out)
            return Unexpected{out.error()};
        rasters.push_back(std::move(*out));
        if (Result<void> fine = checkAlike(*rasters.front(), *rasters.back(), file); !fine)
            return Unexpected{fine.error()};
    }
    if (rasters.size() == 1) {
        inputs.mosaic = std::move(rasters.front());
        return inputs;
    }
    for (RasterPtr& raster : rasters)
        inputs.parts.push_back(std::move(raster));
    std::vector<RasterPtr>& parts = inputs.parts;
    Result<RasterPtr> mosaic = mosaicOf(parts, gdal);
    if (!mosaic)
        return Unexpected{mosaic.error()};
    inputs.mosaic = std::move(*mosaic);
    return inputs;
}

} // namespace ig::terrain
