# Tests single_include/amalgamate.cmake on small trees: the good one gives exactly the text kept
# beside it, and each bad one is refused for its own reason.
# Usage: cmake -DAMALGAMATE=<amalgamate.cmake> -DFIXTURES=<folder> -DWORK=<scratch> -P ...
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

# Runs the script on a fixture; fails unless it says what the regular expression `says` asks for and
# succeeds or fails as `wanted` ("success" or "failure").
function(expect wanted says fixture)
  execute_process(
    COMMAND "${CMAKE_COMMAND}" "-DROOT=${FIXTURES}/${fixture}" ${ARGN} -P "${AMALGAMATE}"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")  # CMake wraps its messages
  set(got "failure")
  if(result EQUAL 0)
    set(got "success")
  endif()
  if(NOT got STREQUAL wanted OR NOT output MATCHES "${says}")
    message(FATAL_ERROR "${fixture} ${ARGN}: wanted ${wanted} and \"${says}\", got ${got}:\n${output}")
  endif()
endfunction()

expect(success "up to date" good -DCHECK=ON)

file(READ "${FIXTURES}/good/single_include/bristle/bristle.hpp" text)
string(REPLACE "return a[0]" "return a[1]" text "${text}")
file(WRITE "${WORK}/stale.hpp" "${text}")
expect(failure "stale" good -DCHECK=ON "-DOUTPUT=${WORK}/stale.hpp")
expect(failure "stale" good -DCHECK=ON "-DOUTPUT=${WORK}/never_written.hpp")

expect(failure "put it before the #if" misordered "-DOUTPUT=${WORK}/misordered.hpp")
expect(failure "from the first column" indented "-DOUTPUT=${WORK}/indented.hpp")
