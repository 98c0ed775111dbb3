# What the umbrella header costs those who include it: its lines of code after preprocessing, and,
# where the compiler says so, what it allocates for the declarations of compiled mode.
# Usage: cmake -DCXX=<compiler> -DROOT=<tree> -DEIGEN=<include dir> [-DBUDGET=LINES] [-DRATIO=PERCENT]
#        -P budget.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

if(NOT DEFINED BUDGET)
  # Eigen/Geometry alone is about 99000, with the standard headers 120000; the rest is our own. A
  # header that drags in too much costs thousands, code that is needed may cost some hundreds.
  set(BUDGET 144200)
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

# g++ counts what it allocates: the same in every run, and in step with time and memory. Eigen's part
# stands for the version of the compiler.
execute_process(COMMAND "${CXX}" --version OUTPUT_VARIABLE version)
if(NOT version MATCHES "Free Software Foundation")
  message(STATUS "compiler does not count allocations: that part is skipped")
  return()
endif()
if(NOT DEFINED RATIO)
  # [%] One instance of a singular value decomposition in a header was 3 s and 410 %.
  set(RATIO 185)
endif()

# Sets `out` to the MB that the compiler allocates to read a header.
function(allocated_megabytes header out)
  execute_process(
    COMMAND "${CXX}" -std=c++20 -fsyntax-only -ftime-report -DBRISTLE_COMPILED -x c++ -isystem
            "${EIGEN}" -I "${ROOT}/include" -include "${header}" /dev/null
    ERROR_VARIABLE report
    COMMAND_ERROR_IS_FATAL ANY)
  if(NOT report MATCHES "TOTAL[^\n]* ([0-9]+)M\n")
    message(FATAL_ERROR "cannot find what was allocated in the compiler's report:\n${report}")
  endif()
  set(${out} ${CMAKE_MATCH_1} PARENT_SCOPE)
endfunction()

allocated_megabytes("Eigen/Geometry" eigen)
allocated_megabytes("bristle/bristle.hpp" all)
math(EXPR ratio "100 * ${all} / ${eigen}")
message(STATUS "bristle.hpp, declared: ${all} MB allocated, Eigen ${eigen} MB; ratio ${ratio} %, budget ${RATIO} %")
if(ratio GREATER RATIO)
  message(FATAL_ERROR "allocates too much: find the header whose functions are instantiated by those who only include it")
endif()
