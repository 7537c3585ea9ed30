# SPDX-License-Identifier: MIT
# The host interface, its fuzz targets and the sample host.
find_package(nlohmann_json REQUIRED)

ig_test(test_hostif
  SOURCES test_hostif.cpp test_hostif_malformed.cpp test_hostif_session.cpp test_hostif_handshake.cpp
          test_hostif_roundtrip.cpp test_hostif_fgnet.cpp test_hostif_memory.cpp counted_new.cpp test_hostif_socket.cpp test_hostif_vectors.cpp
  LIBS hostif::hostif nlohmann_json::nlohmann_json)
if(EYEPOINT_TOOLS)
  ig_test(test_host_tool SOURCES test_host_tool.cpp test_host_flight.cpp LIBS host::tool)
  add_dependencies(test_host_tool eyepoint-host)
  ig_test(test_replay SOURCES test_replay.cpp LIBS replay::tool)
endif()

# Each fuzz target also builds with a main that reads files, and runs over its seeds in every CTest.
set(fuzz_targets fuzz_cigi33 fuzz_cigi40 fuzz_fgnet fuzz_session)
set(fuzz_library hostif::hostif)
if(EYEPOINT_TOOLS)
  list(APPEND fuzz_targets fuzz_capture)
  set(fuzz_library replay::tool)
endif()
add_executable(fuzz_seeds fuzz/make_seeds.cpp)
set_target_properties(fuzz_seeds PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
target_include_directories(fuzz_seeds PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(fuzz_seeds PRIVATE hostif::hostif nlohmann_json::nlohmann_json ig_flags)
foreach(target IN LISTS fuzz_targets)
  add_executable(${target}_corpus fuzz/${target}.cpp fuzz/corpus_main.cpp)
  set_target_properties(${target}_corpus PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_include_directories(${target}_corpus PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(${target}_corpus PRIVATE ${fuzz_library} ig_flags)
  add_test(NAME ${target}_corpus
    COMMAND ${target}_corpus ${CMAKE_CURRENT_SOURCE_DIR}/fuzz/corpus/${target})
  set_tests_properties(${target}_corpus PROPERTIES LABELS "unit;fuzz" TIMEOUT 60)
  add_dependencies(quick_tests ${target}_corpus)
  if(EYEPOINT_FUZZ)
    add_executable(${target} fuzz/${target}.cpp)
    set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
    target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
    target_link_libraries(${target} PRIVATE ${fuzz_library} ig_flags -fsanitize=fuzzer)
  endif()
endforeach()
