# Runs two programs, and fails unless they print the same, and something.
# Usage: cmake -DONE=<program> -DOTHER=<program> [-DSET=<instruction set>] -P same_bits.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

if(DEFINED SET)
  # ONE has instructions of this set: it runs only where OTHER can choose the set.
  execute_process(COMMAND "${OTHER}" OUTPUT_QUIET ERROR_VARIABLE error RESULT_VARIABLE result)
  if(error MATCHES "BRISTLE_INSTRUCTION_SET")
    message(STATUS "left out: this processor or this build lacks ${SET}")
    return()
  endif()
endif()
foreach(program ONE OTHER)
  execute_process(COMMAND "${${program}}" OUTPUT_VARIABLE said_by_${program}
                                          COMMAND_ERROR_IS_FATAL ANY)
endforeach()
if(NOT said_by_ONE MATCHES "chain of 4 bytes" OR NOT said_by_ONE STREQUAL said_by_OTHER)
  message(FATAL_ERROR "${ONE} says\n${said_by_ONE}${OTHER} says\n${said_by_OTHER}")
endif()
message(STATUS "${said_by_ONE}")
