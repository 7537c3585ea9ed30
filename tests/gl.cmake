# SPDX-License-Identifier: MIT
# Tests and benchmarks of ig/gl and ig/out.
ig_test(test_out SOURCES ${PROJECT_SOURCE_DIR}/tests/test_out.cpp LIBS ig::out)
ig_test(test_shm_ring SOURCES ${PROJECT_SOURCE_DIR}/tests/test_shm_ring.cpp LIBS ig::out Threads::Threads)
if(TARGET ig::out_gst)
  ig_test(test_video SOURCES ${PROJECT_SOURCE_DIR}/tests/test_video.cpp
    LIBS ig::out eyepoint::config PkgConfig::GSTREAMER)
endif()
# The reader's header is C: built as such, and run, from its place in the tree.
enable_language(C)
add_executable(frames_in_c ${PROJECT_SOURCE_DIR}/tests/package/frames.c)
set_target_properties(frames_in_c PROPERTIES C_STANDARD 99 C_EXTENSIONS OFF
  RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
target_include_directories(frames_in_c PRIVATE ${PROJECT_SOURCE_DIR}/ig/out)
target_compile_options(frames_in_c PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion)
add_test(NAME frames_in_c COMMAND frames_in_c)
set_tests_properties(frames_in_c PROPERTIES LABELS "unit" TIMEOUT 60)
add_dependencies(quick_tests frames_in_c)
ig_test(test_gl_indices SOURCES ${PROJECT_SOURCE_DIR}/tests/gl/test_tile_indices.cpp
  ${PROJECT_SOURCE_DIR}/tests/gl/test_vertex_order.cpp LIBS ig::gl)

# Render tests have a main of their own, which returns 77 where no context can be made.
set(gl_test_dir ${PROJECT_SOURCE_DIR}/tests/gl)
add_executable(test_gl
  ${gl_test_dir}/main.cpp ${gl_test_dir}/test_driver_threads.cpp ${gl_test_dir}/test_golden.cpp ${gl_test_dir}/test_limits.cpp
  ${gl_test_dir}/test_page_lists.cpp ${gl_test_dir}/test_picture.cpp ${gl_test_dir}/test_precision.cpp
  ${gl_test_dir}/test_projection.cpp
  ${gl_test_dir}/test_tile_morph.cpp ${gl_test_dir}/test_watertight.cpp)
target_compile_features(test_gl PRIVATE cxx_std_20)
set_target_properties(test_gl PROPERTIES CXX_EXTENSIONS OFF
  RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
target_compile_definitions(test_gl PRIVATE
  EYEPOINT_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
  EYEPOINT_TEST_OUTPUT_DIR="${CMAKE_BINARY_DIR}/tests/pictures")
target_link_libraries(test_gl PRIVATE ig::gl ig::out Catch2::Catch2 ig_flags)
add_test(NAME test_gl COMMAND test_gl)
set_tests_properties(test_gl PROPERTIES LABELS gl SKIP_RETURN_CODE 77 TIMEOUT 300)
add_dependencies(quick_tests test_gl)

# What the benchmarks of drawing stand on: synthetic scenes and the static yardstick.
add_library(gl_stage STATIC ${gl_test_dir}/stage.cpp ${gl_test_dir}/tree_stage.cpp ${PROJECT_SOURCE_DIR}/tests/bench/static_mesh.cpp)
target_compile_features(gl_stage PUBLIC cxx_std_20)
target_include_directories(gl_stage PUBLIC ${PROJECT_SOURCE_DIR}/tests/bench)
target_link_libraries(gl_stage PUBLIC ig::gl PkgConfig::GLES PRIVATE ig_flags)
target_link_libraries(test_gl PRIVATE gl_stage)
ig_test(test_page_morph SOURCES ${PROJECT_SOURCE_DIR}/tests/test_page_morph.cpp LIBS gl_stage)

# Run once, briefly, so that they keep working; figures come from running them alone.
foreach(name IN ITEMS gl out)
  add_executable(bench_${name} ${PROJECT_SOURCE_DIR}/tests/bench/bench_${name}.cpp)
  target_compile_features(bench_${name} PRIVATE cxx_std_20)
  set_target_properties(bench_${name} PROPERTIES CXX_EXTENSIONS OFF
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_link_libraries(bench_${name} PRIVATE ig::${name} benchmark::benchmark ig_flags)
  add_test(NAME bench_${name} COMMAND bench_${name} --benchmark_min_time=0.01)
  set_tests_properties(bench_${name} PROPERTIES LABELS "slow" TIMEOUT 300)
endforeach()
target_link_libraries(bench_gl PRIVATE gl_stage)
set_tests_properties(bench_gl PROPERTIES LABELS "slow;gl")
