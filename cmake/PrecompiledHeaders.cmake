# The headers that most files include are parsed once for the program and once for its tests. Only with
# MORGAGNI_PRECOMPILE_HEADERS: the presets without it find the file that forgets an include.

# TARGET takes them from `program_headers` or `test_headers`.
function(mor_precompile_headers target from)
  if(MORGAGNI_PRECOMPILE_HEADERS)
    target_precompile_headers(${target} REUSE_FROM ${from})
  endif()
endfunction()

if(NOT MORGAGNI_PRECOMPILE_HEADERS)
  return()
endif()

file(WRITE ${PROJECT_BINARY_DIR}/generated/precompiled_headers.cc "")

function(mor_add_precompiled_headers name)
  cmake_parse_arguments(ARG "" "" "DEPS;HEADERS" ${ARGN})
  add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/generated/precompiled_headers.cc)
  target_link_libraries(${name} PRIVATE ${ARG_DEPS})
  mor_compile_options(${name})
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

set(headers <Eigen/Geometry> <algorithm> <chrono> <filesystem> <functional> <map> <memory> <optional> <span> <sstream>
            <string> <unordered_map> <vector>)
mor_add_precompiled_headers(program_headers DEPS Eigen3::Eigen HEADERS ${headers})
if(MORGAGNI_BUILD_TESTS)
  mor_add_precompiled_headers(test_headers DEPS Eigen3::Eigen GTest::gmock HEADERS ${headers} <gmock/gmock.h> <gtest/gtest.h>)
endif()
