/// @file
/// Reads and writes whole files, with errors that name the cause.
///
/// Paths are strings, as the C library opens them. A std::filesystem::path becomes one by itself on
/// POSIX, and by `string()` elsewhere. Its header would cost whoever includes the library a fifth
/// of a second.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

struct FileCloser {
  void operator()(std::FILE* file) const noexcept { (void)std::fclose(file); }
};
using OpenFile = std::unique_ptr<std::FILE, FileCloser>;

[[noreturn]] inline void raise_file_error(const std::string& path, const char* what) {
  const int cause = errno;
  std::string text = what;
  if (cause != 0) text += std::string(": ") + std::strerror(cause);
  raise(IoError(path, 0, text));
}

}  // namespace detail

/// Returns all bytes of a file.
///
/// @throws IoError if the file does not exist, is a directory or a device without an end, or cannot
///         be read.
[[nodiscard]] inline std::string read_file(const std::string& path) {
  errno = 0;
  const detail::OpenFile file(std::fopen(path.c_str(), "rb"));
  if (!file) detail::raise_file_error(path, "cannot be opened for reading");
  const bool has_end = std::fseek(file.get(), 0, SEEK_END) == 0;
  const long end = has_end ? std::ftell(file.get()) : -1;
  if (end < 0) detail::raise_file_error(path, "not a regular file");
  std::rewind(file.get());
  // Part by part: a directory may claim any size, and a device be longer than it says.
  const auto size = static_cast<std::size_t>(end);
  std::string bytes;
  constexpr std::size_t part_size = 1 << 14;
  char part[part_size];
  while (bytes.size() <= size) {
    const std::size_t count = std::fread(part, 1, sizeof part, file.get());
    if (count == 0) break;
    bytes.append(part, count);
  }
  if (std::ferror(file.get()) != 0) detail::raise_file_error(path, "cannot be read to its end");
  if (bytes.size() > size) detail::raise(IoError(path, 0, "longer than its size"));
  return bytes;
}

/// Writes a file, replacing an existing one.
///
/// @throws IoError if it cannot be written in full.
inline void write_file(const std::string& path, std::string_view bytes) {
  errno = 0;
  detail::OpenFile file(std::fopen(path.c_str(), "wb"));
  if (!file) detail::raise_file_error(path, "cannot be opened for writing");
  const bool is_written = std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  // Closing writes the rest of the buffer.
  const bool is_closed = std::fclose(file.release()) == 0;
  if (!is_written || !is_closed) detail::raise_file_error(path, "cannot be written to its end");
}

}  // namespace bristle::inline BRISTLE_ABI
