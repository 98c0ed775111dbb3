# What every file has: a licence line and a bounded length; headers also #pragma once, those of the
# library and of tests `/// @file` on top, and those of the library a place in the umbrella, but for
# io/adf.hpp, io/adf/, io/drawn_world.hpp and hosts/<engine>_*.hpp, which are opt-in. What no file has: what clang 14 cannot precompile, and, in tests that
# are compiled together, a helper that another file has: the call would take whichever fits better;
# and doctest's Approx of a number that is not 0, which lets pass whatever is small.
# Usage: cmake -DROOT=<tree> [-DMAX_LINES=600] -P form.cmake
# SPDX-License-Identifier: BSD-3-Clause
include("${CMAKE_CURRENT_LIST_DIR}/lines.cmake")

if(NOT DEFINED MAX_LINES)
  set(MAX_LINES 600)
endif()

set(umbrella "include/bristle/bristle.hpp")
file(READ "${ROOT}/${umbrella}" umbrella_text)

list_files(files "include/*.hpp" "tests/*.hpp" "tests/*.cpp" "tests/*.cmake" "tests/CMakeLists.txt"
           "examples/*.hpp" "examples/*.cpp" "examples/CMakeLists.txt")
list(LENGTH files file_count)
foreach(file IN LISTS files)
  file(READ "${ROOT}/${file}" text)
  read_lines("${ROOT}/${file}" lines)
  list(LENGTH lines length)
  math(EXPR length "${length} - 1")  # what follows the last newline is no line
  if(length GREATER MAX_LINES)
    violation("${file}:1" "longer than ${MAX_LINES} lines: make it two files")
  endif()
  if(NOT text MATCHES "(//|#) SPDX-License-Identifier: BSD-3-Clause\n")
    violation("${file}:1" "no line `SPDX-License-Identifier: BSD-3-Clause`")
  endif()
  if(text MATCHES "[<,][ \n]*template *<([A-Z]|[a-z_]+::)")
    violation("${file}:1" "a template parameter of constrained templates: clang 14 crashes where it \
writes one into a precompiled header")
  endif()
  if(text MATCHES "doctest::Approx\\(([^0]|0\\.?[0-9]*[1-9])" AND
     NOT file STREQUAL "tests/support/relative.hpp")
    violation("${file}:1" "doctest::Approx of a number that is not 0: any small number equals it; use \
test::relative")
  endif()
  if(text MATCHES "\nnamespace {\n" AND file MATCHES "^tests/([a-z]+)/.+_test\\.cpp$")
    set(group "${CMAKE_MATCH_1}")
    string(FIND "${text}" "\nnamespace {\n" first)
    string(FIND "${text}" "\n}  // namespace\n" last)
    math(EXPR length "${last} - ${first}")
    string(SUBSTRING "${text}" ${first} ${length} helpers)
    string(REPLACE ";" "," helpers "${helpers}")
    string(REGEX MATCHALL "\n[A-Za-z][A-Za-z0-9_:<>,&* ]* [a-z_][A-Za-z0-9_]*\\(" helpers "${helpers}")
    string(REGEX REPLACE "\n[^;]* ([a-z_][A-Za-z0-9_]*)\\(" "\\1" helpers "${helpers}")
    list(REMOVE_DUPLICATES helpers)
    foreach(helper IN LISTS helpers)
      if(DEFINED home_${group}_${helper})
        violation("${file}:1" "`${helper}` is a helper of ${home_${group}_${helper}}, too: tests are \
compiled together, so another name")
      endif()
      set(home_${group}_${helper} "${file}")
    endforeach()
  endif()
  if(file MATCHES "\\.hpp$")
    if(NOT text MATCHES "\n#pragma once\n")
      violation("${file}:1" "no #pragma once")
    endif()
    if(NOT file MATCHES "^examples/" AND NOT text MATCHES "^/// @file\n///? [A-Z]")
      violation("${file}:1" "must open with `/// @file` and a sentence on what it is")
    endif()
  endif()
  if(file MATCHES "^include/(.+)$" AND NOT file STREQUAL umbrella)
    string(FIND "${umbrella_text}" "\n#include <${CMAKE_MATCH_1}>\n" at)
    # kernel_tables.hpp is between the files of the compiled library.
    if(at EQUAL -1 AND NOT file MATCHES "/(io/adf|io/adf/[a-z_]+|io/drawn_world|hosts/(mujoco|bullet|ode|dart|engine)_[a-z_]+|core/kernel_tables)\\.hpp$")
      violation("${file}:1" "not included by ${umbrella}")
    endif()
  endif()
endforeach()
conclude("${file_count} files")
