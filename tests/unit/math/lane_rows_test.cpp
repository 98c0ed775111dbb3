/// @file
/// Rows of scalars to lanes and back.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/lane_rows.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

template <std::size_t count, typename S>
void check_rows() {
  constexpr std::uint32_t rows = 40;
  // Every number is there once.
  std::vector<S> numbers(rows * row_stride);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = S(i + 1);
  std::array<std::uint32_t, lanes<S>> at{};
  for (std::uint32_t i = 0; i < lanes<S>; ++i) {
    at[i] = static_cast<std::uint32_t>(row_stride) * (i * 7 % rows);
  }

  Pack<S> columns[count];
  load_rows(numbers.data(), at.data(), columns);
  for (std::size_t c = 0; c < count; ++c) {
    for (std::size_t i = 0; i < lanes<S>; ++i) CHECK(columns[c][i] == numbers[at[i] + c]);
  }

  for (std::size_t c = 0; c < count; ++c) columns[c] = columns[c] + S(1000);
  const std::vector<S> before = numbers;
  store_rows(numbers.data(), at.data(), columns);
  std::vector<bool> is_written(rows);
  for (const std::uint32_t first : at) is_written[first / row_stride] = true;
  for (std::size_t row = 0; row < rows; ++row) {
    // Of rows that are written only the first numbers are told.
    for (std::size_t c = 0; c < (is_written[row] ? count : row_stride); ++c) {
      const std::size_t i = row_stride * row + c;
      CHECK(numbers[i] == before[i] + (is_written[row] ? S(1000) : S(0)));
    }
  }
}

}  // namespace

TEST_CASE_TEMPLATE("load_rows, store_rows: every lane its row, and no other row", S, float, double,
                   long double) {
  check_rows<1, S>();
  check_rows<3, S>();
  check_rows<6, S>();
  check_rows<8, S>();
}

TEST_CASE_TEMPLATE("store_rows: of lanes with the same row, the last one stays", S, float, double) {
  // Any two lanes in row 0, the others each in their own.
  for (std::size_t one = 0; one < lanes<S>; ++one) {
    for (std::size_t other = one + 1; other < lanes<S>; ++other) {
      std::array<S, (lanes<S> + 1) * row_stride> numbers{};
      std::array<std::uint32_t, lanes<S>> at{};
      for (std::size_t i = 0; i < lanes<S>; ++i) {
        at[i] = static_cast<std::uint32_t>(i == one || i == other ? 0 : (i + 1) * row_stride);
      }
      Pack<S> columns[6];
      for (std::size_t c = 0; c < 6; ++c) columns[c] = S(100 * c) + Pack<S>::numbers();
      store_rows(numbers.data(), at.data(), columns);
      for (std::size_t c = 0; c < 6; ++c) CHECK(numbers[c] == S(100 * c + other));
    }
  }
}
