// The scene of an example, recorded as `--replay FILE.glb` asks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/glb.hpp>
#include <bristle/io/recorder.hpp>
#include <bristle/world/world.hpp>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace figure {

/// Records one world of an example, if the command line says where to.
class Replay {
 public:
  /// @param file  Where the recording goes; empty: nothing is recorded. Ends the program with 2
  ///              where it is no .glb file.
  explicit Replay(std::filesystem::path file) : file_(std::move(file)) {
    if (!is_wanted() || file_.extension() == ".glb") return;
    std::fprintf(stderr, "--replay %s: must be a .glb file; examples/run makes pages\n",
                 file_.string().c_str());
    std::exit(2);
  }
  /// Of an example that has no other option. Ends the program with 2 where it has.
  static Replay of_arguments(int argc, char** argv) {
    if (argc == 1) return Replay({});
    if (argc == 3 && std::string_view(argv[1]) == "--replay") return Replay(argv[2]);
    std::fprintf(stderr, "usage: %s [--replay FILE.glb]\n", argv[0]);
    std::exit(2);
  }

  [[nodiscard]] bool is_wanted() const { return !file_.empty(); }
  /// To name bodies and to record numbers.
  [[nodiscard]] bristle::Recorder<double>& recorder() { return recorder_; }

  /// To be called after each step: records all that the world has.
  void observe(const bristle::World<double>& world) {
    if (!is_wanted()) return;
    recorder_.add_world(world);
    recorder_.observe(world);
  }
  /// The same as what scenes take.
  [[nodiscard]] std::function<void(const bristle::World<double>&)> watch() {
    if (!is_wanted()) return {};
    return [this](const bristle::World<double>& world) { observe(world); };
  }
  /// Writes what was observed.
  void write() const {
    if (!is_wanted()) return;
    bristle::write_glb(file_, recorder_.recording());
    std::printf("wrote %s\n", file_.string().c_str());
  }

 private:
  std::filesystem::path file_;
  bristle::Recorder<double> recorder_;
};

}  // namespace figure
