#include "coupler/scene/gltf_uri.h"

#include <cctype>
#include <cstdint>
#include <fstream>
#include <sstream>

namespace sunder::scene {
namespace {

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

bool is_hexadecimal(char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; }

}  // namespace

std::string gltf_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return std::move(out).str();
}

std::string gltf_path(const std::string& uri) {
  std::string out;
  for (std::size_t k = 0; k < uri.size(); ++k) {
    if (uri[k] == '%' && k + 2 < uri.size() && is_hexadecimal(uri[k + 1]) && is_hexadecimal(uri[k + 2]))
      out += static_cast<char>(std::stoi(uri.substr(k + 1, 2), nullptr, 16)), k += 2;
    else
      out += uri[k];
  }
  return out;
}

std::string gltf_data(const MeshFile& mesh, const std::string& uri, const std::string& own) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string::npos || uri.substr(0, comma).find(";base64") == std::string::npos)
    mesh.fail(fmt::format("has {}.uri that is no base64; export it as .glb", own));
  std::string out;
  std::uint32_t bits = 0;
  int have = 0;
  for (std::size_t k = comma + 1; k < uri.size() && uri[k] != '='; ++k) {
    const int digit = base64_digit(uri[k]);
    if (digit < 0) mesh.fail(fmt::format("has {}.uri with a character that base64 has not; export it again", own));
    bits = bits << 6 | static_cast<std::uint32_t>(digit), have += 6;
    if (have >= 8) have -= 8, out += static_cast<char>(bits >> have & 255u);
  }
  return out;
}

}  // namespace sunder::scene
