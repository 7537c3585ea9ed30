// SPDX-License-Identifier: MIT
// A synthetic terrain, compiled into a dataset, all of it in memory: as the engine sees it, and post by post.
#pragma once

#include "ig/base/result.h"
#include "ig/data/dataset.h"
#include "ig/data/page_mesh.h"
#include "ig/geo/attitude.h"
#include "ig/geo/view_state.h"
#include "ig/lod/make_selector.h"
#include "tools/terrain/compile.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace ig::selftest {

struct GroundPlan {
    std::string name;
    uint32_t cols = 0, rows = 0;
    terrain::GridPlace place;
    std::function<double(uint32_t col, uint32_t row)> heightM; // NaN: a hole
};

const char* nameOf(lod::Method method) noexcept;
inline constexpr std::array kMethods{lod::Method::hybrid, lod::Method::bintree, lod::Method::geomip};

// Posts 50 m apart in both directions, the grid's middle at a place in degrees; heights to 0.1 m.
terrain::GridPlace placeAround(double latitudeDeg, double longitudeDeg, uint32_t cols, uint32_t rows);

class Ground {
public:
    // Compiles through a file in folder, which is removed again. Errors: of the compiler, of the dataset.
    static Result<Ground> make(const GroundPlan& plan, const std::string& folder);
    // All of a dataset. Errors: of its pages.
    static Result<Ground> of(data::Dataset dataset);

    const data::DatasetInfo& info() const noexcept { return _dataset.info(); }
    const lod::TerrainShape& shape() const noexcept { return _dataset.info().shape; }
    std::span<const lod::PageNode> pages() const noexcept { return _dataset.pages(); }
    int cols() const noexcept { return static_cast<int>(shape().cols); }
    int rows() const noexcept { return static_cast<int>(shape().rows); }
    int size() const noexcept { return _size; } // N of the padded grid

    // Posts of the padded grid, 0 .. size(); padding repeats the last one.
    const glm::dvec3& position(int col, int row) const noexcept { return _position[at(col, row)]; }
    uint8_t errorCode(int col, int row) const noexcept { return _errorCode[at(col, row)]; }
    uint8_t radiusCode(int col, int row) const noexcept { return _radiusCode[at(col, row)]; }
    // Metres above the ellipsoid; col and row within the grid.
    double heightM(int col, int row) const noexcept;
    // The grid's extent from north to south along the ground, m.
    double extentM() const noexcept;
    double largestHeightM() const noexcept { return info().maxHeightM; }

    // With every page resident, its slot the page's number.
    std::unique_ptr<lod::Selector> selector(const lod::SelectionSettings& settings) const;
    std::vector<int32_t> slotOfPage() const;
    // By page, with morph.
    std::vector<data::PageMesh> meshes() const;
    // Coordinates of vertices and morphs as the renderer gets them that are not finite.
    size_t notFinite() const;

private:
    explicit Ground(data::Dataset dataset) : _dataset(std::move(dataset)) {}
    size_t at(int col, int row) const noexcept
    {
        return static_cast<size_t>(row) * static_cast<size_t>(_size + 1) + static_cast<size_t>(col);
    }

    data::Dataset _dataset;
    std::vector<data::PageHeights> _heights; // by page
    int _size = 0;
    std::vector<glm::dvec3> _position;
    std::vector<int16_t> _post;
    std::vector<uint8_t> _errorCode, _radiusCode;
};

// A view from a place over a ground, in grid coordinates.
struct Look {
    double col = 0, row = 0;
    double heightM = 0; // above the ellipsoid
    YawPitchRoll attitude;
    double fovXRad = 1.2566; // 72 degrees
    double fovYRad = 0.7854; // 45 degrees
    int widthPx = 1280, heightPx = 720;
    double nearM = 0.5;
};
ViewState viewOf(const Ground& ground, const Look& look);
// The view with its eye elsewhere, a point in its middle, north up.
ViewState turnedTo(ViewState view, const glm::dvec3& eye, const glm::dvec3& point);
// All of a ground: from the south, 30 degrees above it, far enough that every error has a bound there, and at
// least so far.
ViewState viewOfAll(const Ground& ground, double leastM = 1'000);
ViewState viewOf(const EcefPos& eye, const glm::dmat3& ecefFromBody, const Look& look);

} // namespace ig::selftest
