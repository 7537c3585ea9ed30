// SPDX-License-Identifier: MIT
// synth and build: the commands that write files.
#include "ig/base/same_file.h"
#include "tools/terrain/commands.h"
#include "tools/terrain/compile.h"
#include "tools/terrain/parallel.h"
#include "tools/terrain/partial_file.h"
#include "tools/terrain/progress.h"
#include "tools/terrain/raster_import.h"
#include "tools/terrain/raster_source.h"
#include "tools/terrain/synth.h"

#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace ig::terrain {

namespace {

constexpr double kMiB = 1024.0 * 1024.0;

Monitor monitorOf(Progress& progress, const std::atomic<bool>& cancelled)
{
    return {[&progress](std::string_view stage, double share) { progress.report(stage, share); }, &cancelled};
}

// Posts of about 50 m on both axes, in the middle of the Scottish Highlands' latitudes.
constexpr double kMiddleLatitudeDeg = 57.0;
constexpr double kMiddleLongitudeDeg = -5.0;
constexpr double kLatitudeStepDeg = 1.0 / 2250;
constexpr double kLongitudeStepDeg = 1.0 / 1225;
constexpr double kPostM = 49.5;
constexpr double kDecimetre = 0.1;
constexpr uint32_t kStripRows = 64;

Result<void> writeRows(GDALDataset& raster, const SynthCommand& command, const Monitor& monitor,
                       GdalSession& gdal)
{
    const SyntheticTerrain terrain(command.seed);
    const uint32_t size = command.size;
    const double middle = (size - 1) / 2.0;
    std::vector<int16_t> strip(size_t{size} * kStripRows);
    for (uint32_t first = 0; first < size; first += kStripRows) {
        if (monitor.isCancelled())
            return interrupted();
        const uint32_t count = std::min(kStripRows, size - first);
        parallelFor(count, [&](size_t r, unsigned) {
            for (uint32_t c = 0; c < size; ++c) {
                const double heightM = terrain.heightM((c - middle) * kPostM,
                                                       (middle - static_cast<double>(first + r)) * kPostM);
                strip[r * size + c] = static_cast<int16_t>(std::lround(heightM / kDecimetre));
            }
        });
        if (raster.GetRasterBand(1)->RasterIO(GF_Write, 0, static_cast<int>(first), static_cast<int>(size),
                                              static_cast<int>(count), strip.data(), static_cast<int>(size),
                                              static_cast<int>(count), GDT_Int16, 0, 0, nullptr) != CE_None)
            return fail(ErrorKind::failed,
                        command.output + ": cannot write: " + gdal.complaint("disk full?"));
        monitor.report("synthesising", static_cast<double>(first + count) / size);
    }
    return {};
}

Result<RasterPtr> createTiff(const std::string& path, uint32_t size, const GdalSession& gdal)
{
    const CPLStringList options =
        arguments({"COMPRESS=DEFLATE", "PREDICTOR=2", "TILED=YES", "NUM_THREADS=ALL_CPUS"});
    const int width = static_cast<int>(size);
    RasterPtr raster(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(path.c_str(), width, width, 1,
                                                                              GDT_Int16, options.List()));
    if (!raster)
        return fail(ErrorKind::failed, path + ": cannot write: " + gdal.complaint("GDAL does not say why"));
    OGRSpatialReference wgs84;
    wgs84.importFromEPSG(4326);
    raster->SetSpatialRef(&wgs84);
    std::array<double, 6> transform{kMiddleLongitudeDeg - size / 2.0 * kLongitudeStepDeg,
                                    kLongitudeStepDeg,
                                    0,
                                    kMiddleLatitudeDeg + size / 2.0 * kLatitudeStepDeg,
                                    0,
                                    -kLatitudeStepDeg};
    raster->SetGeoTransform(transform.data());
    raster->GetRasterBand(1)->SetScale(kDecimetre);
    raster->GetRasterBand(1)->SetUnitType("m");
    return raster;
}

uint64_t fileBytes(const std::string& path)
{
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 ? static_cast<uint64_t>(status.st_size) : 0;
}

} // namespace

Result<int> runSynth(const SynthCommand& command, const std::atomic<bool>& cancelled)
{
    Progress progress(command.quiet);
    const Monitor monitor = monitorOf(progress, cancelled);
    GdalSession gdal;
    Result<PartialFile> file = PartialFile::create(command.output);
    if (!file)
        return Unexpected{file.error()};
    Result<RasterPtr> raster = createTiff(file->partialPath(), command.size, gdal);
    if (!raster)
        return Unexpected{raster.error()};
    if (Result<void> done = writeRows(**raster, command, monitor, gdal); !done)
        return Unexpected{done.error()};
    gdal.forget();
    raster->reset(); // flushes
    if (gdal.hasWarned())
        return fail(ErrorKind::failed, command.output + ": cannot write: " + gdal.complaint(""));
    if (Result<void> done = file->commit(); !done)
        return Unexpected{done.error()};
    return 0;
}

Result<int> runBuild(const BuildCommand& command, const std::atomic<bool>& cancelled)
{
    for (const std::string& input : command.rasters.files)
        if (sameFile(input, command.output))
            return fail(ErrorKind::usage, input + ": both input and output; give another output name");
    if (Result<void> fit = checkTarget(command.output); !fit) // not after minutes of work
        return Unexpected{fit.error()};
    Progress progress(command.quiet);
    const Monitor monitor = monitorOf(progress, cancelled);
    GdalSession gdal;
    Result<RasterSource> source = RasterSource::open(command.rasters, gdal);
    if (!source)
        return Unexpected{source.error()};
    Result<ImportedGrid> import = importRaster(*source, command.voids, folderOf(command.output), monitor);
    if (!import)
        return Unexpected{import.error()};
    if (Result<void> done =
            compileGrid(import->grid, import->holeCells, import->place, command.output, monitor);
        !done)
        return Unexpected{done.error()};
    progress.finish();
    const double rawBytes = 2.0 * import->grid.cols() * import->grid.rows();
    const auto bytes = static_cast<double>(fileBytes(command.output));
    std::printf("%s: %u x %u posts%s, %.1f MiB, %.3f of the raw 16-bit grid\n", command.output.c_str(),
                import->grid.cols(), import->grid.rows(), source->isResampled() ? ", resampled" : "",
                bytes / kMiB, bytes / rawBytes);
    return 0;
}

} // namespace ig::terrain
