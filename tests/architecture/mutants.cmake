# Every mutant fits its header. That tests kill them takes minutes to compile, and is left to runs of
# all tests; this is quick to see.
# Usage: cmake -DMUTANTS=<folder> -DINCLUDE=<include> -P mutants.cmake
# SPDX-License-Identifier: BSD-3-Clause
include("${CMAKE_CURRENT_LIST_DIR}/../mutants/mutant.cmake")

file(GLOB files "${MUTANTS}/*.mutant")
if(NOT files)
  message(FATAL_ERROR "${MUTANTS} has no mutants")
endif()
set(all_faults "")
sort_mutants(headers ${files})
foreach(header IN LISTS headers)
  put_mutants_in("${INCLUDE}/bristle/${header}" text faults ${mutants_of_${header}})
  string(APPEND all_faults "${faults}")
endforeach()
if(all_faults)
  message(FATAL_ERROR "${all_faults}")
endif()
list(LENGTH files count)
message(STATUS "${count} mutants fit their headers")
