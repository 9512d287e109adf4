#pragma once
// The file of rows that a measuring program writes, which is whole at any time: what ran is kept where the program ends
// early.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include "coupler/core/error.h"

namespace sunder {

/// Replaces the file at once where it is a regular one or none; else, as with /dev/stdout, writes into it. Throws
/// Error (bad_input).
inline void write_rows(const std::string& path, const std::string& text) {
  std::error_code none;
  const bool special = std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none);
  const std::string made = special ? path : path + "." + std::to_string(getpid());
  std::ofstream out(made);
  out << text;
  out.close();
  const bool good = out.good() && (special || std::rename(made.c_str(), path.c_str()) == 0);
  if (!good && !special) std::filesystem::remove(made, none);
  require(good, "--json {}: cannot be written", path);
}

/// The same while rows are still to come; a special file takes them only at the end.
inline void write_rows_so_far(const std::string& path, const std::string& text) {
  std::error_code none;
  if (!std::filesystem::exists(path, none) || std::filesystem::is_regular_file(path, none)) write_rows(path, text);
}

}  // namespace sunder
