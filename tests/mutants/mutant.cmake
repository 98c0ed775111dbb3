# Reading .mutant files, and putting their mutants into headers. A mutant is a small bug; its mutation
# test passes if the tests that it names kill it: they are green without it and red with it.
#
#   A sentence on the bug, and why nobody would see it in review.
#
#   header  sensors/law.hpp
#   tests   physics/incline_hold_test.cpp physics/conservation_test.cpp
#   filter  *momentum*
#   <<<<<<<
#   const S limit = def.max_force * dt;
#   =======
#   const S limit = MUTANT ? def.max_force : def.max_force * dt;
#   >>>>>>>
#
# `header` is relative to include/bristle, `tests` to tests/. `filter` is doctest's --test-case, `*`
# for all. The first text stands exactly once in the header, in which the second takes its place.
# MUTANT is a bool, true in the runs that switch the mutant on: all mutants are compiled together, so
# where it is false the second text must do what the first does. It is no constant expression.
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
    if(length LESS 0 OR NOT at EQUAL last)
      message(FATAL_ERROR "${file}: must have the lines <<<<<<<, =======, >>>>>>> once, in this order, \
with text between them")
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

# Sets `headers_out` to the headers that the mutants of the remaining arguments are for, and for each
# of them `mutants_of_<header>` to its .mutant files.
function(sort_mutants headers_out)
  set(headers "")
  foreach(file IN LISTS ARGN)
    read_mutant("${file}")
    list(APPEND headers "${mutant_header}")
    list(APPEND files_${mutant_header} "${file}")
    set(mutants_of_${mutant_header} "${files_${mutant_header}}" PARENT_SCOPE)
  endforeach()
  list(REMOVE_DUPLICATES headers)
  set(${headers_out} "${headers}" PARENT_SCOPE)
endfunction()

# Sets `text_out` to the text of `header`, a path, with the mutants of the remaining arguments in it,
# and `faults_out` to what is wrong with these: every mutant is for the text as it stands in the
# header, so no two may be for the same part of it.
function(put_mutants_in header text_out faults_out)
  file(READ "${header}" text)
  set(faults "")
  set(switches "")
  set(starts "")
  foreach(file IN LISTS ARGN)
    read_mutant("${file}")
    cmake_path(GET file STEM name)
    string(FIND "${text}" "${mutant_old}" start)
    string(FIND "${text}" "${mutant_old}" last REVERSE)
    if(start EQUAL -1 OR NOT start EQUAL last)
      string(APPEND faults "${file}: must stand exactly once in ${header}:\n${mutant_old}\n")
      continue()
    endif()
    if(NOT mutant_new MATCHES "MUTANT")
      string(APPEND faults "${file}: its new text has no MUTANT\n")
    endif()
    string(LENGTH "${mutant_old}" length)
    math(EXPR end "${start} + ${length}")
    foreach(other IN LISTS starts)
      if(start LESS end_${other} AND other LESS end)
        string(APPEND faults "${file}: overlaps with mutant ${name_${other}} in ${header}:\n"
               "${mutant_old}\n")
      endif()
    endforeach()
    list(APPEND starts ${start})
    set(end_${start} ${end})
    set(name_${start} ${name})
    string(REPLACE "MUTANT" "::bristle_mutants::${name}" new_${start} "${mutant_new}")
    string(APPEND switches "inline const bool ${name} = is_on(\"${name}\");\n")
  endforeach()

  # From the last one to the first, so that those before stay where they are.
  list(SORT starts COMPARE NATURAL ORDER DESCENDING)
  foreach(start IN LISTS starts)
    string(SUBSTRING "${text}" 0 ${start} before)
    string(SUBSTRING "${text}" ${end_${start}} -1 after)
    set(text "${before}${new_${start}}${after}")
  endforeach()
  set(${text_out} "#include \"mutants/switch.hpp\"\nnamespace bristle_mutants {\n${switches}}\n${text}"
      PARENT_SCOPE)
  set(${faults_out} "${faults}" PARENT_SCOPE)
endfunction()
