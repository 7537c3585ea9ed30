// SPDX-License-Identifier: MIT
#include "tools/terrain/raster_source.h"

#include "ig/data/hierarchy.h"
#include "tools/terrain/voids.h"
#include "tools/terrain/warp_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

namespace ig::terrain {

namespace {

constexpr uint32_t kStripRows = 64;

// Metres per unit; 0 for a unit that is none of length.
double metresPer(std::string_view unit)
{
    struct Named {
        std::string_view name;
        double metres;
    };
    // Foot of 1959 and US survey foot (NIST SP 811, app. B).
    constexpr std::array<Named, 17> kUnits{{{"", 1},
                                            {"m", 1},
                                            {"metre", 1},
                                            {"meter", 1},
                                            {"metres", 1},
                                            {"meters", 1},
                                            {"unknown", 1},
                                            {"dm", 0.1},
                                            {"cm", 0.01},
                                            {"mm", 0.001},
                                            {"km", 1000},
                                            {"ft", 0.3048},
                                            {"foot", 0.3048},
                                            {"feet", 0.3048},
                                            {"us-ft", 1200.0 / 3937.0},
                                            {"US survey foot", 1200.0 / 3937.0},
                                            {"sfoot", 1200.0 / 3937.0}}};
    for (const Named& unit_ : kUnits)
        if (EQUAL(std::string(unit).c_str(), std::string(unit_.name).c_str()))
            return unit_.metres;
    return 0;
}

std::string verticalDatumOf(GDALDataset& raster, const OGRSpatialReference& system)
{
    if (const char* name = system.GetAttrValue("VERT_CS"); name != nullptr)
        return name;
    if (const char* name = raster.GetMetadataItem("DTED_VerticalDatum"); name != nullptr)
        return name;
    return "unknown";
}

std::string namesOf(const std::vector<std::string>& files)
{
    std::string names;
    for (const std::string& file : files)
        names += (names.empty() ? "" : ", ") + std::string(CPLGetFilename(file.c_str()));
    return names;
}

} // namespace

RasterSource::RasterSource(RasterInputs inputs, GdalSession& gdal) : _gdal(&gdal), _inputs(std::move(inputs))
{
}

Result<RasterSource> RasterSource::open(const RasterOptions& options, GdalSession& gdal)
{
    Result<RasterInputs> inputs = openInputs(options, gdal);
    if (!inputs)
        return Unexpected{inputs.error()};
    RasterSource source(std::move(*inputs), gdal);
    if (Result<void> done = source.readUnits(options); !done)
        return Unexpected{done.error()};
    GDALDataset& raster = *source._inputs.mosaic;
    OGRSpatialReference system(*raster.GetSpatialRef());
    source._place.verticalDatum = verticalDatumOf(raster, system);
    source._place.source = namesOf(options.files);
    system.StripVertical();
    system.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (Result<void> done = source.locate(system); !done)
        return Unexpected{done.error()};
    return source;
}

Result<void> RasterSource::readUnits(const RasterOptions& options)
{
    GDALRasterBand* band = _inputs.mosaic->GetRasterBand(1);
    const GDALDataType type = band->GetRasterDataType();
    _isInteger = GDALDataTypeIsInteger(type) != 0;
    _isFloat32 = type == GDT_Float32;
    int has = 0;
    _voidValue = band->GetNoDataValue(&has);
    _hasVoidValue = has != 0;
    // The lowest 16-bit number is no height, said or not.
    if (!_hasVoidValue && type == GDT_Int16) {
        _hasVoidValue = true;
        _voidValue = kVoidPost;
    }
    const double unit = metresPer(band->GetUnitType());
    if (unit == 0 && !options.scale)
        return fail(ErrorKind::usage, std::string("heights in \"") + band->GetUnitType() +
                                          "\"; give --scale, the metres of one unit");
    _place.heightScaleM = options.scale ? *options.scale : band->GetScale() * unit;
    _place.heightOffsetM = options.offset ? *options.offset : band->GetOffset() * unit;
    if (!(_place.heightScaleM >= 1e-6 && _place.heightScaleM <= 1e6) ||
        !(std::abs(_place.heightOffsetM) <= 1e8))
        return fail(ErrorKind::usage,
                    "height scale or offset out of range; scale 0.000001 to 1000000 metres");
    return {};
}

Result<void> RasterSource::locate(const OGRSpatialReference& system)
{
    GDALDataset& raster = *_inputs.mosaic;
    if (const std::optional<GeoGrid> grid = exactGrid(raster, system)) {
        _place.ellipsoid = grid->ellipsoid;
        _place.northDeg = grid->northDeg;
        _place.westDeg = grid->westDeg;
        _place.latitudeStepDeg = grid->latitudeStepDeg;
        _place.longitudeStepDeg = grid->longitudeStepDeg;
        _cols = static_cast<uint32_t>(raster.GetRasterXSize());
        _rows = static_cast<uint32_t>(raster.GetRasterYSize());
        return {};
    }
    return warp(system);
}

Result<void> RasterSource::warp(const OGRSpatialReference& from)
{
    GDALDataset& raster = *_inputs.mosaic;
    _gdal->forget();
    const std::optional<WarpGrid> target = warpGrid(raster, from);
    if (!target)
        return fail(ErrorKind::usage, "cannot bring the raster to latitudes and longitudes: " +
                                          _gdal->complaint("its coordinate system does not cover it"));
    if (target->cols > data::kMaxGridPosts || target->rows > data::kMaxGridPosts)
        return fail(ErrorKind::usage, "the warped grid would have more posts than a dataset can hold");
    std::vector<std::string> words{"-of",
                                   "VRT",
                                   "-r",
                                   "bilinear",
                                   "-ot",
                                   "Float32",
                                   "-wt",
                                   "Float32",
                                   "-multi",
                                   "-wo",
                                   "NUM_THREADS=ALL_CPUS",
                                   "-dstnodata",
                                   "nan",
                                   "-s_srs",
                                   wktOf(from),
                                   "-t_srs",
                                   target->wkt,
                                   "-te"};
    const GeoGrid& grid = target->grid;
    const double west = grid.westDeg - grid.longitudeStepDeg / 2;
    const double north = grid.northDeg + grid.latitudeStepDeg / 2;
    const double east = west + target->cols * grid.longitudeStepDeg;
    const double south = north - target->rows * grid.latitudeStepDeg;
    for (const double edge : {west, south, east, north})
        words.emplace_back(CPLSPrintf("%.17g", edge));
    words.insert(words.end(), {"-ts", std::to_string(target->cols), std::to_string(target->rows)});
    if (_hasVoidValue)
        words.insert(words.end(), {"-srcnodata", CPLSPrintf("%.17g", _voidValue)});
    CPLStringList list = arguments(words);
    GDALWarpAppOptions* options = GDALWarpAppOptionsNew(list.List(), nullptr);
    GDALDatasetH sources[1] = {GDALDataset::ToHandle(&raster)};
    if (options != nullptr)
        _warped.reset(GDALDataset::FromHandle(GDALWarp("", nullptr, 1, sources, options, nullptr)));
    GDALWarpAppOptionsFree(options);
    if (!_warped)
        return fail(ErrorKind::failed,
                    "cannot warp the raster: " + _gdal->complaint("GDAL does not say why"));
    _place.ellipsoid = grid.ellipsoid;
    _place.northDeg = grid.northDeg;
    _place.westDeg = grid.westDeg;
    _place.latitudeStepDeg = grid.latitudeStepDeg;
    _place.longitudeStepDeg = grid.longitudeStepDeg;
    _cols = target->cols;
    _rows = target->rows;
    return {};
}

bool RasterSource::isVoid(double raw) const noexcept
{
    if (!std::isfinite(raw))
        return true;
    if (!_hasVoidValue)
        return false;
    return _isFloat32 ? static_cast<float>(raw) == static_cast<float>(_voidValue) : raw == _voidValue;
}

Result<void> RasterSource::read(GDALDataset& raster, uint32_t first, uint32_t count,
                                std::span<double> samples)
{
    const int width = raster.GetRasterXSize();
    _gdal->forget();
    const CPLErr outcome = raster.GetRasterBand(1)->RasterIO(
        GF_Read, 0, static_cast<int>(first), width, static_cast<int>(count), samples.data(), width,
        static_cast<int>(count), GDT_Float64, 0, 0, nullptr);
    if (outcome != CE_None)
        return fail(ErrorKind::dataset, _place.source + ": cannot read rows " + std::to_string(first) +
                                            " to " + std::to_string(first + count - 1) + ": " +
                                            _gdal->complaint("GDAL does not say why") +
                                            "; the file is damaged or cut short, fetch it again");
    for (double& sample : samples)
        if (isVoid(sample))
            sample = std::numeric_limits<double>::quiet_NaN();
    return {};
}

Result<void> RasterSource::readRows(uint32_t first, uint32_t count, std::span<double> samples)
{
    return read(_warped ? *_warped : *_inputs.mosaic, first, count, samples);
}

Result<RasterSource::Range> RasterSource::range(const Monitor& monitor)
{
    GDALDataset& raster = *_inputs.mosaic;
    const auto rows = static_cast<uint32_t>(raster.GetRasterYSize());
    const auto cols = static_cast<size_t>(raster.GetRasterXSize());
    std::vector<double> strip(cols * kStripRows);
    Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (uint32_t first = 0; first < rows; first += kStripRows) {
        if (monitor.isCancelled())
            return interrupted();
        const uint32_t count = std::min(kStripRows, rows - first);
        const auto samples = std::span(strip).first(cols * count);
        if (Result<void> done = read(raster, first, count, samples); !done)
            return Unexpected{done.error()};
        for (const double sample : samples) {
            if (std::isnan(sample)) {
                range.hasVoids = true;
                continue;
            }
            range.low = std::min(range.low, sample);
            range.high = std::max(range.high, sample);
        }
        monitor.report("scanning", static_cast<double>(first + count) / rows);
    }
    range.isEmpty = range.low > range.high;
    return range;
}

} // namespace ig::terrain
