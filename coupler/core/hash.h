#pragma once
// SHA-256, for hashes of scenes and states.
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace sunder {

/// SHA-256 of all bytes added so far (OpenSSL).
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  void add(const void* bytes, std::size_t size);
  void add(const std::string& text) { add(text.data(), text.size()); }
  void add(const std::vector<double>& values) { add(values.data(), values.size() * sizeof(double)); }
  /// Digest in 64 hexadecimal digits. May be called once; nothing can be added afterwards.
  std::string hex();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace sunder
