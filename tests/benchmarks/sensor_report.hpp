/// @file
/// Results of the benchmark of sensors, and their targets.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "benchmarks/benchmark_table.hpp"

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <map>
#include <string>

namespace bristle::benchmarks {

/// Options of the command line.
struct Options {
  bool is_markdown = false;
  /// True if the pad's sensors are ordered row by row, and not as neighbours.
  bool in_rows = false;
  std::string csv;
  std::string only;

  [[nodiscard]] bool is_chosen(const char* part) const { return only.empty() || only == part; }
};

/// Everything the program finds out.
struct Report {
  Options options;
  /// By names like "mesh10k 1000 analytic float explicit".
  std::map<std::string, double> figures{};

  /// A line for each figure.
  [[nodiscard]] std::string csv() const {
    std::string text = "figure,value\n";
    for (const auto& [name, value] : figures) {
      std::string quiet = name;
      std::replace(quiet.begin(), quiet.end(), ',', ';');
      text += quiet + ',' + in_full(value) + '\n';
    }
    return text;
  }
};

/// Prints what was wanted, as far as it was measured.
class Bars {
 public:
  explicit Bars(Report& report)
      : report_(report),
        table_(report.options.is_markdown, {"what", "wanted", "found", "verdict"}) {}

  void print() {
    for (const char* scalar : {"float", "double"}) sensors(scalar, scalar[0] == 'f');
    double worst = 0;
    for (const auto& [name, cost] : report_.figures) {
      const std::size_t at = name.find(" fcl ");
      if (!name.starts_with("mesh") || at == std::string::npos || !name.ends_with("explicit")) {
        continue;
      }
      std::string own = name;
      worst = std::max(worst, cost / report_.figures.at(own.replace(at, 5, " analytic ")));
    }
    at_most("FCL's meshes against the analytic backend's, worst [times]", 1.5, worst);
    peers();
    for (const char* scalar : {"float", "double"}) worlds(scalar);
  }

 private:
  /// The largest of the figures of these names that were measured; 0 without any.
  [[nodiscard]] double largest(std::initializer_list<std::string> names) const {
    double largest = 0;
    for (const std::string& name : names) {
      const auto found = report_.figures.find(name);
      if (found != report_.figures.end()) largest = std::max(largest, found->second);
    }
    return largest;
  }
  [[nodiscard]] double smallest(std::initializer_list<std::string> names) const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const std::string& name : names) {
      const auto found = report_.figures.find(name);
      if (found != report_.figures.end()) smallest = std::min(smallest, found->second);
    }
    return smallest < std::numeric_limits<double>::infinity() ? smallest : 0;
  }
  void at_least(const std::string& what, double wanted, double found) {
    if (found > 0) add(what, ">= ", wanted, found, found >= wanted);
  }
  void at_most(const std::string& what, double wanted, double found) {
    if (found > 0) add(what, "<= ", wanted, found, found <= wanted);
  }
  void add(const std::string& what, const char* sign, double wanted, double found, bool is_met) {
    table_.add({what, sign + in_short(wanted), in_short(found), is_met ? "met" : "MISSED"});
  }
  static double rate(double cost) { return cost > 0 ? 1e6 / cost : 0; }

  void sensors(const std::string& scalar, bool is_float) {
    const std::string of = " analytic " + scalar + " explicit";
    const std::string in = ", " + scalar;
    at_least("sensors a ms, mesh10k, 1000" + in, is_float ? 50e3 : 35e3,
             rate(largest({"mesh10k 1000" + of})));
    at_least("sensors a ms, mesh10k, 10000" + in, is_float ? 100e3 : 70e3,
             rate(largest({"mesh10k 10000" + of})));
    for (const char* shape : {"box", "sphere", "capsule"}) {
      const std::string name = shape;
      at_least("sensors a ms, " + name + ", 1000 and 10000" + in, is_float ? 250e3 : 150e3,
               rate(largest({name + " 1000" + of, name + " 10000" + of})));
    }
    at_least("sensors a ms, mesh100k, 100" + in, is_float ? 10e3 : 8e3,
             rate(largest({"mesh100k 100" + of})));
    const std::string ray = " analytic " + scalar + " ray";
    at_most("law alone, explicit, sphere, 1000 [ns]" + in, is_float ? 2.5 : 3,
            largest({"sphere 1000" + of}) - largest({"sphere 1000" + ray}));
    at_most("law alone, block, sphere, 1000 [ns]" + in, is_float ? 5 : 7,
            largest({"sphere 1000 analytic " + scalar + " block"}));
    for (const std::string shape : {"mesh10k", "sphere"}) {
      const double few = largest({shape + " 10000" + of});
      if (few > 0) {
        at_most("a sensor of 100,000 against one of 10,000, " + shape + in + " [times]", 1.25,
                largest({shape + " 100000" + of}) / few);
      }
    }
  }
  void peers() {
    at_least("Bullet's rayTest, mesh10k, worst [times]", 30,
             smallest({"mesh10k 1000 Bullet rayTest", "mesh10k 10000 Bullet rayTest"}));
    at_least("Embree one by one, mesh10k, worst [times]", 4,
             smallest({"mesh10k 1000 Embree single", "mesh10k 10000 Embree single"}));
    at_least("Embree's coherent packets, mesh10k, worst [times]", 1.5,
             smallest({"mesh10k 1000 Embree coherent", "mesh10k 10000 Embree coherent"}));
  }
  void worlds(const std::string& scalar) {
    const std::string in = ", " + scalar;
    for (const std::string n : {"100", "1000", "10000"}) {
      for (const std::string gap : {"0.7", "4"}) {
        at_most("out of reach by " + gap + " mm, " + n + " sensors [us]" + in, 1,
                largest({"out of reach by " + gap + " mm " + n + ' ' + scalar}));
      }
    }
    at_most("nothing near [us]" + in, 0.1, largest({"nothing near, each of 1000 100 " + scalar}));
    at_most("all asleep, the whole step [us]" + in, 0.02, largest({"all asleep 10000 " + scalar}));
    at_most("a ball is held by 10,000, the whole step [us]" + in, 400,
            largest({"a ball is held, whole step 10082 " + scalar}));
    at_least("two threads, one pad, explicit [times]" + in, 1.7,
             largest({"two threads, one pad, explicit, " + scalar}));
    at_least("two threads, a ball is held [times]" + in, 1.7,
             largest({"two threads, a ball is held, " + scalar}));
  }

  Report& report_;
  Table table_;
};

}  // namespace bristle::benchmarks
