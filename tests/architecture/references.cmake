# Paths in comments and pages exist: every path `docs/...`, `tests/...`, `examples/...` or `include/...`
# with an extension that a file names, from the root of the tree. Links of pages: documents.cmake.
# Usage: cmake -DROOT=<tree> -P references.cmake
# SPDX-License-Identifier: BSD-3-Clause
include("${CMAKE_CURRENT_LIST_DIR}/lines.cmake")

set(reference "(docs|tests|examples|include)/[A-Za-z0-9_./-]+\\.(md|hpp|cpp|cmake|sh|svg|yaml|mutant)")
# Counts the paths among `ARGN`, and reports those that lead nowhere.
function(check_references place)
  foreach(path IN LISTS ARGN)
    math(EXPR count "${count} + 1")
    if(NOT EXISTS "${ROOT}/${path}")
      violation("${place}" "no ${path}")
    endif()
  endforeach()
  set(count ${count} PARENT_SCOPE)
endfunction()

set(count 0)
list_files(files "README.md" "docs/*.md" "include/*.hpp" "tests/*.hpp" "tests/*.cpp"
           "tests/CMakeLists.txt" "examples/*.hpp" "examples/*.cpp")
foreach(file IN LISTS files)
  set(number 0)
  read_lines("${ROOT}/${file}" lines)
  foreach(line IN LISTS lines)
    math(EXPR number "${number} + 1")
    # Paths of other trees, and of what a build makes, have something before the folder.
    string(REGEX MATCHALL "(^|[^A-Za-z0-9_./}-])${reference}" paths "${line}")
    list(TRANSFORM paths REPLACE "^[^a-z]" "")
    check_references("${file}:${number}" ${paths})
  endforeach()
endforeach()
conclude("${count} references")
