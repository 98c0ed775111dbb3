# The objects of wide instruction sets define nothing that others can see but two functions: what else
# they had to offer, the linker could take for everybody. Nor do they fuse products with a sum beside a
# difference, which g++ 12 does in spite of -ffp-contract=off, and which makes other bits of them than
# of the same headers with another -O (docs/measurements/0032-compiled-library.md).
# Usage: cmake -DNM=<nm> -DOBJDUMP=<objdump> "-DOBJECTS=<objects>" -P kernels_are_closed.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)
foreach(object IN LISTS OBJECTS)
  execute_process(COMMAND "${NM}" --defined-only --extern-only "${object}" OUTPUT_VARIABLE symbols
                  COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE "[0-9a-f]+ T bristle_kernels_(float|double)_v[34]\n" "" others "${symbols}")
  if(symbols STREQUAL "" OR NOT others STREQUAL "")
    message(FATAL_ERROR "${object} lets others see:\n${others}")
  endif()
  execute_process(COMMAND "${OBJDUMP}" --disassemble --demangle --no-show-raw-insn "${object}"
                  OUTPUT_VARIABLE code COMMAND_ERROR_IS_FATAL ANY)
  if(NOT code MATCHES "vmul[ps]d")
    message(FATAL_ERROR "${object} has no code to look at")
  endif()
  if(code MATCHES "vfm(addsub|subadd)")
    message(FATAL_ERROR "${object} fuses products in spite of -ffp-contract=off")
  endif()
endforeach()
