# The object of a header-only file with a world has the world's step in it, and nothing of joints, which
# the file does not use.
# Usage: cmake -DNM=<nm> -DOBJECT=<object> -P joints_are_apart.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)
execute_process(COMMAND "${NM}" --demangle "${OBJECT}" OUTPUT_VARIABLE symbols
                COMMAND_ERROR_IS_FATAL ANY)
if(NOT symbols MATCHES "Stepper<double")
  message(FATAL_ERROR "${OBJECT} has no step")
endif()
if(symbols MATCHES "[^\n]*(MechanismStage|JointSystem|add_joint_rows)[^\n]*")
  message(FATAL_ERROR "${OBJECT} has code for joints:\n${CMAKE_MATCH_0}")
endif()
