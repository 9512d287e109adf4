// The file of a checkpoint: whole, of this build and of this scene, or refused.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/io/checkpoint_file.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

std::string contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string refusal(const std::string& path, const std::string& scene_hash) {
  try {
    read_checkpoint(path, scene_hash);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "bad_checkpoint");
    EXPECT_EQ(e.status, Exit::kBadInput);
    EXPECT_EQ(e.file, path);
    return e.what();
  }
  return "";
}

bool has_text(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

}  // namespace

TEST(CheckpointFile, ComesBackToTheByte) {
  const TemporaryFolder folder;
  const std::string path = checkpoint_path(folder.path);
  std::string bytes("\n\0 any \xff bytes", 14);
  bytes.append(3, '\0');
  for (const std::string& text : {bytes, std::string(), std::string(100000, 'x')}) {
    write_checkpoint(path, "scene", text);
    EXPECT_EQ(read_checkpoint(path, "scene"), text);
  }
  int files = 0;  // nothing half written stays beside it
  for ([[maybe_unused]] const auto& f : std::filesystem::directory_iterator(std::filesystem::path(path).parent_path()))
    ++files;
  EXPECT_EQ(files, 1);
}

TEST(CheckpointFile, IsRefusedWhereItIsMissingDamagedOrOfAnotherScene) {
  const TemporaryFolder folder;
  const std::string path = checkpoint_path(folder.path);
  EXPECT_TRUE(has_text(refusal(path, "scene"), "there is no checkpoint"));
  write_checkpoint(path, "scene", "the state of a run");
  const std::string whole = contents(path);
  EXPECT_TRUE(has_text(refusal(path, "another"), "is of another scene"));
  std::string other_sources = whole;
  const std::size_t at = other_sources.find(source_hash());
  ASSERT_NE(at, std::string::npos);
  other_sources[at] = other_sources[at] == '0' ? '1' : '0';
  std::ofstream(path, std::ios::binary) << other_sources;
  EXPECT_TRUE(has_text(refusal(path, "scene"), "other sources or another compiler wrote it"));
  for (std::size_t i = 0; i < whole.size(); i += 7) {  // in the head, the bytes and the sum
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 4);
    std::ofstream(path, std::ios::binary) << damaged;
    EXPECT_NE(refusal(path, "scene"), "") << i;
  }
  for (const std::size_t length : {std::size_t{0}, std::size_t{10}, whole.size() / 2, whole.size() - 1}) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, length);
    EXPECT_NE(refusal(path, "scene"), "") << length;
  }
  std::ofstream(path, std::ios::binary) << whole << "x";
  EXPECT_TRUE(has_text(refusal(path, "scene"), "is damaged"));
}
