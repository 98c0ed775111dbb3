// SPDX-License-Identifier: BSD-3-Clause
#include "support/texts.hpp"

#include <bristle/io/trace.hpp>

#include <doctest/doctest.h>

#include <array>
#include <charconv>
#include <clocale>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

using namespace bristle;
using bristle::test::error_of;

TEST_CASE("Trace: writes the labels of its channels, then one line a row") {
  Trace trace{{"time", "s"}, {"height", "m"}, {"count", ""}};
  CHECK(trace.csv() == "time [s],height [m],count\n");
  trace.add_row({0.0, 1.0, 3.0});
  trace.add_row({0.001, -2.5e-7, 1e20});
  CHECK(trace.csv() == "time [s],height [m],count\n0,1,3\n0.001,-2.5e-07,1e+20\n");
  CHECK(trace.csv(1) == "time [s],height [m],count\n0,1,3\n0.001,-2e-07,1e+20\n");
}

TEST_CASE("Trace: one channel is a table too") {
  Trace trace{{"force", "N"}};
  trace.add_row({2.0});
  CHECK(trace.channels().size() == 1);
  CHECK(trace.csv() == "force [N]\n2\n");
}

TEST_CASE("Trace: is read by columns") {
  Trace trace{{"time", "s"}, {"height", "m"}};
  trace.reserve(2);
  CHECK(trace.size() == 0);
  const std::array<double, 2> row{1, 10};
  trace.add_row(row);
  trace.add_row({2, 20});
  CHECK(trace.size() == 2);
  CHECK(trace.column("time") == std::vector<double>{1, 2});
  CHECK(trace.column("height") == std::vector<double>{10, 20});
  CHECK(error_of([&] { (void)trace.column("width"); }) ==
        "Trace::column: name = \"width\": must be that of a channel");
}

TEST_CASE("Trace: 9 digits read back as the same float, 17 as the same double") {
  Trace trace{{"value", ""}};
  const float single = 0.1f;
  trace.add_row({static_cast<double>(single)});
  trace.add_row({0.1 + 0.2});
  const std::string text = trace.csv(17);
  const auto lines = [](const std::string& csv, int line) {
    std::size_t at = 0;
    for (int i = 0; i < line; ++i) at = csv.find('\n', at) + 1;
    return csv.substr(at, csv.find('\n', at) - at);
  };
  double back = 0;
  const std::string exact = lines(text, 2);
  std::from_chars(exact.data(), exact.data() + exact.size(), back);
  CHECK(back == 0.1 + 0.2);
  float back_single = 0;
  const std::string short_text = lines(trace.csv(), 1);
  std::from_chars(short_text.data(), short_text.data() + short_text.size(), back_single);
  CHECK(back_single == single);
}

TEST_CASE("Trace: keeps values that are not finite, as their names") {
  Trace trace{{"value", ""}};
  trace.add_row({std::numeric_limits<double>::quiet_NaN()});
  trace.add_row({-std::numeric_limits<double>::quiet_NaN()});
  trace.add_row({std::numeric_limits<double>::infinity()});
  trace.add_row({-std::numeric_limits<double>::infinity()});
  CHECK(trace.csv() == "value\nnan\nnan\ninf\n-inf\n");
}

TEST_CASE("Trace: quotes labels that hold commas, quotes or line ends") {
  Trace trace{{"a,b", ""}, {"say \"c\"", "m"}, {"two\nlines", ""}};
  CHECK(trace.csv() == "\"a,b\",\"say \"\"c\"\" [m]\",\"two\nlines\"\n");
}

TEST_CASE("Trace: writes a decimal point in every locale") {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  // Where the system lacks the locale, the default one stays, and the check holds all the same.
  std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
  Trace trace{{"value", ""}};
  trace.add_row({0.5});
  CHECK(trace.csv() == "value\n0.5\n");
  std::setlocale(LC_NUMERIC, before.c_str());
}

TEST_CASE("Trace: names the channel, the row or the setting that breaks a rule") {
  CHECK(error_of([] { Trace trace(std::vector<bristle::detail::TraceChannel>{}); }) ==
        "Trace: number of channels = 0: must be > 0");
  CHECK(error_of([] {
          Trace trace{{"time", "s"}, {"", "m"}};
        }) == "TraceChannel[1]::name = \"\": must not be empty");
  CHECK(error_of([] {
          Trace trace{{"x", "s"}, {"y", ""}, {"x", "m"}};
        }) == "TraceChannel[2]::name = \"x\": must be unique in the trace");
  Trace trace{{"time", "s"}, {"height", "m"}};
  CHECK(error_of([&] { trace.add_row({1.0}); }) ==
        "Trace::add_row: number of values = 1: must be the number of channels, 2");
  CHECK(error_of([&] {
          trace.add_row({1.0, 2.0, 3.0});
        }) == "Trace::add_row: number of values = 3: must be the number of channels, 2");
  CHECK(trace.size() == 0);
  CHECK(error_of([&] { (void)trace.csv(0); }) == "Trace::csv: digits = 0: must be in [1, 17]");
  CHECK(error_of([&] { (void)trace.csv(18); }) == "Trace::csv: digits = 18: must be in [1, 17]");
}

TEST_CASE("Trace: is written to a file, or says which file cannot be written") {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "bristle_trace_test.csv";
  Trace trace{{"time", "s"}};
  trace.add_row({0.25});
  trace.write_csv(file);
  CHECK(read_file(file) == "time [s]\n0.25\n");
  std::filesystem::remove(file);
  const std::filesystem::path nowhere = file / "no_such_folder" / "trace.csv";
  try {
    trace.write_csv(nowhere);
    FAIL("written to a folder that does not exist");
  } catch (const IoError& error) {
    CHECK(error.file() == nowhere.string());
  }
}
