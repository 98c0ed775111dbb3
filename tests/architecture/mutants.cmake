# Every planted bug can still be planted: the text it replaces stands once in its header. Whether tests
# notice them takes minutes to build, and runs with all tests only; that they fit is quick to see.
# Usage: cmake -DMUTANTS=<folder> -DINCLUDE=<include> -DOUTPUT=<file> -P mutants.cmake
# SPDX-License-Identifier: BSD-3-Clause
file(GLOB files "${MUTANTS}/*.mutant")
if(NOT files)
  message(FATAL_ERROR "${MUTANTS} has no mutants")
endif()
set(faults "")
foreach(file IN LISTS files)
  execute_process(
    COMMAND "${CMAKE_COMMAND}" "-DMUTANT=${file}" "-DINCLUDE=${INCLUDE}" "-DOUTPUT=${OUTPUT}" -P
            "${CMAKE_CURRENT_LIST_DIR}/../mutants/mutant.cmake"
    RESULT_VARIABLE result ERROR_VARIABLE error)
  if(NOT result EQUAL 0)
    string(APPEND faults "${error}")
  endif()
endforeach()
if(faults)
  message(FATAL_ERROR "${faults}")
endif()
list(LENGTH files count)
message(STATUS "${count} bugs can be planted")
