# The objects of wide instruction sets define nothing that others can see but two functions: what else
# they had to offer, the linker could take for everybody.
# Usage: cmake -DNM=<nm> "-DOBJECTS=<objects>" -P kernels_are_closed.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)
foreach(object IN LISTS OBJECTS)
  execute_process(COMMAND "${NM}" --defined-only --extern-only "${object}" OUTPUT_VARIABLE symbols
                  COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE "[0-9a-f]+ T bristle_kernels_(float|double)_v[34]\n" "" others "${symbols}")
  if(symbols STREQUAL "" OR NOT others STREQUAL "")
    message(FATAL_ERROR "${object} lets others see:\n${others}")
  endif()
endforeach()
