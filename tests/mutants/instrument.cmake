# Writes a header with mutants in it, each behind its switch (mutant.cmake).
# Usage: cmake -DHEADER=<header> "-DMUTANTS=<.mutant files for it>" -DOUTPUT=<file> -P instrument.cmake
# SPDX-License-Identifier: BSD-3-Clause
include("${CMAKE_CURRENT_LIST_DIR}/mutant.cmake")

put_mutants_in("${HEADER}" text faults ${MUTANTS})
if(faults)
  message(FATAL_ERROR "${faults}")
endif()
file(WRITE "${OUTPUT}" "${text}")
