// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/text_scanner.hpp>

#include <doctest/doctest.h>

#include <string>

using namespace bristle;

using namespace bristle::detail;
using bristle::detail::TextScanner;

TEST_CASE("TextScanner: finds words and their lines across blanks and line ends") {
  TextScanner scanner("one\ttwo\r\n\r\n  three\n", "f");
  CHECK(scanner.word() == "one");
  CHECK(scanner.line() == 1);
  CHECK(scanner.word() == "two");
  CHECK(scanner.word() == "three");
  CHECK(scanner.line() == 3);
  CHECK(scanner.word() == "");
  CHECK(scanner.word() == "");
}

TEST_CASE("TextScanner: stops at the end of a line where asked to") {
  TextScanner scanner("a b\nc", "f");
  CHECK(scanner.word_on_line() == "a");
  CHECK(scanner.word_on_line() == "b");
  CHECK(scanner.word_on_line() == "");
  CHECK(scanner.word_on_line() == "");
  CHECK(scanner.word() == "c");
  TextScanner other("a b c\nd", "f");
  CHECK(other.word() == "a");
  other.skip_line();
  CHECK(other.word() == "d");
}

TEST_CASE("TextScanner: a backslash at the end of a line joins it with the next") {
  TextScanner scanner("a \\\nb\\\r\nc\\d \\", "f");
  CHECK(scanner.word_on_line() == "a");
  CHECK(scanner.word_on_line() == "b");
  CHECK(scanner.line() == 2);
  CHECK(scanner.word_on_line() == "c\\d");
  CHECK(scanner.line() == 3);
  CHECK(scanner.word_on_line() == "\\");
  CHECK(scanner.word_on_line() == "");
}

TEST_CASE_TEMPLATE("TextScanner::number: reads what C++ writes, and a leading plus", S, float,
                   double) {
  const TextScanner scanner("", "f");
  CHECK(scanner.number<S>("0") == S(0));
  CHECK(scanner.number<S>("-1.5") == S(-1.5));
  CHECK(scanner.number<S>("+2.5e+1") == S(25));
  CHECK(scanner.number<S>("1E-3") == S(1e-3));
  CHECK(scanner.number<S>(".5") == S(0.5));
  CHECK(scanner.number<S>("5.") == S(5));
}

TEST_CASE_TEMPLATE("TextScanner::number: refuses everything else", S, float, double) {
  const TextScanner scanner("", "f");
  for (const char* word : {"", "x", "1x", "1,5", "+-1", "--1", "+", "-", ".", "e5", "nan", "inf",
                           "-inf", "1e999", "0x10", "1 ", "1_0"}) {
    CAPTURE(word);
    CHECK_THROWS_AS((void)scanner.number<S>(word), IoError);
  }
  // Finite in double precision, infinite in single.
  CHECK_THROWS_AS((void)scanner.number<float>("1e39"), IoError);
  CHECK(scanner.number<double>("1e39") == 1e39);
}

TEST_CASE("TextScanner::fail: names file and line and quotes safely") {
  TextScanner scanner("\n\nword", "part.obj");
  (void)scanner.word();
  try {
    scanner.fail("wrong");
  } catch (const IoError& error) {
    CHECK(std::string(error.what()) == "part.obj:3: wrong");
    CHECK(error.line() == 3);
  }
  CHECK(TextScanner::quoted("a\x01\xffz") == "'a??z'");
  CHECK(TextScanner::quoted(std::string(1000, 'x')).size() == 42);
}

TEST_CASE("to_lower: changes ASCII letters only") {
  CHECK(detail::to_lower("Solid.STL-\xc4") == "solid.stl-\xc4");
}
