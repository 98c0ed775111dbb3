# What pkg-config says of the installed package is enough to build and run programs, also after the
# package was moved.
# Usage: cmake -DPREFIX=<installed> -DWORK=<folder> -DCXX=<compiler> -DVERSION=<version>
#              [-DHAS_FCL=1] [-DHAS_COMPILED=1] [-DHAS_ADF=1] -P pkg_config.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

find_program(pkg_config NAMES pkg-config pkgconf)
if(NOT pkg_config)
  message(STATUS "left out: pkg-config is not installed")
  return()
endif()

# Nothing may lead back to the prefix that it was installed to.
set(moved "${WORK}/moved")
file(REMOVE_RECURSE "${moved}")
file(MAKE_DIRECTORY "${WORK}")
file(COPY "${PREFIX}/" DESTINATION "${moved}")
file(GLOB_RECURSE files "${moved}/*.pc")
set(folders "")
foreach(file IN LISTS files)
  file(READ "${file}" text)
  if(text MATCHES "${PREFIX}|[=ILl ]/")
    message(FATAL_ERROR "${file} names an absolute path:\n${text}")
  endif()
  cmake_path(GET file PARENT_PATH folder)
  list(APPEND folders "${folder}")
endforeach()
list(REMOVE_DUPLICATES folders)
list(JOIN folders ":" folders)
set(ENV{PKG_CONFIG_PATH} "${folders}")

# Sets `out` to what pkg-config says.
function(ask out)
  execute_process(
    COMMAND "${pkg_config}" ${ARGN}
    OUTPUT_VARIABLE text OUTPUT_STRIP_TRAILING_WHITESPACE
    COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(text UNIX_COMMAND "${text}")
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

# Compiles `source` with what pkg-config says of the packages in ARGN, and runs it.
function(build_and_run name source)
  ask(flags --cflags --libs ${ARGN})
  execute_process(
    COMMAND "${CXX}" -std=c++20 -O0 "${CMAKE_CURRENT_LIST_DIR}/${source}" -o "${WORK}/${name}"
            ${flags} "-Wl,-rpath,${moved}/lib"
    COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND "${WORK}/${name}" COMMAND_ERROR_IS_FATAL ANY)
endfunction()

ask(version --modversion bristle)
if(NOT version STREQUAL "${VERSION}")
  message(FATAL_ERROR "bristle.pc has version ${version}, the library ${VERSION}")
endif()
ask(flags --cflags --libs bristle)
if(flags MATCHES "BRISTLE_|-l")
  message(FATAL_ERROR "more than include folders for headers alone: ${flags}")
endif()

build_and_run(plain consumer.cpp bristle)
if(HAS_FCL)
  ask(flags --cflags bristle-fcl)
  if(NOT "-DBRISTLE_WITH_FCL" IN_LIST flags)
    message(FATAL_ERROR "bristle-fcl without BRISTLE_WITH_FCL: ${flags}")
  endif()
  build_and_run(fcl consumer.cpp bristle-fcl)
endif()
if(HAS_COMPILED)
  # World<double> has no definition here, unless it comes from the library.
  build_and_run(compiled world_consumer.cpp bristle-compiled)
endif()
if(HAS_COMPILED AND HAS_ADF)
  build_and_run(adf adf_consumer.cpp bristle-compiled-adf)
endif()
