// SPDX-License-Identifier: MIT
// From rasters to datasets, through GDAL and through the program.
#include "flown_ground.h"
#include "process.h"
#include "real_ground.h"
#include "temp_dir.h"
#include "terrain_files.h"
#include "tools/terrain/gdal_session.h"
#include "tools/terrain/partial_file.h"
#include "tools/terrain/raster_import.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <limits>

using namespace ig;

namespace {

using terrain::VoidRule;
using Heights = std::function<double(int col, int row)>;

// A raster to make: place of the outer corner and cell size in its coordinate system.
struct Made {
    int cols = 8, rows = 6;
    GDALDataType type = GDT_Int16;
    int epsg = 4326;
    double west = 10, north = 50, cellX = 0.01, cellY = 0.01;
    int bands = 1;
    std::optional<double> noData, scale, offset;
    const char* driver = "GTiff";
};

void makeRaster(const std::string& path, const Made& made, const Heights& height)
{
    GDALAllRegister();
    terrain::RasterPtr raster(
        GetGDALDriverManager()
            ->GetDriverByName(made.driver)
            ->Create(path.c_str(), made.cols, made.rows, made.bands, made.type, nullptr));
    REQUIRE(raster);
    if (made.epsg != 0) {
        OGRSpatialReference system;
        system.importFromEPSG(made.epsg);
        raster->SetSpatialRef(&system);
        std::array<double, 6> transform{made.west, made.cellX, 0, made.north, 0, -made.cellY};
        raster->SetGeoTransform(transform.data());
    }
    std::vector<double> row(static_cast<size_t>(made.cols));
    for (int band = 1; band <= made.bands; ++band) {
        if (made.noData)
            raster->GetRasterBand(band)->SetNoDataValue(*made.noData);
        if (made.scale)
            raster->GetRasterBand(band)->SetScale(*made.scale);
        if (made.offset)
            raster->GetRasterBand(band)->SetOffset(*made.offset);
        for (int r = 0; r < made.rows; ++r) {
            for (int c = 0; c < made.cols; ++c)
                row[static_cast<size_t>(c)] = height(c, r);
            REQUIRE(raster->GetRasterBand(band)->RasterIO(GF_Write, 0, r, made.cols, 1, row.data(), made.cols,
                                                          1, GDT_Float64, 0, 0, nullptr) == CE_None);
        }
    }
}

Result<void> build(const terrain::RasterOptions& options, const std::string& out,
                   VoidRule rule = VoidRule::sea)
{
    terrain::GdalSession gdal;
    Result<terrain::RasterSource> source = terrain::RasterSource::open(options, gdal);
    if (!source)
        return Unexpected{source.error()};
    const terrain::Monitor monitor;
    Result<terrain::ImportedGrid> import =
        terrain::importRaster(*source, rule, terrain::folderOf(out), monitor);
    if (!import)
        return Unexpected{import.error()};
    return terrain::compileGrid(import->grid, import->holeCells, import->place, out, monitor);
}

data::Dataset built(const terrain::RasterOptions& options, const test::TempDir& dir,
                    VoidRule rule = VoidRule::sea)
{
    const Result<void> done = build(options, dir.file("out.ept"), rule);
    INFO((done ? "" : done.error().message));
    REQUIRE(done);
    Result<data::Dataset> dataset = data::Dataset::open(dir.file("out.ept"));
    REQUIRE(dataset);
    return std::move(*dataset);
}

terrain::RasterOptions of(std::vector<std::string> files)
{
    terrain::RasterOptions options;
    options.files = std::move(files);
    return options;
}

// Largest difference (m) of the dataset's posts from height(col, row); infinite if the sizes differ.
double difference(const data::Dataset& dataset, uint32_t cols, uint32_t rows, const Heights& height)
{
    if (dataset.info().shape.cols != cols || dataset.info().shape.rows != rows)
        return std::numeric_limits<double>::infinity();
    const std::vector<double> grid = test::gridOf(dataset);
    double most = 0;
    for (uint32_t r = 0; r < rows; ++r)
        for (uint32_t c = 0; c < cols; ++c)
            most = std::max(most, std::abs(grid[size_t{r} * cols + c] -
                                           height(static_cast<int>(c), static_cast<int>(r))));
    return most;
}

std::string shared(const std::string& name)
{
    const char* set = std::getenv("EYEPOINT_SHARED");
    const std::string path =
        (set != nullptr ? std::string(set) : std::string(EYEPOINT_SHARED_DIR)) + "/data/" + name;
    if (std::filesystem::exists(path))
        return path;
    std::cout << "skipped: " << path << " is not there\n";
    return {};
}

} // namespace

TEST_CASE("a geographic raster is not resampled: posts are its samples, at the centres of its cells")
{
    const test::TempDir dir;
    Made made;
    const auto height = [](int c, int r) { return 100 * c - 37 * r; };
    makeRaster(dir.file("a.tif"), made, height);
    const data::Dataset dataset = built(of({dir.file("a.tif")}), dir);
    CHECK(difference(dataset, 8, 6, height) == 0);
    const data::DatasetInfo& info = dataset.info();
    CHECK(info.heightScaleM == 1);
    CHECK(info.shape.northRad * kDegPerRad == Approx(50 - 0.005).epsilon(1e-14));
    CHECK(info.shape.westRad * kDegPerRad == Approx(10 + 0.005).epsilon(1e-14));
    CHECK(info.shape.longitudeStepRad * kDegPerRad == Approx(0.01).epsilon(1e-12));
    CHECK(info.shape.ellipsoid == kWgs84);
    CHECK(info.source == "a.tif");
    CHECK(info.verticalDatum == "unknown");
}

TEST_CASE("scale and offset of the raster are honoured, those of the command line win")
{
    const test::TempDir dir;
    Made made;
    made.scale = 0.1;
    made.offset = 7.0;
    makeRaster(dir.file("a.tif"), made, [](int c, int r) { return 10 * c + r; });
    CHECK(difference(built(of({dir.file("a.tif")}), dir), 8, 6,
                     [](int c, int r) { return (10 * c + r) * 0.1 + 7; }) < 1e-9);
    terrain::RasterOptions options = of({dir.file("a.tif")});
    options.scale = 0.5;
    options.offset = -3.0;
    CHECK(difference(built(options, dir), 8, 6, [](int c, int r) { return (10 * c + r) * 0.5 - 3; }) < 1e-9);
}

TEST_CASE("16-bit samples stay what they are, also unsigned ones and the lowest")
{
    const test::TempDir dir;
    Made made;
    made.type = GDT_UInt16;
    const auto high = [](int c, int r) { return c == 0 ? 65535 : 1000 * c + r; };
    makeRaster(dir.file("a.tif"), made, high);
    CHECK(difference(built(of({dir.file("a.tif")}), dir), 8, 6, high) == 0);
    made.type = GDT_Float32;
    const auto decimals = [](int c, int r) { return 0.1 * (c * 131 + r); };
    makeRaster(dir.file("b.tif"), made, decimals);
    const data::Dataset fine = built(of({dir.file("b.tif")}), dir);
    CHECK(fine.info().heightScaleM == 0.1);
    CHECK(difference(fine, 8, 6, decimals) < 1e-4);
}

TEST_CASE("heights that do not fit 16 bits in decimetres get a coarser step")
{
    const test::TempDir dir;
    Made made;
    made.type = GDT_Float32;
    const auto height = [](int c, int) { return -9000.25 + 2200.0 * c; };
    makeRaster(dir.file("a.tif"), made, height);
    const data::Dataset dataset = built(of({dir.file("a.tif")}), dir);
    CHECK(dataset.info().heightScaleM == 0.5);
    CHECK(difference(dataset, 8, 6, height) <= 0.2501);
}

TEST_CASE("one row or one column of samples makes a grid of two")
{
    const test::TempDir dir;
    Made made;
    made.rows = 1;
    makeRaster(dir.file("a.tif"), made, [](int c, int) { return c; });
    CHECK(difference(built(of({dir.file("a.tif")}), dir), 8, 2, [](int c, int) { return c; }) == 0);
    made.rows = 5;
    made.cols = 1;
    makeRaster(dir.file("b.tif"), made, [](int, int r) { return r; });
    CHECK(difference(built(of({dir.file("b.tif")}), dir), 2, 5, [](int, int r) { return r; }) == 0);
}

TEST_CASE("adjoining rasters are mosaicked without a seam, gaps are voids")
{
    const test::TempDir dir;
    const auto height = [](int c, int r) { return 10 * c + 3 * r; };
    Made made;
    makeRaster(dir.file("w.tif"), made, height);
    made.west = 10.08;
    makeRaster(dir.file("e.tif"), made, [&](int c, int r) { return height(c + 8, r); });
    CHECK(difference(built(of({dir.file("e.tif"), dir.file("w.tif")}), dir), 16, 6, height) == 0);
    made.west = 10.16;
    makeRaster(dir.file("far.tif"), made, [](int, int) { return 55; });
    CHECK(difference(built(of({dir.file("w.tif"), dir.file("far.tif")}), dir), 24, 6, [&](int c, int r) {
              return c < 8 ? height(c, r) : c < 16 ? 0 : 55;
          }) == 0);
}

TEST_CASE("rasters that do not belong together are refused")
{
    const test::TempDir dir;
    Made made;
    makeRaster(dir.file("a.tif"), made, [](int, int) { return 1; });
    made.epsg = 32632;
    made.cellX = made.cellY = 100;
    makeRaster(dir.file("b.tif"), made, [](int, int) { return 1; });
    made.epsg = 4326;
    made.cellX = made.cellY = 0.01;
    made.scale = 0.1;
    makeRaster(dir.file("c.tif"), made, [](int, int) { return 1; });
    for (const char* other : {"b.tif", "c.tif"}) {
        const Result<void> done = build(of({dir.file("a.tif"), dir.file(other)}), dir.file("out.ept"));
        REQUIRE_FALSE(done);
        CHECK(done.error().kind == ErrorKind::usage);
        CHECK_THAT(done.error().message, Catch::Contains(other));
    }
}

TEST_CASE("a projected raster is warped to WGS 84 and keeps its heights where they were")
{
    const test::TempDir dir;
    Made made;
    made.type = GDT_Float32;
    made.epsg = 32632;
    made.west = 600000;
    made.north = 5300000;
    made.cellX = made.cellY = 100;
    made.cols = 120;
    made.rows = 90;
    // A plane over eastings and northings, so that interpolation is exact.
    const auto plane = [](double e, double n) { return 1000 + (e - 606000) * 0.05 - (n - 5295000) * 0.03; };
    makeRaster(dir.file("a.tif"), made,
               [&](int c, int r) { return plane(600050 + 100.0 * c, 5299950 - 100.0 * r); });
    const data::Dataset dataset = built(of({dir.file("a.tif")}), dir, VoidRule::hole);
    const lod::TerrainShape& shape = dataset.info().shape;
    CHECK(shape.ellipsoid == kWgs84);
    // 100 m are 0.0009 degrees of latitude and 0.00134 of longitude here.
    CHECK(shape.latitudeStepRad * kDegPerRad == Approx(0.0009).epsilon(0.02));
    CHECK(shape.longitudeStepRad * kDegPerRad == Approx(0.00134).epsilon(0.02));
    OGRSpatialReference geographic;
    OGRSpatialReference projected;
    geographic.importFromEPSG(4326);
    geographic.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    projected.importFromEPSG(32632);
    const std::unique_ptr<OGRCoordinateTransformation> transform(
        OGRCreateCoordinateTransformation(&geographic, &projected));
    REQUIRE(transform);
    const std::vector<double> grid = test::gridOf(dataset);
    int inside = 0;
    double most = 0;
    for (uint32_t r = 0; r < shape.rows; ++r)
        for (uint32_t c = 0; c < shape.cols; ++c) {
            double e = (shape.westRad + c * shape.longitudeStepRad) * kDegPerRad;
            double n = (shape.northRad - r * shape.latitudeStepRad) * kDegPerRad;
            REQUIRE(transform->Transform(1, &e, &n));
            if (e < 600100 || e > 611900 || n > 5299900 || n < 5291100)
                continue;
            ++inside;
            most = std::max(most, std::abs(grid[size_t{r} * shape.cols + c] - plane(e, n)));
        }
    CHECK(inside > 9000);
    // Half a decimetre of rounding, and an eighth of a cell of GDAL's approximate transformation.
    CHECK(most < 0.05 + 12.5 * 0.06);
}

TEST_CASE("warping beside voids makes no heights in between")
{
    const test::TempDir dir;
    Made made;
    made.epsg = 32632;
    made.west = 600000;
    made.north = 5300000;
    made.cellX = made.cellY = 100;
    made.cols = 100;
    made.rows = 100;
    made.noData = -32768;
    makeRaster(dir.file("a.tif"), made,
               [](int c, int r) { return std::hypot(c - 50, r - 50) < 20 ? -32768 : 1500; });
    for (const double post : test::gridOf(built(of({dir.file("a.tif")}), dir, VoidRule::interpolate)))
        REQUIRE(post == 1500);
    for (const double post : test::gridOf(built(of({dir.file("a.tif")}), dir, VoidRule::sea)))
        REQUIRE((post == 1500 || post == 0)); // outside the turned raster is sea
}

TEST_CASE("an equirectangular raster on a sphere is not resampled")
{
    const test::TempDir dir;
    Made made;
    makeRaster(dir.file("flat.tif"), made, [](int c, int r) { return c * r; });
    {
        const terrain::RasterPtr raster(
            GDALDataset::Open(dir.file("flat.tif").c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
        OGRSpatialReference moon;
        moon.SetFromUserInput("+proj=eqc +lat_ts=0 +lon_0=20 +R=1737400 +units=m +no_defs");
        raster->SetSpatialRef(&moon);
        const double degreeM = 1737400 * kRadPerDeg;
        std::array<double, 6> transform{-2 * degreeM, 0.5 * degreeM, 0, 3 * degreeM, 0, -0.25 * degreeM};
        raster->SetGeoTransform(transform.data());
    }
    const data::Dataset dataset = built(of({dir.file("flat.tif")}), dir);
    CHECK(difference(dataset, 8, 6, [](int c, int r) { return c * r; }) == 0);
    const lod::TerrainShape& shape = dataset.info().shape;
    CHECK(shape.ellipsoid == Ellipsoid{1737400.0, 0.0});
    CHECK(shape.westRad * kDegPerRad == Approx(18.25));
    CHECK(shape.northRad * kDegPerRad == Approx(3 - 0.125));
    CHECK(shape.latitudeStepRad * kDegPerRad == Approx(0.25));
    CHECK(shape.longitudeStepRad * kDegPerRad == Approx(0.5));
}

TEST_CASE("a global raster closes at the date line and at the poles")
{
    const test::TempDir dir;
    Made made;
    made.cols = 36;
    made.rows = 18;
    made.west = -180;
    made.north = 90;
    made.cellX = made.cellY = 10;
    const auto height = [](int c, int r) { return 10 * (c % 36) + 2 * r; };
    makeRaster(dir.file("a.tif"), made, height);
    const data::Dataset dataset = built(of({dir.file("a.tif")}), dir);
    // Samples at 85, 75 ...; posts at 90, 85, 80, 75 ...
    const double meanOfRow = 10 * 17.5;
    CHECK(difference(dataset, 37, 37, [&](int c, int r) {
              if (r == 0 || r == 36)
                  return std::round(meanOfRow + (r == 0 ? 0 : 34));
              return r % 2 == 1 ? static_cast<double>(height(c, r / 2))
                                : 0.5 * (height(c, r / 2 - 1) + height(c, r / 2));
          }) == 0);
    const lod::TerrainShape& shape = dataset.info().shape;
    CHECK(shape.northRad == Approx(kPi / 2).epsilon(1e-15));
    CHECK(shape.longitudeStepRad * 36 == Approx(2 * kPi).epsilon(1e-15));
    CHECK(shape.latitudeStepRad * 36 == Approx(kPi).epsilon(1e-15));
}

TEST_CASE("small voids are interpolated, NaN and infinity are voids too")
{
    const test::TempDir dir;
    Made made;
    made.type = GDT_Float32;
    made.cols = made.rows = 30;
    made.noData = -9999;
    makeRaster(dir.file("a.tif"), made, [](int c, int r) {
        const double infinity = std::numeric_limits<double>::infinity();
        return c == 10 && r == 10   ? -9999
               : c == 15 && r == 20 ? std::nan("")
               : c == 20 && r == 5  ? infinity
                                    : 800 + c;
    });
    CHECK(difference(built(of({dir.file("a.tif")}), dir), 30, 30, [](int c, int) { return 800 + c; }) < 0.11);
}

TEST_CASE("a float raster full of infinities and NaN compiles to finite ground without spikes")
{
    const test::TempDir dir;
    Made made;
    made.type = GDT_Float32;
    made.cols = made.rows = 80;
    const double infinity = std::numeric_limits<double>::infinity();
    const std::array<double, 3> wrong{std::nan(""), infinity, -infinity};
    const auto height = [](int c, int r) { return 800 + c + 2.0 * r; };
    makeRaster(dir.file("a.tif"), made, [&](int c, int r) {
        const bool coarse = c >= 30 && c < 45 && r >= 50 && r < 62; // a large void, beside single ones
        return coarse || (c * 31 + r * 17) % 23 == 0 ? wrong[static_cast<size_t>(c + r) % wrong.size()]
                                                     : height(c, r);
    });
    const data::Dataset dataset = built(of({dir.file("a.tif")}), dir, VoidRule::interpolate);
    CHECK(dataset.info().minHeightM >= 799.9);
    CHECK(dataset.info().maxHeightM <= 800 + 79 + 2 * 79 + 0.1);
    for (const lod::PageNode& page : dataset.pages()) {
        CHECK(std::isfinite(page.minHeightM));
        CHECK(std::isfinite(page.maxHeightM));
    }
    // Single voids lie on the plane around them; what is not asked about is NaN.
    CHECK(difference(dataset, 80, 80, [&](int c, int r) {
              const bool near = c >= 26 && c < 49 && r >= 46 && r < 66;
              return near ? std::nan("") : height(c, r);
          }) < 4.0);
}

TEST_CASE("a raster that does not say where it lies is placed by the command line")
{
    const test::TempDir dir;
    Made made;
    made.driver = "GTiff";
    made.epsg = 0;
    made.type = GDT_UInt16;
    makeRaster(dir.file("a.tif"), made, [](int c, int r) { return c * r; });
    const auto refused = [&](const terrain::RasterOptions& options, const char* word) {
        const Result<void> done = build(options, dir.file("out.ept"));
        REQUIRE_FALSE(done);
        CHECK(done.error().kind == ErrorKind::usage);
        CHECK_THAT(done.error().message, Catch::Contains(word));
    };
    terrain::RasterOptions options = of({dir.file("a.tif")});
    refused(options, "--extent");
    options.extent = {{5, 40, 9, 43}};
    refused(options, "--crs");
    options.crs = "EPSG:99999999";
    refused(options, "--crs");
    options.crs = "EPSG:4326";
    const data::Dataset dataset = built(options, dir);
    CHECK(dataset.info().shape.westRad * kDegPerRad == Approx(5.25));
    CHECK(dataset.info().shape.northRad * kDegPerRad == Approx(42.75));
    CHECK(difference(dataset, 8, 6, [](int c, int r) { return c * r; }) == 0);
}

TEST_CASE("what holds no heights is refused in one line, and nothing is left behind")
{
    const test::TempDir dir;
    Made made;
    made.noData = -32768;
    makeRaster(dir.file("void.tif"), made, [](int, int) { return -32768; });
    made.bands = 3;
    made.type = GDT_Byte;
    makeRaster(dir.file("rgb.tif"), made, [](int c, int) { return c; });
    made = {};
    made.cols = made.rows = 200;
    makeRaster(dir.file("whole.tif"), made, [](int c, int r) { return c * 31 % 97 + r; });
    std::vector<uint8_t> bytes = test::bytesOf(dir.file("whole.tif"));
    bytes.resize(bytes.size() / 2);
    test::writeBytes(dir.file("cut.tif"), bytes);
    made.type = GDT_Float32;
    makeRaster(dir.file("undeclared.tif"), made, [](int c, int) { return c == 7 ? -3.4e38 : c; });
    test::writeBytes(dir.file("text.tif"), {'n', 'o', ' ', 'd', 'e', 'm'});
    test::writeBytes(dir.file("empty.zip"),
                     {'P', 'K', 5, 6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    const auto before = std::distance(std::filesystem::directory_iterator(dir.path()), {});
    for (const char* name :
         {"void.tif", "rgb.tif", "cut.tif", "text.tif", "undeclared.tif", "empty.zip", "missing.tif"}) {
        const Result<void> done = build(of({dir.file(name)}), dir.file("out.ept"));
        REQUIRE_FALSE(done);
        INFO(done.error().message);
        CHECK(done.error().kind == ErrorKind::dataset);
        CHECK_THAT(done.error().message, Catch::Contains(name));
        CHECK(done.error().message.find('\n') == std::string::npos);
    }
    CHECK(std::distance(std::filesystem::directory_iterator(dir.path()), {}) == before);

    // What the system or GDAL refused is followed by what to do about it.
    const auto refusal = [&](const std::string& name, const std::string& output) {
        return build(of({dir.file(name)}), output).error().message;
    };
    const std::string output = dir.file("out.ept");
    CHECK_THAT(refusal("cut.tif", output),
               Catch::EndsWith("; the file is damaged or cut short, fetch it again"));
    CHECK_THAT(refusal("text.tif", output), Catch::EndsWith("; give one that gdalinfo opens"));
    CHECK_THAT(refusal("missing.tif", output), Catch::EndsWith("No such file or directory; check the path"));
    CHECK_THAT(refusal("whole.tif", dir.file("nowhere/out.ept")),
               Catch::EndsWith("No such file or directory; check the path"));
}

TEST_CASE("the same tile as GeoTIFF and as zipped SRTM height file gives the same dataset")
{
    const std::string zip = shared("N46W122.hgt.zip");
    const std::string tif = shared("srtm3_N46W122_rainier.tif");
    if (zip.empty() || tif.empty())
        return;
    const test::TempDir dir;
    const data::Dataset a = built(of({zip}), dir);
    const std::vector<double> heights = test::gridOf(a);
    const lod::TerrainShape shape = a.info().shape;
    const data::Dataset b = built(of({tif}), dir);
    CHECK(shape.cols == 1201);
    CHECK(shape.northRad == Approx(b.info().shape.northRad).epsilon(1e-12));
    CHECK(shape.westRad == Approx(b.info().shape.westRad).epsilon(1e-12));
    CHECK(heights == test::gridOf(b));
}

TEST_CASE("voids at a summit become neither pits nor spikes")
{
    const std::string file = shared("srtm3_rainier_513.tif");
    if (file.empty())
        return;
    const test::TempDir dir;
    const data::Dataset dataset = built(of({file}), dir);
    const std::vector<double> grid = test::gridOf(dataset);
    double lowest = 1e9;
    for (uint32_t r = 20; r < 493; ++r)
        for (uint32_t c = 20; c < 493; ++c)
            lowest = std::min(lowest, grid[r * 513 + c]);
    CHECK(lowest > 300);
    CHECK(dataset.info().maxHeightM <= 4392);
}

TEST_CASE("an ASCII grid needs a coordinate system, and then keeps the mountain")
{
    const std::string file = shared("os_terrain50_NN17.asc");
    if (file.empty())
        return;
    const test::TempDir dir;
    const Result<void> done = build(of({file}), dir.file("out.ept"));
    REQUIRE_FALSE(done);
    CHECK_THAT(done.error().message, Catch::Contains("--crs"));
    terrain::RasterOptions options = of({file});
    options.crs = "EPSG:27700";
    const data::Dataset dataset = built(options, dir);
    // Ben Nevis, 56.797 N 5.004 W (WGS 84), 1344.9 m in this data.
    const lod::TerrainShape& shape = dataset.info().shape;
    const std::vector<double> grid = test::gridOf(dataset);
    const auto top = static_cast<size_t>(std::max_element(grid.begin(), grid.end()) - grid.begin());
    CHECK(grid[top] == Approx(1344.9).margin(10));
    CHECK((shape.northRad - static_cast<double>(top / shape.cols) * shape.latitudeStepRad) * kDegPerRad ==
          Approx(56.7969).margin(0.0015));
    CHECK((shape.westRad + static_cast<double>(top % shape.cols) * shape.longitudeStepRad) * kDegPerRad ==
          Approx(-5.0036).margin(0.0025));
}

TEST_CASE("the world closes and a picture of heights is placed by hand, with real data")
{
    const test::TempDir dir;
    if (const std::string world = shared("etopo20_global_1080x540.tif"); !world.empty()) {
        const data::Dataset dataset = built(of({world}), dir);
        const lod::TerrainShape& shape = dataset.info().shape;
        CHECK(shape.cols == 1081);
        CHECK(shape.rows == 1081);
        const std::vector<double> grid = test::gridOf(dataset);
        int open = 0;
        for (size_t r = 0; r < shape.rows; ++r)
            open += grid[r * 1081] != grid[r * 1081 + 1080] ? 1 : 0;
        CHECK(open == 0);
        CHECK(std::count(grid.begin(), grid.begin() + 1081, grid[0]) == 1081);
        CHECK(dataset.info().minHeightM == Approx(-9026.6).margin(0.3));
    }
    if (const std::string picture = shared("ps_height_1k.png"); !picture.empty()) {
        terrain::RasterOptions options = of({picture});
        options.extent = {{466080, 5109920, 630080, 5273920}};
        options.crs = "EPSG:26710";
        options.scale = 0.1;
        const data::Dataset dataset = built(options, dir);
        CHECK(dataset.info().maxHeightM == Approx(4379.8).margin(40));
        CHECK(dataset.info().minHeightM == 0);
    }
}

TEST_CASE("the whole Earth's raster is flown over")
{
    const std::string world = shared("etopo20_global_1080x540.tif");
    if (world.empty())
        return;
    const test::TempDir dir;
    const auto ground = selftest::Ground::of(built(of({world}), dir));
    REQUIRE(ground);
    for (const lod::Method method : selftest::kMethods)
        test::flyOver(*ground, method, 14);
}

TEST_CASE("the Moon's raster is flown over")
{
    // Cut out of the Apennine front at 27 N 5 E.
    constexpr int kPosts = 257;
    const auto heights = test::samplesOf({"moon_apennines_2049.tif", 1000, 700, kPosts, kPosts});
    if (heights.empty())
        return;
    selftest::GroundPlan plan{"Moon", kPosts, kPosts, {}, [&](uint32_t c, uint32_t r) {
                                  return static_cast<double>(heights[size_t{r} * kPosts + c]);
                              }};
    plan.place.ellipsoid = {1'737'400.0, 0.0};
    plan.place.northDeg = 27.3;
    plan.place.westDeg = 4.9;
    plan.place.latitudeStepDeg = plan.place.longitudeStepDeg = 1.0 / 256;
    const test::TempDir dir;
    const auto ground = selftest::Ground::make(plan, dir.path());
    REQUIRE(ground);
    for (const lod::Method method : selftest::kMethods)
        test::flyOver(*ground, method, 60);
}

namespace {

// Runs the program; its output and its complaints.
struct Run {
    int code;
    std::string out, err;
};
Run run(const test::TempDir& dir, std::vector<std::string> words)
{
    words.insert(words.begin(), "eyepoint-terrain");
    test::Process process(words, dir.file("stdout"), dir.file("stderr"));
    const int code = process.wait(60);
    return {code, test::readFile(dir.file("stdout")), test::readFile(dir.file("stderr"))};
}

} // namespace

TEST_CASE("the program makes, compiles, describes and verifies terrain")
{
    const test::TempDir dir;
    CHECK(run(dir, {"synth", "-o", dir.file("dem.tif"), "--size", "300", "--seed", "3"}).code == 0);
    CHECK(run(dir, {"build", dir.file("dem.tif"), "-o", dir.file("a.ept")}).code == 0);
    const Run info = run(dir, {"info", dir.file("a.ept"), "--json"});
    CHECK(info.code == 0);
    const auto json = nlohmann::json::parse(info.out);
    CHECK(json["cols"] == 300);
    CHECK(json["height_scale_m"] == 0.1);
    CHECK(json["source"] == "dem.tif");
    CHECK(run(dir, {"info", dir.file("a.ept")}).out.find("300 x 300") != std::string::npos);
    CHECK(run(dir, {"verify", dir.file("a.ept")}).code == 0);

    std::vector<uint8_t> bytes = test::bytesOf(dir.file("a.ept"));
    bytes[500] ^= 0xff; // in the first page
    bytes[bytes.size() / 2] ^= 0xff;
    test::writeBytes(dir.file("a.ept"), bytes);
    const Run verify = run(dir, {"verify", dir.file("a.ept"), "--json"});
    CHECK(verify.code == 4);
    const auto report = nlohmann::json::parse(verify.out);
    CHECK(report["ok"] == false);
    REQUIRE(report["bad"].size() == 2);
    CHECK(report["bad"][0]["page"] == 0);
    bytes.resize(100);
    test::writeBytes(dir.file("a.ept"), bytes);
    CHECK(run(dir, {"verify", dir.file("a.ept")}).code == 4);
    CHECK(run(dir, {"info", dir.file("a.ept")}).code == 4);
}

TEST_CASE("wrong command lines end with code 2 and a word about it")
{
    const test::TempDir dir;
    CHECK(run(dir, {"--help"}).code == 0);
    CHECK(run(dir, {"--version"}).out.find("eyepoint-terrain ") == 0);
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
             {},
             {"bake"},
             {"synth"},
             {"synth", "-o", dir.file("x.tif"), "--size", "1"},
             {"build", "a.tif"},
             {"build", "a.tif", "-o", dir.file("x.ept"), "--voids", "lava"},
             {"build", "a.tif", "-o", dir.file("x.ept"), "--extent", "1,2,3"},
             {"build", "a.tif", "-o", dir.file("x.ept"), "--extent", "4,2,3,5"},
             {"build", "a.tif", "-o", dir.file("x.ept"), "--polish"},
             {"info"},
             {"synth", "-o", dir.file("no/folder/x.tif"), "--size", "9"}}) {
        const Run outcome = run(dir, words);
        INFO(outcome.err);
        CHECK(outcome.code == 2);
        CHECK_FALSE(outcome.err.empty());
    }
    CHECK(run(dir, {"build", dir.file("missing.tif"), "-o", dir.file("x.ept")}).code == 4);
    CHECK(run(dir, {"build", dir.file("missing.tif"), "-o", dir.file("no/folder/x.ept")}).code == 2);
    CHECK(std::distance(std::filesystem::directory_iterator(dir.path()), {}) == 2); // stdout, stderr
}

TEST_CASE("a raster is not written over, however the output is spelt")
{
    const test::TempDir dir;
    makeRaster(dir.file("a.tif"), {}, [](int c, int r) { return c + r; });
    const std::vector<uint8_t> before = test::bytesOf(dir.file("a.tif"));
    std::filesystem::create_symlink("a.tif", dir.file("link.tif"));
    for (const char* output : {"a.tif", "./a.tif", "link.tif"}) {
        const Run outcome = run(dir, {"build", dir.file("a.tif"), "-o", dir.file(output), "--quiet"});
        CHECK(outcome.code == 2);
        CHECK_THAT(outcome.err, Catch::Contains("both input and output"));
    }
    CHECK(test::bytesOf(dir.file("a.tif")) == before);
}

TEST_CASE("an interrupted run leaves no file behind")
{
    for (const int number : {SIGINT, SIGTERM}) {
        const test::TempDir dir;
        const test::TempDir logs;
        test::Process process({"eyepoint-terrain", "synth", "--size", "8193", "-o", dir.file("dem.tif")},
                              logs.file("out"), logs.file("err"));
        for (int i = 0; i < 500 && std::filesystem::is_empty(dir.path()); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        REQUIRE_FALSE(std::filesystem::is_empty(dir.path()));
        process.signal(number);
        CHECK(process.wait(20) == 1);
        CHECK(std::filesystem::is_empty(dir.path()));
        CHECK_THAT(test::readFile(logs.file("err")), Catch::Contains("interrupted"));
    }
}
