# Compiles the programs in tests/benchmarks, but for those of other engines, to no file: they are run
# by hand, so nothing else tells that one does not compile. All are one translation unit, each in a
# namespace of its own, which takes a sixth of the time. What they include comes first.
# Usage: cmake -DROOT=<repository> -DCXX=<compiler> -DFLAGS=<list> -DWORK=<folder>
#        -P benchmarks.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

file(GLOB programs "${ROOT}/tests/benchmarks/*.cpp")
list(FILTER programs EXCLUDE REGEX "/host_cost[.]cpp$")
set(includes "")
set(bodies "")
foreach(program IN LISTS programs)
  file(STRINGS "${program}" lines REGEX "^#include")
  list(APPEND includes ${lines})
  cmake_path(GET program STEM name)
  string(APPEND bodies "namespace program_${name} {\n#include \"${program}\"\n}\n")
endforeach()
list(REMOVE_DUPLICATES includes)
list(FILTER includes EXCLUDE REGEX "(bullet_rays|embree_rays|mujoco_batch)[.]hpp")
list(JOIN includes "\n" includes)
file(WRITE "${WORK}/benchmarks.cpp" "${includes}\n${bodies}")
execute_process(
  COMMAND "${CXX}" -std=c++20 -fsyntax-only -DBRISTLE_COMPILED -DBRISTLE_WITH_DEFINITIONS
          "-I${ROOT}/include" "-I${ROOT}/tests" "-I${ROOT}/tests/benchmarks" ${FLAGS}
          "${WORK}/benchmarks.cpp" COMMAND_ERROR_IS_FATAL ANY)
