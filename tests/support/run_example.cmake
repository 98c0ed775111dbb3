# Runs an example in a folder of its own; it must succeed, and print what EXPECTED holds if there is
# such a file.
# Usage: cmake -DPROGRAM=<program> -DEXPECTED=<file> -DWORK=<folder> -P run_example.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

file(MAKE_DIRECTORY "${WORK}")
execute_process(
  COMMAND "${PROGRAM}"
  WORKING_DIRECTORY "${WORK}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE errors)
message(NOTICE "${output}${errors}")
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} ended with ${result}")
endif()
if(EXISTS "${EXPECTED}")
  file(READ "${EXPECTED}" expected)
  if(NOT output STREQUAL expected)
    file(WRITE "${WORK}/output" "${output}")
    message(FATAL_ERROR "output differs:\n  diff ${EXPECTED} ${WORK}/output")
  endif()
endif()
