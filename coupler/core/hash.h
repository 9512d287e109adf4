#pragma once
// SHA-256, for scene identity and state hashes.
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace sunder {

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  void add(const void* bytes, std::size_t size);
  void add(const std::string& text) { add(text.data(), text.size()); }
  void add(const std::vector<double>& values) { add(values.data(), values.size() * sizeof(double)); }
  /// Hexadecimal digest; may be called once.
  std::string hex();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace sunder
