/// @file
/// Reads and writes whole files, with errors that name the cause.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>

#include <filesystem>
#include <fstream>
#include <ios>
#include <string>
#include <string_view>
#include <system_error>

namespace bristle::inline BRISTLE_ABI {

/// Returns all bytes of a file.
///
/// @throws IoError if the file does not exist, is a directory, or cannot be read.
[[nodiscard]] inline std::string read_file(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    detail::raise(IoError(path.string(), 0, "no such file"));
  }
  if (!std::filesystem::is_regular_file(status)) {
    detail::raise(IoError(path.string(), 0, "not a regular file"));
  }
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream stream(path, std::ios::binary);
  if (error || !stream) detail::raise(IoError(path.string(), 0, "cannot be opened for reading"));
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (stream.gcount() != static_cast<std::streamsize>(bytes.size())) {
    detail::raise(IoError(path.string(), 0, "cannot be read to its end"));
  }
  return bytes;
}

/// Writes a file, replacing an existing one.
///
/// @throws IoError if it cannot be written in full.
inline void write_file(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  if (!stream) detail::raise(IoError(path.string(), 0, "cannot be opened for writing"));
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) detail::raise(IoError(path.string(), 0, "cannot be written to its end"));
}

}  // namespace bristle::inline BRISTLE_ABI
