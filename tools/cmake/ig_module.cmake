# SPDX-License-Identifier: MIT
# Flags shared by all of the project's targets, and the helper that declares a module.

add_library(ig_flags INTERFACE)
target_compile_options(ig_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  # GCC 12 warns falsely of overlapping copies in std::string's operator+ (its bug 105329).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  -ffp-contract=off) # the same bits whatever the target's FMA

set(EYEPOINT_SANITIZE "" CACHE STRING "Sanitizers for every target, e.g. address,undefined or thread")
if(EYEPOINT_SANITIZE)
  target_compile_options(ig_flags INTERFACE -fsanitize=${EYEPOINT_SANITIZE} -fno-omit-frame-pointer
                                            -fno-sanitize-recover=all)
  target_link_options(ig_flags INTERFACE -fsanitize=${EYEPOINT_SANITIZE})
  # Libraries without RTTI have classes with virtual functions, whose type this check would ask for.
  target_compile_options(ig_flags INTERFACE -fno-sanitize=vptr)
  # GCC 12 sees uninitialised values in the standard library's <regex> once sanitizers are in.
  target_compile_options(ig_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()
if(EYEPOINT_FUZZ)
  target_compile_options(ig_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Libraries that never throw: one line that keeps `throw` out of them.
add_library(ig_no_exceptions INTERFACE)
target_compile_options(ig_no_exceptions INTERFACE -fno-exceptions -fno-rtti)

# ig_module(name ALIAS ns::name SOURCES a.cpp ... [PUBLIC libs] [PRIVATE libs])
function(ig_module name)
  cmake_parse_arguments(M "" "ALIAS" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${M_SOURCES})
  add_library(${M_ALIAS} ALIAS ${name})
  target_compile_features(${name} PUBLIC cxx_std_20)
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include/eyepoint>)
  target_link_libraries(${name} PUBLIC ${M_PUBLIC} PRIVATE $<BUILD_INTERFACE:ig_flags> ${M_PRIVATE})
endfunction()

# ig_executable(name SOURCES a.cpp ... LIBS libs): an executable under our flags, which knows its version.
function(ig_executable name)
  cmake_parse_arguments(P "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${P_SOURCES})
  target_compile_features(${name} PRIVATE cxx_std_20)
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF)
  target_compile_definitions(${name} PRIVATE EYEPOINT_VERSION="${PROJECT_VERSION}")
  target_link_libraries(${name} PRIVATE $<BUILD_INTERFACE:ig_flags> ${P_LIBS})
endfunction()

# The same, installed.
function(ig_program name)
  ig_executable(${name} ${ARGN})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()
