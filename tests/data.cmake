# SPDX-License-Identifier: MIT
# Terrain datasets and their compiler.
ig_test(test_data SOURCES test_data.cpp counted_new.cpp LIBS ig::data terrain_compiler)
ig_test(test_vertex_codes SOURCES test_vertex_codes.cpp LIBS ig::data ig::gl terrain_rasters)
ig_test(test_height_query SOURCES test_height_query.cpp counted_new.cpp LIBS ig::data terrain_compiler)
ig_test(test_terrain_compiler SOURCES test_terrain_compiler.cpp LIBS terrain_compiler)
ig_test(test_terrain_rasters SOURCES test_terrain_rasters.cpp LIBS terrain_rasters ig::selftest nlohmann_json::nlohmann_json)
add_dependencies(test_terrain_rasters eyepoint-terrain)
