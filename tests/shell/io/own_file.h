#pragma once
// A file that a test writes: of this process alone, and gone with its scope.
#include <cstdio>
#include <fstream>
#include <string>

#include "tests/coupler/small_scene.h"

namespace sunder::shell {

struct OwnFile {
  std::string name, path;  // as a scene beside it calls it, and the whole path
  OwnFile(const std::string& kind, const std::string& content)
      : name(fmt::format("{}_{}", getpid(), kind)), path(small_scene::own_file(kind)) {
    write(content);
  }
  ~OwnFile() { std::remove(path.c_str()); }
  OwnFile(const OwnFile&) = delete;
  OwnFile& operator=(const OwnFile&) = delete;

  void write(const std::string& content) const { std::ofstream(path, std::ios::binary | std::ios::trunc) << content; }
  std::string content() const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
};

}  // namespace sunder::shell
