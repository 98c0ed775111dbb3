# Runs an example twice with the same arguments; both must succeed and write the same bits.
# Usage: cmake -DPROGRAM=<program> -DARGUMENTS=<list> -DWORK=<folder> -P repeat_example.cmake
# The program takes --output PREFIX and writes PREFIX.csv.
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

file(MAKE_DIRECTORY "${WORK}")
foreach(run first second)
  execute_process(
    COMMAND "${PROGRAM}" ${ARGUMENTS} --output "${WORK}/${run}"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE errors)
  message(NOTICE "${output}${errors}")
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${PROGRAM} ${ARGUMENTS} ended with ${result}")
  endif()
  file(SHA256 "${WORK}/${run}.csv" ${run})
endforeach()
if(NOT first STREQUAL second)
  message(FATAL_ERROR "two runs differ: cmp ${WORK}/first.csv ${WORK}/second.csv")
endif()
