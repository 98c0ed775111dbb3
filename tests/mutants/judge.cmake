# Passes if the tests are green without the mutant and red with it.
# Usage: cmake -DSOUND=<program> -DMUTATED=<program> -DFILES=<doctest filter> -DFILTER=<doctest
#        filter> -P judge.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

function(run program result_out output_out)
  execute_process(
    COMMAND "${program}" "--source-file=${FILES}" "--test-case=${FILTER}"
    TIMEOUT 300  # a mutant that hangs is noticed too
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(${result_out} "${result}" PARENT_SCOPE)
  set(${output_out} "${output}" PARENT_SCOPE)
endfunction()

run("${SOUND}" sound output)
if(NOT sound EQUAL 0)
  message(FATAL_ERROR "red without the mutant already:\n${output}")
elseif(output MATCHES "test cases: +0 ")
  message(FATAL_ERROR "no test case matches ${FILTER} in ${FILES}")
endif()
run("${MUTATED}" mutated output)
if(mutated EQUAL 0)
  message(FATAL_ERROR "the mutant lives: no test noticed it\n${output}")
endif()
string(REGEX MATCH "[^\n]*test cases:[^\n]*" summary "${output}")
message(STATUS "noticed: ${summary}")
