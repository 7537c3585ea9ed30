// SPDX-License-Identifier: MIT
#include "ig/lod/make_selector.h"

#include "ig/lod/geomip.h"
#include "ig/lod/tree_selector.h"

namespace ig::lod {

std::optional<Method> methodOf(std::string_view name) noexcept
{
    if (name == "geomip") {
        return Method::geomip;
    }
    if (name == "bintree") {
        return Method::bintree;
    }
    if (name == "hybrid") {
        return Method::hybrid;
    }
    return std::nullopt;
}

uint32_t smallestBudget(Method method) noexcept
{
    return method == Method::geomip ? kSmallestBudget : kSmallestTreeBudget;
}

std::unique_ptr<Selector> makeSelector(const TerrainShape& shape, std::span<const PageNode> pages,
                                       uint32_t slots, const SelectionSettings& settings)
{
    if (settings.method == Method::geomip) {
        return std::make_unique<GeomipSelector>(
            shape, pages, GeomipSettings{settings.triangleBudget, settings.tolerancePx, settings.morph});
    }
    TreeSettings tree;
    tree.triangleBudget = settings.triangleBudget;
    tree.tolerancePx = settings.tolerancePx;
    tree.cullVertices = settings.method == Method::bintree;
    tree.liveRanges = settings.liveRanges;
    return std::make_unique<TreeSelector>(shape, pages, slots, tree);
}

} // namespace ig::lod
