# Tests a rule on a fixture that breaks it: the script must fail and report exactly the lines that
# hold the word "planted" (with WHOLE_FILES: line 1 of exactly the files that do).
# Usage: cmake -DSCRIPT=<rule>.cmake -DROOT=<fixture> [-DWHOLE_FILES=ON] [-DMAX_LINES=n]
#        [-DMAX_WORDS=n] -P catches.cmake
# SPDX-License-Identifier: BSD-3-Clause
include("${CMAKE_CURRENT_LIST_DIR}/lines.cmake")

set(expected "")
list_files(files "*.hpp" "*.cpp" "*.md")
foreach(file IN LISTS files)
  set(number 0)
  read_lines("${ROOT}/${file}" lines)
  foreach(line IN LISTS lines)
    math(EXPR number "${number} + 1")
    if(line MATCHES "planted")
      if(WHOLE_FILES)
        set(number 1)
      endif()
      list(APPEND expected "${file}:${number}")
    endif()
  endforeach()
endforeach()
if(NOT expected)
  message(FATAL_ERROR "${ROOT} plants nothing")
endif()

set(definitions "")
foreach(bound MAX_LINES MAX_WORDS)
  if(DEFINED ${bound})
    list(APPEND definitions "-D${bound}=${${bound}}")
  endif()
endforeach()
execute_process(
  COMMAND "${CMAKE_COMMAND}" "-DROOT=${ROOT}" ${definitions} -P
          "${CMAKE_CURRENT_LIST_DIR}/${SCRIPT}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
string(REGEX MATCHALL "[A-Za-z0-9_/-]+\\.([hc]pp|md):[0-9]+: " reported "${output}")
list(TRANSFORM reported REPLACE ": $" "")
list(REMOVE_DUPLICATES reported)
list(SORT reported)
list(SORT expected)
if(result EQUAL 0 OR NOT reported STREQUAL expected)
  message(FATAL_ERROR "planted:  ${expected}\nreported: ${reported}\nexit code ${result}\n${output}")
endif()
list(LENGTH expected count)
message(STATUS "${SCRIPT} reports each of ${count} planted violations and nothing else")
