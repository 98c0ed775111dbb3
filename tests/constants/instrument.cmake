# Writes a table of chosen constants whose rows are variables that `scaled.hpp` lists.
# Usage: cmake -DHEADER=<table> -DOUTPUT=<file> -P instrument.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

file(READ "${HEADER}" text)
string(REGEX MATCHALL "\ninline constexpr [^\n]*" rows "${text}")
list(LENGTH rows count)
string(REGEX REPLACE
  "\ninline constexpr ([a-z0-9_:]+) ([a-z0-9_]+) = ([^;\n]+);"
  "\ninline \\1 \\2 = \\3;\ninline const bristle_constants::Row row_of_\\2{\"\\2\", \\2};"
  text "${text}")
if(count EQUAL 0 OR text MATCHES "\n *inline constexpr ")
  message(FATAL_ERROR "${HEADER}: rows must be lines `inline constexpr <type> <name> = <value>;`")
endif()
string(REGEX REPLACE "(\n#include [^\n]*\n)" "\\1#include \"constants/scaled.hpp\"\n" text "${text}")
file(WRITE "${OUTPUT}" "${text}")
