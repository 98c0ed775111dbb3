# Reading and applying a .mutant file: a bug to plant, and the tests that must notice it.
#
#   A sentence on the bug, and why nobody would see it in review.
#
#   header  sensors/law.hpp
#   tests   physics/incline_hold_test.cpp physics/momentum_test.cpp
#   filter  *momentum*
#   <<<<<<<
#   text that stands exactly once in the header
#   =======
#   what stands there instead
#   >>>>>>>
#
# `header` is relative to include/bristle, `tests` (of one group) to tests/. `filter` is doctest's
# --test-case, `*` for all. As a script this applies a mutant:
#   cmake -DMUTANT=<file> -DINCLUDE=<include> -DOUTPUT=<mutated header> -P mutant.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

# Sets mutant_header, mutant_tests (a list), mutant_filter, mutant_old and mutant_new.
function(read_mutant file)
  file(READ "${file}" text)
  set(position 0)
  foreach(mark "\n<<<<<<<\n" "\n=======\n" "\n>>>>>>>\n")
    string(FIND "${text}" "${mark}" at)
    string(FIND "${text}" "${mark}" last REVERSE)
    math(EXPR length "${at} - ${position}")
    if(length EQUAL -1)
      set(length 0)  # nothing between two marks, which then share a newline
    endif()
    if(length LESS 0 OR NOT at EQUAL last)
      message(FATAL_ERROR "${file}: must have the lines <<<<<<<, =======, >>>>>>> once, in this order")
    endif()
    string(SUBSTRING "${text}" ${position} ${length} part)
    list(APPEND parts_at ${position} ${length})
    math(EXPR position "${at} + 9")  # the length of a mark
  endforeach()
  foreach(part head old new)
    list(POP_FRONT parts_at begin length)
    string(SUBSTRING "${text}" ${begin} ${length} ${part})
  endforeach()

  foreach(key header tests filter)
    if(NOT "\n${head}\n" MATCHES "\n${key} +([^\n]+)\n")
      message(FATAL_ERROR "${file}: no line `${key} ...`")
    endif()
    string(STRIP "${CMAKE_MATCH_1}" ${key})
  endforeach()
  string(REGEX REPLACE " +" ";" tests "${tests}")

  set(mutant_header "${header}" PARENT_SCOPE)
  set(mutant_tests "${tests}" PARENT_SCOPE)
  set(mutant_filter "${filter}" PARENT_SCOPE)
  set(mutant_old "${old}" PARENT_SCOPE)
  set(mutant_new "${new}" PARENT_SCOPE)
endfunction()

if(DEFINED MUTANT)
  read_mutant("${MUTANT}")
  file(READ "${INCLUDE}/bristle/${mutant_header}" text)
  string(FIND "${text}" "${mutant_old}" at)
  string(FIND "${text}" "${mutant_old}" last REVERSE)
  if(at EQUAL -1 OR NOT at EQUAL last)
    message(FATAL_ERROR "${MUTANT}: its text must stand exactly once in ${mutant_header}")
  endif()
  string(LENGTH "${mutant_old}" length)
  string(SUBSTRING "${text}" 0 ${at} before)
  math(EXPR at "${at} + ${length}")
  string(SUBSTRING "${text}" ${at} -1 after)
  file(WRITE "${OUTPUT}" "${before}${mutant_new}${after}")
endif()
