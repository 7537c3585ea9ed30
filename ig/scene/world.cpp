// SPDX-License-Identifier: MIT
#include "ig/scene/world.h"

#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace ig::scene {

namespace {

// Beyond this a tangent says nothing any more that a picture could show.
constexpr double kWidestRad = 89.9 * kRadPerDeg;
constexpr double kNarrowestRad = 1e-6;

void assignIf(double& target, const std::optional<double>& value)
{
    if (value) {
        target = *value;
    }
}

// Some hosts send the magnitudes of left and bottom: read them as what they must mean.
void orient(double& low, double high)
{
    if (low >= high) {
        low = -std::abs(low);
    }
}

bool drawable(double low, double high)
{
    return low >= -kWidestRad && high <= kWidestRad && high - low >= kNarrowestRad;
}

} // namespace

World::World(const Ellipsoid& ellipsoid, const ViewDefaults& defaults)
    : _ellipsoid(ellipsoid), _defaults(defaults), _slotOfEntity(65536, kNone), _mayMove(65536, false),
      _environment(ellipsoid, defaults.visibilityM)
{
    _entities.reserve(kEntities);
    _doomed.reserve(kEntities);
    _views.reserve(kViews);
}

void World::setDefaults(uint16_t view, const ViewDefaults& defaults)
{
    _ownDefaults.emplace_back(view, defaults);
}

void World::reset()
{
    for (const Entity& entity : _entities) {
        _slotOfEntity[entity.state.id] = kNone;
    }
    _entities.clear();
    _views.clear();
    std::fill(_mayMove.begin(), _mayMove.end(), false);
    _environment.reset();
}

Applied World::set(const EntityState& state, double timeS)
{
    const int16_t slot = slotOf(state.id);
    if (state.attached) {
        const int16_t parent = slotOf(state.parent);
        if (parent == kNone || state.parent == state.id || (slot != kNone && descends(parent, slot))) {
            return Applied::noParent;
        }
    }
    if (slot != kNone) {
        Entity& entity = _entities[static_cast<size_t>(slot)];
        entity.state = state;
        entity.timeS = timeS;
        return Applied::yes;
    }
    if (_entities.size() == kEntities) {
        return Applied::full;
    }
    _slotOfEntity[state.id] = static_cast<int16_t>(_entities.size());
    _entities.push_back({state, timeS, {}});
    return Applied::yes;
}

Applied World::set(const GroundTrack& track, double timeS)
{
    const int16_t slot = slotOf(track.entity);
    if (slot == kNone) {
        return Applied::noEntity;
    }
    Entity& entity = _entities[static_cast<size_t>(slot)];
    if (entity.state.attached) {
        return Applied::outOfRange; // an offset is nowhere on the ground
    }
    entity.state.position.latitudeRad = track.latitudeRad;
    entity.state.position.longitudeRad = track.longitudeRad;
    entity.state.attitude.yawRad = track.yawRad;
    entity.timeS = timeS;
    return Applied::yes;
}

Applied World::set(uint16_t id, const Rates& rates, double timeS)
{
    const int16_t slot = slotOf(id);
    if (slot == kNone) {
        return Applied::noEntity;
    }
    Entity& entity = _entities[static_cast<size_t>(slot)];
    EntityState& state = entity.state;
    if (_extrapolation.enabled && _mayMove[id] && timeS > entity.timeS) {
        const Motion so = motion(entity, timeS);
        if (state.attached) {
            state.offsetM += so.offsetM;
        } else {
            const glm::dmat3 axes = ecefFromNed(state.position.latitudeRad, state.position.longitudeRad);
            state.position =
                toGeodetic({toEcef(state.position, _ellipsoid).m + axes * so.offsetM}, _ellipsoid);
        }
        state.attitude = yawPitchRoll(so.parentFromBody);
        entity.timeS = timeS;
    }
    entity.rates = rates;
    return Applied::yes;
}

void World::destroy(uint16_t entity)
{
    if (slotOf(entity) == kNone) {
        return;
    }
    _doomed.clear();
    _doomed.push_back(entity);
    for (size_t i = 0; i < _doomed.size(); ++i) {
        for (const auto& [other, timeS, rates] : _entities) {
            if (other.attached && other.parent == _doomed[i]) {
                _doomed.push_back(other.id);
            }
        }
    }
    for (const uint16_t id : _doomed) {
        // The last one takes its place.
        const int16_t slot = slotOf(id);
        _entities[static_cast<size_t>(slot)] = _entities.back();
        _slotOfEntity[_entities.back().state.id] = slot;
        _entities.pop_back();
        _slotOfEntity[id] = kNone;
        _mayMove[id] = false;
    }
}

bool World::descends(int16_t slot, int16_t ancestor) const noexcept
{
    while (slot != kNone && slot != ancestor) {
        const EntityState& entity = _entities[static_cast<size_t>(slot)].state;
        slot = entity.attached ? slotOf(entity.parent) : kNone;
    }
    return slot == ancestor;
}

Motion World::motion(const Entity& entity, double timeS) const
{
    const glm::dmat3 attitude = parentFromChild(entity.state.attitude);
    if (!_extrapolation.enabled || !_mayMove[entity.state.id] || !(timeS > entity.timeS)) {
        return {glm::dvec3(0.0), attitude};
    }
    return motionOver(std::min(timeS - entity.timeS, _extrapolation.horizonS), entity.rates, attitude);
}

// Climbs from the entity to its top-level ancestor: no recursion, however long a chain a host builds.
World::Pose World::pose(int16_t slot, double timeS) const
{
    glm::dvec3 offset(0.0);
    glm::dmat3 turn(1.0);
    for (;;) {
        const Entity& entity = _entities[static_cast<size_t>(slot)];
        const Motion own = motion(entity, timeS);
        offset = own.parentFromBody * offset + own.offsetM;
        turn = own.parentFromBody * turn;
        if (!entity.state.attached) {
            // The tangent plane of where it was: over a horizon of seconds the world is flat.
            const Geodetic& at = entity.state.position;
            const glm::dmat3 ecefFromLocal = ecefFromNed(at.latitudeRad, at.longitudeRad);
            return {{toEcef(at, _ellipsoid).m + ecefFromLocal * offset}, ecefFromLocal * turn};
        }
        offset += entity.state.offsetM;
        slot = slotOf(entity.state.parent);
    }
}

std::optional<World::Pose> World::entityPose(uint16_t entity, double timeS) const
{
    const int16_t slot = slotOf(entity);
    return slot == kNone ? std::nullopt : std::optional(pose(slot, timeS));
}

World::View World::makeView(uint16_t id) const noexcept
{
    View view;
    const auto own = std::find_if(_ownDefaults.begin(), _ownDefaults.end(),
                                  [&](const auto& defaults) { return defaults.first == id; });
    const ViewDefaults& defaults = own != _ownDefaults.end() ? own->second : _defaults;
    view.id = id;
    view.leftRad = defaults.leftRad;
    view.rightRad = defaults.rightRad;
    view.bottomRad = defaults.bottomRad;
    view.topRad = defaults.topRad;
    view.nearM = defaults.nearM;
    view.attitude = defaults.attitude;
    return view;
}

const World::View* World::find(uint16_t id) const noexcept
{
    const auto found =
        std::find_if(_views.begin(), _views.end(), [&](const View& view) { return view.id == id; });
    return found == _views.end() ? nullptr : &*found;
}

World::View* World::findOrMake(uint16_t id)
{
    if (const View* found = find(id)) {
        return const_cast<View*>(found);
    }
    if (_views.size() == kViews) {
        return nullptr;
    }
    _views.push_back(makeView(id));
    return &_views.back();
}

Applied World::set(const ViewPlacement& placement)
{
    const auto place = [&](View& view) {
        view.entity = placement.entity;
        assignIf(view.offsetM.x, placement.xM);
        assignIf(view.offsetM.y, placement.yM);
        assignIf(view.offsetM.z, placement.zM);
        assignIf(view.attitude.yawRad, placement.yawRad);
        assignIf(view.attitude.pitchRad, placement.pitchRad);
        assignIf(view.attitude.rollRad, placement.rollRad);
    };
    if (placement.group != 0) {
        for (View& view : _views) {
            if (view.group == placement.group) {
                place(view);
            }
        }
        return Applied::yes;
    }
    View* view = findOrMake(placement.view);
    if (view == nullptr) {
        return Applied::full;
    }
    place(*view);
    return Applied::yes;
}

Applied World::set(const ViewShape& shape)
{
    const View* known = find(shape.view);
    View wanted = known != nullptr ? *known : makeView(shape.view);
    wanted.group = shape.group;
    wanted.parallel = shape.parallel;
    wanted.mirrorX = shape.mirrorX;
    wanted.mirrorY = shape.mirrorY;
    assignIf(wanted.nearM, shape.nearM);
    if (shape.farM) {
        wanted.farM = shape.farM;
    }
    assignIf(wanted.leftRad, shape.leftRad);
    assignIf(wanted.rightRad, shape.rightRad);
    assignIf(wanted.bottomRad, shape.bottomRad);
    assignIf(wanted.topRad, shape.topRad);
    orient(wanted.leftRad, wanted.rightRad);
    orient(wanted.bottomRad, wanted.topRad);
    if (!drawable(wanted.leftRad, wanted.rightRad) || !drawable(wanted.bottomRad, wanted.topRad) ||
        !(wanted.nearM > 0.0) || (wanted.farM && !(*wanted.farM > wanted.nearM))) {
        return Applied::outOfRange;
    }
    View* view = findOrMake(shape.view);
    if (view == nullptr) {
        return Applied::full;
    }
    *view = wanted;
    return Applied::yes;
}

std::optional<World::Pose> World::viewPose(const View& view, double timeS) const
{
    const auto entity = entityPose(view.entity, timeS);
    if (!entity) {
        return std::nullopt;
    }
    return Pose{{entity->position.m + entity->ecefFromBody * view.offsetM},
                entity->ecefFromBody * parentFromChild(view.attitude)};
}

std::optional<World::Pose> World::viewPose(uint16_t id, double timeS) const
{
    const View* known = find(id);
    return viewPose(known != nullptr ? *known : makeView(id), timeS);
}

std::optional<ViewState> World::viewState(uint16_t id, int widthPx, int heightPx, double timeS) const
{
    const View* known = find(id);
    const View view = known != nullptr ? *known : makeView(id);
    const auto pose = viewPose(view, timeS);
    if (!pose) {
        return std::nullopt;
    }
    ViewState state;
    state.eye = pose->position;
    state.eyeFromEcef = eyeFromEcefOfView(pose->ecefFromBody);
    // The box of a parallel view has the sides that the angles have at the near plane.
    const double scale = view.parallel ? view.nearM : 1.0;
    Frustum& frustum = state.frustum;
    frustum.left = scale * std::tan(view.leftRad);
    frustum.right = scale * std::tan(view.rightRad);
    frustum.bottom = scale * std::tan(view.bottomRad);
    frustum.top = scale * std::tan(view.topRad);
    frustum.nearM = view.nearM;
    frustum.parallel = view.parallel;
    if (view.farM) {
        frustum.farM = *view.farM;
    } else if (view.parallel) {
        frustum.farM = farthestGroundM(state, _ellipsoid);
    }
    state.mirrorX = view.mirrorX;
    state.mirrorY = view.mirrorY;
    state.widthPx = widthPx;
    state.heightPx = heightPx;
    state.visibilityM = _environment.airAt(toGeodetic(state.eye, _ellipsoid)).visibilityM;
    return state;
}

} // namespace ig::scene
