# Writes the whole library as one header.
#
#   cmake -P single_include/amalgamate.cmake                 writes single_include/bristle/bristle.hpp
#   cmake -DCHECK=ON -P single_include/amalgamate.cmake      fails if that file is stale
#
# ROOT (default: the project) holds include/ and LICENSE; OUTPUT is the file written or checked.
# First comes what headers declare, then, under one `#if BRISTLE_HAS_DEFINITIONS`, what they define:
# the blocks under that condition, each of which includes what it needs.
# The text is handled whole, by FIND and SUBSTRING: CMake lists would lose lines with [ ] or ; in
# them. No date and no path goes in, so the same headers give the same bytes anywhere.
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

if(NOT DEFINED ROOT)
  cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH ROOT)
endif()
if(NOT DEFINED OUTPUT)
  set(OUTPUT "${ROOT}/single_include/bristle/bristle.hpp")
endif()

set(definitions_begin "\n#if BRISTLE_HAS_DEFINITIONS\n")
set_property(GLOBAL PROPERTY deferred_count 0)

function(emit text)
  set_property(GLOBAL APPEND_STRING PROPERTY amalgamation "${text}")
endfunction()

# Splits a text that begins within an #if at the end of that: `inside` and what comes after.
function(split_at_endif text inside_out after_out)
  set(inside "")
  set(depth 1)
  while(depth GREATER 0)
    string(FIND "${text}" "\n#if" opens)
    string(FIND "${text}" "\n#endif" closes)
    if(closes EQUAL -1)
      message(FATAL_ERROR "an #if without an #endif")
    endif()
    if(opens GREATER -1 AND opens LESS closes)
      math(EXPR depth "${depth} + 1")
      math(EXPR length "${opens} + 4")
    else()
      math(EXPR depth "${depth} - 1")
      set(length ${closes})
      if(depth GREATER 0)
        math(EXPR length "${closes} + 7")
      endif()
    endif()
    string(SUBSTRING "${text}" 0 ${length} head)
    string(SUBSTRING "${text}" ${length} -1 text)
    string(APPEND inside "${head}")
  endwhile()
  string(SUBSTRING "${text}" 7 -1 text)  # 7 characters in "\n#endif"
  set(${inside_out} "${inside}" PARENT_SCOPE)
  set(${after_out} "${text}" PARENT_SCOPE)
endfunction()

# Emits a text with its <bristle/...> includes in place. `condition` is the #if line that surrounds
# it, or empty.
function(inline_text text condition)
  while(TRUE)
    string(FIND "${text}" "\n#include <bristle/" at)
    string(FIND "${text}" "\n#if" opens)
    if(at EQUAL -1)
      break()
    endif()
    if(opens GREATER -1 AND opens LESS at)
      # All of an #if at once, since what is included within it is there only with its condition.
      math(EXPR begin "${opens} + 1")
      string(SUBSTRING "${text}" 0 ${begin} head)
      string(SUBSTRING "${text}" ${begin} -1 text)
      string(FIND "${text}" "\n" end)
      string(SUBSTRING "${text}" 0 ${end} line)
      string(SUBSTRING "${text}" ${end} -1 text)
      split_at_endif("${text}" inside text)
      emit("${head}${line}")
      inline_text("${inside}" "${line}")
      emit("\n#endif")
    else()
      string(SUBSTRING "${text}" 0 ${at} head)
      string(SUBSTRING "${text}" ${at} -1 text)
      string(FIND "${text}" ">" close)
      math(EXPR length "${close} - 11")  # 11 characters in "\n#include <"
      string(SUBSTRING "${text}" 11 ${length} included)
      math(EXPR close "${close} + 1")
      string(SUBSTRING "${text}" ${close} -1 text)
      emit("${head}")
      inline_header("${included}" "${condition}")
    endif()
  endwhile()
  emit("${text}")
endfunction()

# Emits one header, at its first occurrence. What it defines waits until all is declared.
# `condition`: a header first met within an #if must not be needed outside, where it would be missing
# whenever the condition does not hold.
function(inline_header name condition)
  get_property(seen GLOBAL PROPERTY "seen ${name}")
  if(seen STREQUAL "conditional" AND condition STREQUAL "")
    message(FATAL_ERROR "${name}: first included inside an #if, then outside; put it before the #if")
  elseif(seen)
    return()
  endif()
  if(condition STREQUAL "")
    set_property(GLOBAL PROPERTY "seen ${name}" "always")
  else()
    set_property(GLOBAL PROPERTY "seen ${name}" "conditional")
  endif()

  if(NOT EXISTS "${ROOT}/include/${name}")
    message(FATAL_ERROR "include/${name}: no such header")
  endif()
  file(READ "${ROOT}/include/${name}" text)
  string(REPLACE "\n#pragma once\n" "\n" text "\n${text}")
  emit("\n// === ${name}\n")

  get_property(defers GLOBAL PROPERTY defers)
  string(FIND "${text}" "${definitions_begin}" at)
  if(NOT defers OR at EQUAL -1)
    inline_text("${text}" "${condition}")
    return()
  endif()
  string(SUBSTRING "${text}" 0 ${at} head)
  string(LENGTH "${definitions_begin}" length)
  math(EXPR at "${at} + ${length} - 1")
  string(SUBSTRING "${text}" ${at} -1 text)
  split_at_endif("${text}" definitions after)
  inline_text("${head}${after}" "${condition}")
  # After those of the headers that it includes.
  get_property(count GLOBAL PROPERTY deferred_count)
  set_property(GLOBAL PROPERTY "deferred ${count}" "\n// === ${name}: definitions${definitions}\n")
  set_property(GLOBAL PROPERTY "deferred condition ${count}" "${condition}")
  math(EXPR count "${count} + 1")
  set_property(GLOBAL PROPERTY deferred_count ${count})
endfunction()

file(READ "${ROOT}/LICENSE" license)
string(REPLACE "\n" "\n// " license "\n${license}")
string(REGEX REPLACE "[ \n/]+$" "" license "${license}")
string(REPLACE "\n// \n" "\n//\n" license "${license}")

emit("// bristle in one header. Generated by single_include/amalgamate.cmake: change include/, not this.
//${license}

// A guard, not #pragma once: online compilers include this file by URL.
#ifndef BRISTLE_SINGLE_INCLUDE
#define BRISTLE_SINGLE_INCLUDE
")
set_property(GLOBAL PROPERTY defers ON)
inline_header("bristle/bristle.hpp" "")
set_property(GLOBAL PROPERTY defers OFF)

emit("${definitions_begin}")
get_property(count GLOBAL PROPERTY deferred_count)
set(i 0)
while(i LESS count)
  get_property(text GLOBAL PROPERTY "deferred ${i}")
  get_property(condition GLOBAL PROPERTY "deferred condition ${i}")
  if(condition STREQUAL "")
    inline_text("${text}" "#if BRISTLE_HAS_DEFINITIONS")
  else()
    emit("\n${condition}\n")
    inline_text("${text}" "${condition}")
    emit("\n#endif\n")
  endif()
  math(EXPR i "${i} + 1")
endwhile()
emit("\n#endif  // BRISTLE_HAS_DEFINITIONS\n\n#endif  // BRISTLE_SINGLE_INCLUDE\n")

get_property(amalgamation GLOBAL PROPERTY amalgamation)
string(REGEX REPLACE "\n\n\n+" "\n\n" amalgamation "${amalgamation}")
if(amalgamation MATCHES "\n([ \t]*#[ \t]*include[ \t]*[<\"]bristle/[^\n]*)")
  message(FATAL_ERROR "not written as `#include <bristle/...>` from the first column: ${CMAKE_MATCH_1}")
endif()

set(current "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" current)
endif()
if(amalgamation STREQUAL current)
  message(STATUS "${OUTPUT} is up to date")
elseif(CHECK)
  message(FATAL_ERROR "stale: ${OUTPUT}\nRun: cmake -P single_include/amalgamate.cmake")
else()
  file(WRITE "${OUTPUT}" "${amalgamation}")
  message(STATUS "wrote ${OUTPUT}")
endif()
