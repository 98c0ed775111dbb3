# Examples of one file need no other header than the single one: each is compiled against it,
# declared only. Those with scene files or a renderer need io/adf.hpp or io/drawn_world.hpp, which
# are not in it. g++ finds the header compiled before the header itself, once for each set of flags.
# Those in EXCEPT are compiled elsewhere.
# Usage: cmake -DROOT=<tree> -DCXX=<compiler> -DEIGEN=<include dir> -DWORK=<folder>
#              -DEXCEPT=<names> -P single_examples.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

# precompile(FOLDER FLAGS...)  compiles the header into a folder, unless it is there.
function(precompile folder)
  set(header "${folder}/bristle/bristle.hpp.gch")
  if(EXISTS "${header}")
    return()
  endif()
  file(MAKE_DIRECTORY "${folder}/bristle")
  execute_process(
    COMMAND "${CXX}" -std=c++20 ${ARGN} -isystem "${EIGEN}" -x c++-header
            "${ROOT}/single_include/bristle/bristle.hpp" -o "${header}"
    COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE "${WORK}")
file(GLOB examples "${ROOT}/examples/*.cpp")
set(failed "")
set(count 0)
foreach(example IN LISTS examples)
  file(STRINGS "${example}" opts_in REGEX "^#include <bristle/io/(adf|drawn_world)")
  cmake_path(GET example STEM name)
  if(opts_in OR name IN_LIST EXCEPT)
    continue()
  endif()
  # Backends and scalars of their own.
  set(flags -DBRISTLE_COMPILED)
  set(compiled "${WORK}/declared")
  if(example MATCHES "own_backend|gradients")
    list(APPEND flags -DBRISTLE_WITH_DEFINITIONS)
    set(compiled "${WORK}/defined")
  endif()
  precompile("${compiled}" ${flags})
  execute_process(
    COMMAND "${CXX}" -std=c++20 -fsyntax-only ${flags} "-I${compiled}" "-I${ROOT}/single_include"
            "-I${ROOT}/examples" -isystem "${EIGEN}" "${example}"
    RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(APPEND failed "${example}")
  endif()
  math(EXPR count "${count} + 1")
endforeach()
if(failed OR count EQUAL 0)
  message(FATAL_ERROR "not against the single header: ${failed}")
endif()
message(STATUS "${count} examples against the single header")
