#include "shell/io/checkpoint_file.h"

#include <filesystem>
#include <fstream>

#include "coupler/core/error.h"
#include "coupler/core/hash.h"
#include "shell/io/vtp.h"

namespace sunder::shell {
namespace {

/// Only the build that wrote a checkpoint reads it: plain structures are stored as they are in memory.
std::string first_line() { return fmt::format("sunder checkpoint, {}, {}\n", source_hash(), __VERSION__); }

constexpr std::size_t kHashDigits = 64;

std::string digest(const std::string& bytes) {
  Sha256 h;
  h.add(bytes.data(), bytes.size());
  return h.hex();
}

}  // namespace

std::string checkpoint_path(const std::string& out) { return out + "/checkpoint/state"; }

void bad_checkpoint(const std::string& path, const std::string& what) {
  Error e(Exit::kBadInput, "bad_checkpoint", fmt::format("{}: {}; run the scene anew", path, what));
  e.file = path;
  throw e;
}

void write_checkpoint(const std::string& path, const std::string& scene_hash, const std::string& bytes) {
  const std::string body = first_line() + scene_hash + "\n" + bytes;
  std::error_code ignored;  // an error shows when the file is written
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
  write_atomically(path, body + digest(body));
}

std::string read_checkpoint(const std::string& path, const std::string& scene_hash) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    bad_checkpoint(path,
                   "there is no checkpoint; a run writes one every output.checkpoint_interval_s, if its engine can do "
                   "'save_restore'");
  std::string bytes((std::istreambuf_iterator<char>(file)), {});
  const std::string build = first_line(), head = build + scene_hash + "\n";
  if (bytes.size() < build.size() + kHashDigits || bytes.compare(0, build.size(), build) != 0)
    bad_checkpoint(path, "is no checkpoint of this build: other sources or another compiler wrote it");
  const std::string sum = bytes.substr(bytes.size() - kHashDigits);
  bytes.resize(bytes.size() - kHashDigits);
  if (digest(bytes) != sum) bad_checkpoint(path, "is damaged");
  if (bytes.compare(0, head.size(), head) != 0)
    bad_checkpoint(path, "is of another scene, or of one with other settings");
  return bytes.substr(head.size());
}

}  // namespace sunder::shell
