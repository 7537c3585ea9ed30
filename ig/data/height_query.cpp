// SPDX-License-Identifier: MIT
#include "ig/data/height_query.h"

#include "ig/data/hierarchy.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ig::data {

namespace {

constexpr int kPosts = lod::kPagePosts;
constexpr int kIntervals = lod::kPageIntervals;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Metres per radian, for bounds: north, and east at the equator.
double leastRadiusM(const Ellipsoid& ellipsoid)
{
    const double polar = 1 - ellipsoid.flattening;
    return ellipsoid.semiMajorM * polar * polar;
}

// Radii of curvature in the meridian and the prime vertical (Rapp 1991, "Geometric Geodesy" I, 3.5).
struct Curvature {
    double northM, eastM;
};

Curvature curvatureAt(double latitudeRad, const Ellipsoid& ellipsoid)
{
    const double e2 = ellipsoid.flattening * (2 - ellipsoid.flattening);
    const double s = std::sin(latitudeRad);
    const double w = 1 - e2 * s * s;
    const double prime = ellipsoid.semiMajorM / std::sqrt(w);
    return {prime * (1 - e2) / w, prime * std::cos(latitudeRad)};
}

// How far past the start of an interval a coordinate lies, 0..1; 0 in the padding, which has no width.
double share(double at, uint32_t from, uint32_t to)
{
    return to > from ? std::clamp((at - from) / (to - from), 0.0, 1.0) : 0.0;
}

} // namespace

Result<std::unique_ptr<HeightQuery>> HeightQuery::create(const Dataset& dataset,
                                                         const HeightQuerySettings& settings)
{
    std::unique_ptr<HeightQuery> query(new HeightQuery(dataset, settings));
    Slot& root = query->_slots[0];
    if (auto read = dataset.readPage(0, nullptr, root.heights); !read) {
        return Unexpected{read.error()};
    }
    root.page = 0;
    root.usedAt = std::numeric_limits<uint64_t>::max(); // never leaves
    root.state = SlotState::ready;
    query->_slotOfPage[0] = 0;
    return query;
}

HeightQuery::HeightQuery(const Dataset& dataset, const HeightQuerySettings& settings)
    : _dataset(dataset), _shape(dataset.info().shape), _slots(std::max(settings.cachePages, 2U)),
      _slotOfPage(dataset.pages().size(), kNone), _damaged(dataset.pages().size(), false),
      _queueCapacity(std::max(settings.queuePages, 1U)), _waits(settings.waits)
{
    _queue.reserve(_queueCapacity);
}

HeightQuery::~HeightQuery()
{
    {
        const std::scoped_lock lock(_mutex);
        _stop = true;
    }
    _work.notify_one();
    if (_reader.joinable()) {
        _reader.join();
    }
}

// The one place that reads pages.
void HeightQuery::readPages()
{
    PageReader reader(_dataset);
    for (;;) {
        int32_t slot = kNone;
        {
            std::unique_lock lock(_mutex);
            _work.wait(lock, [this] { return _stop || !_queue.empty(); });
            if (_stop) {
                return;
            }
            slot = _queue.front();
            _queue.erase(_queue.begin());
        }
        Slot& target = _slots[static_cast<size_t>(slot)];
        const auto read = reader.read(static_cast<uint32_t>(target.page));
        const bool good = bool(read);
        if (good) { // codes are nobody's concern here
            target.heights.post = (*read)->post;
            target.heights.hole = (*read)->hole;
        }
        target.state.store(good ? SlotState::ready : SlotState::failed, std::memory_order_release);
        target.state.notify_one();
    }
}

// A slot that is free, or else the least recently used page's; nothing while all are being read.
HeightQuery::Slot* HeightQuery::freeSlot()
{
    Slot* oldest = nullptr;
    for (Slot& slot : _slots) {
        const SlotState state = slot.state.load(std::memory_order_acquire);
        if (state == SlotState::free) {
            return &slot;
        }
        if (state == SlotState::ready && slot.page != 0 &&
            (oldest == nullptr || slot.usedAt < oldest->usedAt)) {
            oldest = &slot;
        }
    }
    return oldest;
}

void HeightQuery::request(int32_t page)
{
    if (!_reader.joinable()) { // no thread until somebody asks
        _reader = std::thread([this] { readPages(); });
    }
    const std::scoped_lock lock(_mutex);
    if (_queue.size() == _queueCapacity) {
        return;
    }
    Slot* slot = freeSlot();
    if (slot == nullptr) {
        return;
    }
    if (slot->page != kNone) {
        _slotOfPage[static_cast<size_t>(slot->page)] = kNone;
    }
    const auto number = static_cast<int32_t>(slot - _slots.data());
    slot->page = page;
    slot->usedAt = _now;
    slot->state.store(SlotState::loading, std::memory_order_relaxed);
    _slotOfPage[static_cast<size_t>(page)] = number;
    _queue.push_back(number);
    _work.notify_one();
}

const HeightQuery::Slot* HeightQuery::resident(int32_t page, bool wanted)
{
    if (_slotOfPage[static_cast<size_t>(page)] == kNone && wanted && !_damaged[static_cast<size_t>(page)]) {
        request(page);
    }
    const int32_t number = _slotOfPage[static_cast<size_t>(page)];
    if (number == kNone) {
        return nullptr;
    }
    Slot& slot = _slots[static_cast<size_t>(number)];
    if (_waits && wanted) {
        slot.state.wait(SlotState::loading, std::memory_order_acquire);
    }
    const SlotState state = slot.state.load(std::memory_order_acquire);
    if (state == SlotState::failed) {
        _damaged[static_cast<size_t>(page)] = true;
        _slotOfPage[static_cast<size_t>(page)] = kNone;
        slot.page = kNone;
        slot.state.store(SlotState::free, std::memory_order_relaxed);
    }
    if (state != SlotState::ready) {
        return nullptr;
    }
    if (page != 0) {
        slot.usedAt = _now;
    }
    return &slot;
}

bool HeightQuery::locate(double latitudeRad, double longitudeRad, Place& out) const noexcept
{
    double eastRad = std::fmod(longitudeRad - _shape.westRad, 2 * kPi);
    eastRad += eastRad < 0 ? 2 * kPi : 0;
    out.col = eastRad / _shape.longitudeStepRad;
    out.row = (_shape.northRad - latitudeRad) / _shape.latitudeStepRad;
    // A point on the west edge may come out a rounding short of a whole turn.
    const double turn = 2 * kPi / _shape.longitudeStepRad;
    constexpr double kSlack = 1e-6; // posts
    if (out.col > turn - kSlack) {
        out.col = 0;
    }
    const double lastCol = _shape.cols - 1;
    const double lastRow = _shape.rows - 1;
    if (!(out.col <= lastCol + kSlack && out.row >= -kSlack && out.row <= lastRow + kSlack)) {
        return false;
    }
    out.col = std::min(out.col, lastCol);
    out.row = std::clamp(out.row, 0.0, lastRow);

    const auto pages = _dataset.pages();
    const auto postsPerPage = static_cast<uint32_t>(kIntervals);
    // The last post belongs to the last interval.
    const auto x = std::min(static_cast<uint32_t>(out.col), _shape.cols - 2) / postsPerPage;
    const auto y = std::min(static_cast<uint32_t>(out.row), _shape.rows - 2) / postsPerPage;
    int32_t page = 0;
    out.count = 0;
    while (page != lod::kNoPage && out.count <= _shape.deepestPage) {
        out.page[static_cast<size_t>(out.count)] = page;
        const int below = _shape.deepestPage - ++out.count;
        if (below < 0) {
            break;
        }
        page = pages[static_cast<size_t>(page)].child[((y >> below) & 1U) * 2 + ((x >> below) & 1U)];
    }
    return true;
}

// On the triangle of the page's mesh that the point is over; false in a hole.
bool HeightQuery::groundOf(const Place& place, const Slot& slot, double latitudeRad, Ground& out) const
{
    const lod::PageNode& node = _dataset.pages()[static_cast<size_t>(slot.page)];
    const int above = _shape.deepestPage - node.depth;
    const double stride = std::ldexp(1.0, above);
    const auto cell = [&](double at, uint32_t page, uint32_t last) {
        const double inPage = std::min(at, last - 0.5) / stride - double(page) * kIntervals;
        return std::clamp(static_cast<int>(inPage), 0, kIntervals - 1);
    };
    const int i = cell(place.col, node.x, _shape.cols - 1);
    const int j = cell(place.row, node.y, _shape.rows - 1);
    if (!slot.heights.hole.empty() && slot.heights.hole[static_cast<size_t>(j * kIntervals + i)]) {
        return false;
    }
    const uint32_t west = postColumn(_shape, node.depth, node.x, i);
    const uint32_t east = postColumn(_shape, node.depth, node.x, i + 1);
    const uint32_t north = postRow(_shape, node.depth, node.y, j);
    const uint32_t south = postRow(_shape, node.depth, node.y, j + 1);
    const double u = share(place.col, west, east);
    const double v = share(place.row, north, south);
    const auto height = [&](int di, int dj) {
        const int16_t post = slot.heights.post[static_cast<size_t>((j + dj) * kPosts + i + di)];
        return post * _dataset.info().heightScaleM + _dataset.info().heightOffsetM;
    };
    const double nw = height(0, 0), ne = height(1, 0), sw = height(0, 1), se = height(1, 1);
    // The diagonal goes to the centre of the fan, whose column and row are odd. Slopes per interval.
    double slopeU = 0;
    double slopeV = 0;
    if ((i + j) % 2 == 0) { // north-west to south-east
        slopeU = v > u ? se - sw : ne - nw;
        slopeV = v > u ? sw - nw : se - ne;
        out.heightM = nw + slopeU * u + slopeV * v;
    } else { // south-west to north-east
        const bool lower = u + v > 1;
        slopeU = lower ? se - sw : ne - nw;
        slopeV = lower ? se - ne : sw - nw;
        out.heightM = lower ? se - slopeU * (1 - u) - slopeV * (1 - v) : nw + slopeU * u + slopeV * v;
    }
    const Curvature radius = curvatureAt(latitudeRad, _shape.ellipsoid);
    const double eastM = (east - west) * _shape.longitudeStepRad * radius.eastM;
    const double southM = (south - north) * _shape.latitudeStepRad * radius.northM;
    const double perEast = eastM > 0 ? slopeU / eastM : 0;
    const double perSouth = southM > 0 ? slopeV / southM : 0;
    out.normalNed = glm::normalize(glm::dvec3(perSouth, -perEast, -1.0));
    out.levelsAboveFinest = above;
    return true;
}

Known HeightQuery::groundAt(const Place& place, double latitudeRad, Ground& out)
{
    ++_now;
    for (int i = place.count; i-- > 0;) {
        const Slot* slot = resident(place.page[static_cast<size_t>(i)], i + 1 == place.count);
        if (slot == nullptr) {
            continue;
        }
        if (!groundOf(place, *slot, latitudeRad, out)) {
            return Known::nothing;
        }
        const int32_t finest = place.page[static_cast<size_t>(place.count - 1)];
        // A finest page that cannot be read will not come: the next coarser one is the answer.
        const bool final = slot->page == finest || _damaged[static_cast<size_t>(finest)];
        return final ? Known::yes : Known::notYet;
    }
    return Known::nothing;
}

Known HeightQuery::groundAt(double latitudeRad, double longitudeRad, Ground& out)
{
    Place place;
    if (!locate(latitudeRad, longitudeRad, place)) {
        return Known::nothing;
    }
    return groundAt(place, latitudeRad, out);
}

// How far the point can move without coming to the ground: by each page over it, as far as its border, or as
// far as it takes to sink to its greatest height. descent: metres of height lost per metre of way; it only
// gets less on a straight line, since the ground curves away below it.
double HeightQuery::clearStep(const Place& place, const Geodetic& point, double descent) const
{
    const double radiusM = leastRadiusM(_shape.ellipsoid);
    double best = 0;
    for (int i = 0; i < place.count; ++i) {
        const lod::PageNode& node = _dataset.pages()[static_cast<size_t>(place.page[static_cast<size_t>(i)])];
        const double clearance = point.heightM - double{node.maxHeightM};
        if (clearance <= 0) {
            continue;
        }
        const double west = postColumn(_shape, node.depth, node.x, 0);
        const double east = postColumn(_shape, node.depth, node.x, kIntervals);
        const double north = postRow(_shape, node.depth, node.y, 0);
        const double south = postRow(_shape, node.depth, node.y, kIntervals);
        const double rows = std::min(place.row - north, south - place.row);
        const double cols = std::min(place.col - west, east - place.col);
        const double farthestRad = std::max(std::abs(_shape.northRad - north * _shape.latitudeStepRad),
                                            std::abs(_shape.northRad - south * _shape.latitudeStepRad));
        const double cosine = std::max(std::cos(std::min(farthestRad, 0.5 * kPi)), 0.0);
        const double eastRad = std::sin(std::min(cols * _shape.longitudeStepRad, 0.5 * kPi)) * cosine;
        const double borderM = radiusM * std::min(rows * _shape.latitudeStepRad, eastRad);
        best = std::max(best, std::min(borderM, descent > 0 ? clearance / descent : kInfinity));
    }
    return best;
}

// A lower bound of the distance from a point beside the grid to it.
double HeightQuery::offGridM(const Geodetic& point) const
{
    const double southRad = _shape.northRad - (_shape.rows - 1) * _shape.latitudeStepRad;
    const double northwards = std::max(southRad - point.latitudeRad, point.latitudeRad - _shape.northRad);
    const double halfRad = 0.5 * (_shape.cols - 1) * _shape.longitudeStepRad;
    const double middleRad = _shape.westRad + halfRad;
    const double eastwards = std::abs(std::remainder(point.longitudeRad - middleRad, 2 * kPi)) - halfRad;
    const double farthestRad =
        std::max({std::abs(_shape.northRad), std::abs(southRad), std::abs(point.latitudeRad)});
    const double east = 2 / kPi * std::min(eastwards, 0.5 * kPi) * std::max(std::cos(farthestRad), 0.0);
    return leastRadiusM(_shape.ellipsoid) * std::max({2 / kPi * northwards, east, 0.0});
}

Known HeightQuery::firstHit(const EcefPos& from, const EcefPos& to, bool coarse, double& progressM,
                            GroundHit& out)
{
    const glm::dvec3 way = to.m - from.m;
    const double lengthM = glm::length(way);
    if (!std::isfinite(lengthM)) {
        return Known::nothing;
    }
    const glm::dvec3 direction = lengthM > 0 ? way / lengthM : glm::dvec3(0.0);
    const Curvature middle = curvatureAt(_shape.northRad, _shape.ellipsoid);
    const double halfPostM = 0.5 * std::max(std::min(_shape.latitudeStepRad * middle.northM,
                                                     _shape.longitudeStepRad * middle.eastM),
                                            0.01);
    Ground ground;
    // Height above the ground at a range; nothing where there is none. Updates `known`.
    Known known = Known::yes;
    const auto above = [&](double rangeM) -> std::optional<double> {
        const Geodetic at = toGeodetic({from.m + direction * rangeM}, _shape.ellipsoid);
        Place place;
        known = Known::nothing;
        if (locate(at.latitudeRad, at.longitudeRad, place)) {
            known = groundAt(place, at.latitudeRad, ground);
        }
        return known == Known::nothing ? std::nullopt : std::optional(at.heightM - ground.heightM);
    };
    std::optional<double> clearAtM; // the last range known to be above ground
    double rangeM = std::min(progressM, lengthM);
    for (int step = 0; step < kStepsPerCall; ++step) {
        const Geodetic at = toGeodetic({from.m + direction * rangeM}, _shape.ellipsoid);
        const glm::dvec3 down = ecefFromNed(at.latitudeRad, at.longitudeRad)[2];
        const double descent = glm::dot(direction, down);
        if (at.heightM > _dataset.info().maxHeightM && descent <= 0) {
            return Known::nothing; // rises for good
        }
        Place place;
        double stepM = 0;
        if (locate(at.latitudeRad, at.longitudeRad, place)) {
            stepM = clearStep(place, at, descent);
        } else {
            stepM = offGridM(at);
        }
        if (stepM < halfPostM) {
            const std::optional<double> heightM = above(rangeM);
            if (known == Known::notYet && !coarse) {
                progressM = clearAtM.value_or(rangeM);
                return Known::notYet;
            }
            if (heightM && *heightM <= 0) {
                double low = clearAtM.value_or(rangeM);
                double high = rangeM;
                for (int i = 0; i < 30 && high - low > 1e-4; ++i) {
                    const double half = 0.5 * (low + high);
                    const std::optional<double> h = above(half);
                    (h && *h <= 0 ? high : low) = half;
                }
                (void)above(high);
                out.rangeM = high;
                out.position = {from.m + direction * high};
                out.ground = ground;
                return Known::yes;
            }
            clearAtM = rangeM;
            stepM = halfPostM;
        } else {
            clearAtM = rangeM + stepM;
        }
        if (rangeM >= lengthM) {
            return Known::nothing;
        }
        rangeM = std::min(rangeM + stepM, lengthM);
    }
    progressM = clearAtM.value_or(rangeM);
    return Known::notYet;
}

} // namespace ig::data
