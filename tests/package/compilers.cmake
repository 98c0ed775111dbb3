# The headers as a host's own: included by -I, not as a system's, under its warnings and in its
# language. Every g++ from 11 and clang++ from 14 that is installed checks compilers/host.cpp, which
# makes a world with a patch; nothing is linked or run. The newest clang has all its warnings on.
# Usage: cmake -DROOT=<tree> -DEIGEN=<include dir> [-DWITH_FCL=ON] [-DWITH_ADF=ON]
#              [-DONLY=<regex of checks>] [-DFLAGS=<flags>] -P compilers.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

# What a strict host asks of g++ and clang alike.
set(strict -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wfloat-conversion -Wshadow
           -Wundef -Wold-style-cast -Wdouble-promotion -Wimplicit-fallthrough -Wnon-virtual-dtor
           -Woverloaded-virtual -Wcast-qual -Wunused)

# Everything that clang knows but for what does not apply:
set(everything -Weverything)
# A version without one of these has nothing to turn off.
list(APPEND everything -Wno-unknown-warning-option)
# C++20 is what the library is for.
list(APPEND everything -Wno-c++98-compat -Wno-c++98-compat-pedantic -Wno-c++20-compat)
# Says where structures have gaps; none here is written to a file as it lies in memory.
list(APPEND everything -Wno-padded)
# Wants containers for every pointer; kernels walk over rows that others own.
list(APPEND everything -Wno-unsafe-buffer-usage)
# Comparisons with 0, and of numbers that are to be the same bits, are meant.
list(APPEND everything -Wno-float-equal)
# The first wants a default where all values are handled, which -Wcovered-switch-default, on here,
# forbids; the second wants the values that a default handles, as it does those of FCL.
list(APPEND everything -Wno-switch-default -Wno-switch-enum)
# Doxygen lets one @param name several parameters, clang does not.
list(APPEND everything -Wno-documentation)
# Exceptions of a header-only library have their tables in every file.
list(APPEND everything -Wno-weak-vtables)
# Clang before 16 sees a null pointer in its own `operator<=> = default`.
list(APPEND everything -Wno-zero-as-null-pointer-constant)
# Declared only, definitions are in the compiled library.
set(declared_everything ${everything} -Wno-undefined-func-template)

set(no_exceptions -fno-exceptions -fno-rtti)
set(declared -DBRISTLE_COMPILED)

# Checks host.cpp by `compiler` with the flags in ARGN. Without -fsyntax-only all would take three
# times as long, and say no more: templates are instantiated.
set(failures 0)
set(checks 0)
function(check name compiler)
  if(DEFINED ONLY AND NOT name MATCHES "${ONLY}")
    return()
  endif()
  string(TIMESTAMP begin "%s")
  execute_process(
    COMMAND "${compiler}" -fsyntax-only -O0 -Werror ${ARGN} ${FLAGS} "-I${ROOT}/include"
            -isystem "${EIGEN}" "${CMAKE_CURRENT_LIST_DIR}/compilers/host.cpp"
    RESULT_VARIABLE result ERROR_VARIABLE errors)
  string(TIMESTAMP end "%s")
  math(EXPR seconds "${end} - ${begin}")
  math(EXPR count "${checks} + 1")
  set(checks ${count} PARENT_SCOPE)
  if(result EQUAL 0)
    message(STATUS "${name}: no warning, ${seconds} s")
  else()
    string(SUBSTRING "${errors}" 0 4000 errors)
    message(NOTICE "${name}: failed\n${errors}")
    math(EXPR count "${failures} + 1")
    set(failures ${count} PARENT_SCOPE)
  endif()
endfunction()

# Sets `out` to the compilers called `name` or `name`-<number>, newest first, each version once, as
# <version>|<path>. Older ones than `oldest` are left out with a message.
function(find_compilers name oldest out)
  set(found "")
  set(versions "")
  set(files "${name}")
  foreach(number RANGE 9 30)
    list(APPEND files "${name}-${number}")
  endforeach()
  foreach(file IN LISTS files)
    find_program(compiler "${file}" NO_CACHE)
    if(compiler)
      execute_process(COMMAND "${compiler}" -dumpfullversion -dumpversion
                      OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
      if(version VERSION_LESS oldest)
        message(STATUS "${file} ${version}: older than ${oldest}, so it is left out")
      elseif(NOT version IN_LIST versions)
        list(APPEND versions "${version}")
        list(APPEND found "${version}|${compiler}")
      endif()
    endif()
    unset(compiler)
  endforeach()
  list(SORT found COMPARE NATURAL ORDER DESCENDING)
  set(${out} "${found}" PARENT_SCOPE)
endfunction()

# The name by which a compiler knows C++23; empty if it does not.
function(name_of_cxx23 compiler out)
  foreach(standard c++23 c++2b)
    execute_process(COMMAND "${compiler}" -std=${standard} -fsyntax-only -x c++ /dev/null
                    RESULT_VARIABLE result ERROR_QUIET)
    if(result EQUAL 0)
      set(${out} ${standard} PARENT_SCOPE)
      return()
    endif()
  endforeach()
  set(${out} "" PARENT_SCOPE)
endfunction()

find_compilers(g++ 11 gnu)
find_compilers(clang++ 14 clang)
if(NOT gnu AND NOT clang)
  message(FATAL_ERROR "neither g++ nor clang++ is installed")
endif()

foreach(entry IN LISTS gnu clang)
  string(REPLACE "|" ";" entry "${entry}")
  list(GET entry 0 version)
  list(GET entry 1 compiler)
  cmake_path(GET compiler FILENAME name)
  set(name "${name} ${version}")
  name_of_cxx23("${compiler}" cxx23)
  check("${name}, C++20, declared" "${compiler}" -std=c++20 ${strict} ${declared})
  check("${name}, C++20, declared, no exceptions" "${compiler}" -std=c++20 ${strict} ${declared}
        ${no_exceptions})
  if(cxx23)
    check("${name}, C++23, declared" "${compiler}" -std=${cxx23} ${strict} ${declared})
    check("${name}, C++23, header-only" "${compiler}" -std=${cxx23} ${strict})
  endif()
endforeach()

if(clang)
  list(GET clang 0 entry)
  string(REGEX REPLACE "^.*\\|" "" compiler "${entry}")
  cmake_path(GET compiler FILENAME name)
  check("${name}, C++20, header-only, no exceptions" "${compiler}" -std=c++20 ${strict}
        ${no_exceptions})
  set(all -DHOST_IN_FLOAT -DBRISTLE_WITH_THREADS -DBRISTLE_WITH_FILES)
  if(WITH_FCL)
    list(APPEND all -DBRISTLE_WITH_FCL)
  endif()
  if(WITH_ADF)
    list(APPEND all -DHOST_WITH_ADF)
  endif()
  check("${name}, C++20, declared, all warnings" "${compiler}" -std=c++20 ${declared_everything}
        ${declared} ${all})
  check("${name}, C++20, header-only, all warnings" "${compiler}" -std=c++20 ${everything} ${all})
endif()

if(checks EQUAL 0)
  message(FATAL_ERROR "no check matches '${ONLY}'")
endif()
if(failures)
  message(FATAL_ERROR "${failures} of ${checks} checks failed")
endif()
message(STATUS "${checks} checks, no warning")
