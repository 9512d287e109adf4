#pragma once
// A folder for what a test, a benchmark or a validation writes: private, of its own, and gone with its scope.
#include <cstdlib>
#include <filesystem>
#include <string>

#include "coupler/core/error.h"

namespace sunder {

struct TemporaryFolder {
  std::string path;
  TemporaryFolder() : path((std::filesystem::temp_directory_path() / "sunder-").string() + std::string(6, 'X')) {
    require(mkdtemp(path.data()) != nullptr, "{}: no folder can be made there; set TMPDIR", path);  // 0700
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
};

}  // namespace sunder
