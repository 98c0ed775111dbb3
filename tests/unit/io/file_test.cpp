// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/file.hpp>

#include <doctest/doctest.h>

#include <filesystem>
#include <string>
#include <support/temp_folder.hpp>

using namespace bristle;
using bristle::test::TempFolder;
namespace fs = std::filesystem;

namespace {

std::string reading_error(const fs::path& path) {
  try {
    (void)read_file(path);
  } catch (const IoError& error) {
    CHECK(error.file() == path.string());
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("write_file, read_file: bring back every byte, and replace what was there") {
  const TempFolder folder;
  const fs::path path = folder.path() / "file.bin";
  std::string all_bytes;
  for (int i = 0; i < 256; ++i) all_bytes.push_back(static_cast<char>(i));
  // One is longer than what is read at once.
  const std::string long_text(200'000, 'x');
  for (const std::string& bytes : {all_bytes, long_text, std::string("short\r\n"), std::string()}) {
    write_file(path, bytes);
    CHECK(read_file(path) == bytes);
  }
  fs::remove(path);
  CHECK(reading_error(path).find("No such file") != std::string::npos);
}

TEST_CASE("read_file, write_file: say why a path is no use") {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  CHECK(!reading_error(folder).empty());
  CHECK_THROWS_AS(write_file(folder, "x"), IoError);
  CHECK_THROWS_AS(write_file(folder / "none" / "file", "x"), IoError);
  if (fs::exists("/dev/zero")) CHECK(!reading_error("/dev/zero").empty());
  // A device that takes nothing says so as the file is closed.
  if (fs::exists("/dev/full")) CHECK_THROWS_AS(write_file("/dev/full", "x"), IoError);
}
