# What the umbrella header costs those who include it: its lines of code after preprocessing.
# Usage: cmake -DCXX=<compiler> -DROOT=<tree> -DEIGEN=<include dir> [-DBUDGET=140000] -P budget.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

if(NOT DEFINED BUDGET)
  # Eigen/Geometry alone is about 99000, with the standard headers 120000; the rest is our own. A
  # header that drags in too much costs thousands, code that is needed may cost some hundreds.
  set(BUDGET 143900)
endif()

# Sets `out` to the lines that are neither blank nor line markers.
function(preprocessed_lines header out)
  execute_process(
    COMMAND "${CXX}" -std=c++20 -E -P -x c++ -isystem "${EIGEN}" -I "${ROOT}/include"
            -include "${header}" /dev/null
    OUTPUT_VARIABLE text
    COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE "\n[ \t\n]+" "\n" text "${text}")
  string(REGEX MATCHALL "\n" ends "${text}")
  list(LENGTH ends count)
  set(${out} ${count} PARENT_SCOPE)
endfunction()

preprocessed_lines("Eigen/Geometry" eigen)
preprocessed_lines("bristle/bristle.hpp" all)
math(EXPR own "${all} - ${eigen}")
message(STATUS "bristle.hpp: ${all} lines, ${own} of them on top of Eigen; budget ${BUDGET}")
if(all GREATER BUDGET)
  message(FATAL_ERROR "over budget: find the header that drags in so much")
endif()
