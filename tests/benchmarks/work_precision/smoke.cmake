# Runs the work-precision benchmark on five short scenes and checks its table: a row for each scene
# and scalar, finite numbers, closed forms met, and a report that counts them.
# Usage: cmake -DPROGRAM=<benchmark_work_precision> -P smoke.cmake
# SPDX-License-Identifier: BSD-3-Clause

set(csv "${CMAKE_CURRENT_BINARY_DIR}/work_precision_smoke.csv")
execute_process(
  COMMAND "${PROGRAM}" --quick --scenes "^(matrix/(slide|roll|bounce10)|moving/(dragged|pendulum))$" --dt 1/240
  OUTPUT_FILE "${csv}" RESULT_VARIABLE code)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "the benchmark ended with ${code}")
endif()
file(STRINGS "${csv}" lines)
set(number "[0-9.e+-]+")
foreach(scene slide roll bounce10 dragged pendulum)
  foreach(engine bristle64 bristle32)
    # Steps, error, passes, four times, sweeps, factorisations, allocations; "inf" and "nan" are no
    # numbers here.
    set(row "^${scene},${engine},def,0.00416667,[0-9]+,${number},1(,${number})+,[a-zA-Z]")
    set(found ${lines})
    list(FILTER found INCLUDE REGEX "${row}")
    list(LENGTH found count)
    if(NOT count EQUAL 1)
      message(FATAL_ERROR "${count} good rows of ${scene} by ${engine} in\n${lines}")
    endif()
  endforeach()
endforeach()

execute_process(COMMAND "${PROGRAM}" --report "${csv}" OUTPUT_VARIABLE text RESULT_VARIABLE code)
file(REMOVE "${csv}")
if(NOT code EQUAL 0 OR NOT text MATCHES "\nmatrix: 3 of 3 pass\n$")
  message(FATAL_ERROR "the report ended with ${code}:\n${text}")
endif()
