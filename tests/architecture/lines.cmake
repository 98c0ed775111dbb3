# What the architecture scripts share: files as lists of lines, and one way to report.
#
# A script is called with -DROOT=<tree>; it reports every violation as `path:line: what is wrong`,
# with the path relative to ROOT, and then fails.
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

# CMake lists give [ ] ; and \ a meaning, so in lines these stand for them.
string(ASCII 1 OPEN)
string(ASCII 2 CLOSE)
string(ASCII 3 SEMICOLON)
string(ASCII 4 BACKSLASH)

# Sets `out` to the lines of a file.
function(read_lines file out)
  file(READ "${file}" text)
  string(REPLACE "[" "${OPEN}" text "${text}")
  string(REPLACE "]" "${CLOSE}" text "${text}")
  string(REPLACE ";" "${SEMICOLON}" text "${text}")
  string(REPLACE "\\" "${BACKSLASH}" text "${text}")
  string(REPLACE "\n" ";" text "${text}")
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

# Sets `out` to the files under ROOT that match the globs, relative to ROOT, in a fixed order.
function(list_files out)
  list(TRANSFORM ARGN PREPEND "${ROOT}/")
  file(GLOB_RECURSE files RELATIVE "${ROOT}" ${ARGN})
  list(FILTER files EXCLUDE REGEX "architecture/fixtures/")
  list(SORT files)
  set(${out} "${files}" PARENT_SCOPE)
endfunction()

set_property(GLOBAL PROPERTY violations 0)
function(violation where what)
  get_property(count GLOBAL PROPERTY violations)
  math(EXPR count "${count} + 1")
  set_property(GLOBAL PROPERTY violations ${count})
  message(NOTICE "${where}: ${what}")
endfunction()

# Ends a script: fails if there were violations, and says how much was looked at.
function(conclude summary)
  get_property(count GLOBAL PROPERTY violations)
  if(count GREATER 0)
    message(FATAL_ERROR "${count} violation(s) in ${summary}")
  endif()
  message(STATUS "no violation in ${summary}")
endfunction()
