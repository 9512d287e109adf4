#pragma once
// A folder for what a test, a benchmark or a validation writes: private, of its own, and gone with its scope.
#include <cstdlib>
#include <filesystem>
#include <string>

#include "coupler/core/error.h"

namespace sunder {

struct TemporaryFolder {
  std::string path;
  /// Sockets are made in it, whose names are short: a long TMPDIR is passed over.
  TemporaryFolder() {
    std::error_code none;
    for (const std::string& place : {std::filesystem::temp_directory_path(none).string(), std::string("/tmp"),
                                     std::string("/dev/shm"), std::string("/var/tmp")}) {
      constexpr std::size_t kLongest = 68;  // [bytes], as in coupler/sunder_tools/launch/socket_dir.py
      path = place + "/sunder-XXXXXX";
      if (!place.empty() && place.size() <= kLongest && mkdtemp(path.data()) != nullptr) return;  // 0700
    }
    require(false, "no temporary folder can be made; set TMPDIR to a folder of at most 68 bytes");
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
};

}  // namespace sunder
