# Builds the project in this folder for 64-bit ARM and runs its programs in an emulator: the tests in
# lanes pass, and a world prints the same figures as on the machine that this runs on.
# Usage: cmake -DROOT=<tree> -DWORK=<folder> -DDOCTEST=<folder> -DLANES=<sources> -P run.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

find_program(compiler aarch64-linux-gnu-g++)
find_program(emulator NAMES qemu-aarch64 qemu-aarch64-static)
if(NOT compiler OR NOT emulator)
  message(STATUS "left out: g++-aarch64-linux-gnu and qemu-user are not both installed")
  return()
endif()

execute_process(
  COMMAND "${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}" -B "${WORK}" -DCMAKE_SYSTEM_NAME=Linux
          -DCMAKE_SYSTEM_PROCESSOR=aarch64 "-DCMAKE_CXX_COMPILER=${compiler}"
          "-DBRISTLE_SOURCE_DIR=${ROOT}" "-DDOCTEST=${DOCTEST}" "-DLANES=${LANES}"
  COMMAND_ERROR_IS_FATAL ANY)
# By one job: other tests run beside it.
execute_process(COMMAND "${CMAKE_COMMAND}" --build "${WORK}" --parallel 1
                COMMAND_ERROR_IS_FATAL ANY)

execute_process(COMMAND "${emulator}" "${WORK}/lanes" COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${emulator}" "${WORK}/consumer" OUTPUT_VARIABLE output
                COMMAND_ERROR_IS_FATAL ANY)
message(NOTICE "${output}")
# The box of world_consumer.cpp, in double and in float.
if(NOT output MATCHES "^baseline\n32.00 mm, 4.905 N\n32.00 mm, 4.905 N\n")
  message(FATAL_ERROR "other figures than those of examples/01_falling_box.expected")
endif()
