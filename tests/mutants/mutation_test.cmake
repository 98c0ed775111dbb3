# Passes if tests are green without a mutant and red with it.
# Usage: cmake -DPROGRAM=<program> -DMUTANT=<name> -DFILES=<doctest filter> -DFILTER=<doctest filter>
#        -P mutation_test.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

# Runs the tests until one is red, in an environment that ARGN changes.
function(run result_out output_out)
  execute_process(
    COMMAND "${CMAKE_COMMAND}" -E env ${ARGN} "${PROGRAM}" "--source-file=${FILES}"
            "--test-case=${FILTER}" --abort-after=1
    TIMEOUT 300  # a mutant that hangs is killed too
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(${result_out} "${result}" PARENT_SCOPE)
  set(${output_out} "${output}" PARENT_SCOPE)
endfunction()

run(without output --unset=BRISTLE_MUTANT)
if(NOT without EQUAL 0)
  message(FATAL_ERROR "red without the mutant already:\n${output}")
elseif(output MATCHES "test cases: +0 ")
  message(FATAL_ERROR "no test case matches ${FILTER} in ${FILES}")
endif()
run(with output "BRISTLE_MUTANT=${MUTANT}")
if(with EQUAL 0)
  message(FATAL_ERROR "the mutant survives\n${output}")
endif()
string(REGEX MATCH "[^\n]*test cases:[^\n]*" summary "${output}")
message(STATUS "killed: ${summary}")
