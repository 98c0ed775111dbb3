#!/usr/bin/env bash
# Cost of including a header: lines after the preprocessor, and processor seconds to check the
# syntax of a file that holds nothing else (best of 3), for each compiler that is there.
# Usage: tests/benchmarks/include_cost.sh [compiler...]
# SPDX-License-Identifier: BSD-3-Clause
set -euo pipefail

root="$(cd "$(dirname "$0")/../.." && pwd)"
file="$(mktemp --suffix=.cpp)"
trap 'rm -f "$file"' EXIT
flags=(-std=c++20 -isystem "${EIGEN:-/usr/include/eigen3}" -I "$root/include")
TIMEFORMAT=%U

[ $# -gt 0 ] || set -- g++ clang++
for compiler in "$@"; do
  command -v "$compiler" >/dev/null || continue
  "$compiler" --version | head -1
  printf '  %-34s  %8s  %8s\n' header lines seconds
  for header in Eigen/Geometry bristle/bristle.hpp bristle/geometry/backends/fcl_rays.hpp \
    bristle/geometry/backends/fcl_backend.hpp; do
    echo "#include <$header>" >"$file"
    if ! "$compiler" "${flags[@]}" -fsyntax-only "$file" 2>/dev/null; then
      printf '  %-34s  %8s  %8s\n' "$header" - -  # FCL is not there, say
      continue
    fi
    lines="$("$compiler" "${flags[@]}" -E -P "$file" | wc -l)"
    best="$(for _ in 1 2 3; do
      { time "$compiler" "${flags[@]}" -fsyntax-only "$file"; } 2>&1
    done | sort -n | head -1)"
    printf '  %-34s  %8d  %8s\n' "$header" "$lines" "$best"
  done
done

# Cost of a file with a world and a patch, and of two others, header-only and declared: processor
# seconds, memory of the compiler, size of the object.
object="$(mktemp --suffix=.o)"
trap 'rm -f "$file" "$object"' EXIT
for compiler in "$@"; do
  command -v "$compiler" >/dev/null || continue
  for example in 01_falling_box 12_snapshot 21_terrain; do
    printf '%s -O2 examples/%s.cpp\n' "$compiler" "$example"
    printf '  %-34s  %8s  %8s  %8s\n' "" seconds MB kB
    for way in header-only compiled; do
      define=-DBRISTLE_WAY
      [ $way = header-only ] || define=-DBRISTLE_COMPILED
      cost="$(/usr/bin/time -f '%U %S %M' "$compiler" "${flags[@]}" -O2 "$define" -c \
        "$root/examples/$example.cpp" -o "$object" 2>&1 | tail -1)"
      echo "$cost" | awk -v way=$way -v size="$(stat -c %s "$object")" \
        '{ printf "  %-34s  %8.1f  %8.0f  %8.0f\n", way, $1 + $2, $3 / 1024, size / 1000 }'
    done
  done
done
