# The object of a header-only file with a world has the world's step in it, and nothing of joints, which
# the file does not use.
# Usage: cmake -DNM=<nm> -DOBJECT=<object> -P joints_are_apart.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)
execute_process(COMMAND "${NM}" --demangle "${OBJECT}" OUTPUT_VARIABLE symbols
                COMMAND_ERROR_IS_FATAL ANY)
string(FIND "${symbols}" "Stepper<double" place)
if(place LESS 0)
  message(FATAL_ERROR "${OBJECT} has no step")
endif()
# Not by a regular expression: CMake takes minutes for one over all symbols.
foreach(name IN ITEMS MechanismStage JointSystem add_joint_rows)
  string(FIND "${symbols}" "${name}" place)
  if(place GREATER -1)
    string(SUBSTRING "${symbols}" ${place} 120 first)
    message(FATAL_ERROR "${OBJECT} has code for joints:\n${first}")
  endif()
endforeach()
