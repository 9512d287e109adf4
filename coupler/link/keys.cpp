#include "coupler/link/keys.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <tuple>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include "coupler/core/error.h"

namespace sunder::link {
namespace {

constexpr std::size_t kBytes = 32, kCharacters = 40;  // of a key, and of its Z85
constexpr const char* kMakeNew = "copy it again, or make new keys for both sides with 'sunder keys DIR'";

struct Text {
  char characters[kCharacters + 1] = {};
};

[[noreturn]] void refuse_key(const std::string& path, const std::string& problem, const std::string& remedy) {
  throw Error(Exit::kBadInput, "bad_keys", fmt::format("{}: {}; {}", path, problem, remedy));
}

const char* name(Side side) { return side == Side::kRigid ? "rigid" : "shell"; }
Side other(Side side) { return side == Side::kRigid ? Side::kShell : Side::kRigid; }

struct File {
  int fd;
  explicit File(int fd) : fd(fd) {}
  ~File() {
    if (fd >= 0) close(fd);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
};

// A user who can replace a public key can make the session admit another process.
void only_we_write(const std::string& path, const struct stat& info) {
  if ((info.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    refuse_key(path, fmt::format("others may write it (mode {:04o})", info.st_mode & 07777),
               fmt::format("chmod go-w {}", path));
}

Text read_text(const std::string& path, bool secret) {
  const File file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // a pipe must not block
  if (file.fd < 0)
    refuse_key(path, std::strerror(errno), "--keys DIR is a folder that 'sunder keys DIR' made, or a copy of it");
  struct stat info {};  // of the open file: the path may name another one a moment later
  if (fstat(file.fd, &info) != 0 || !S_ISREG(info.st_mode)) refuse_key(path, "is no file", kMakeNew);
  if (secret && (info.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    refuse_key(path, fmt::format("the secret key is open to others (mode {:04o})", info.st_mode & 07777),
               fmt::format("chmod 600 {}, and make new keys if others may have read it", path));
  only_we_write(path, info);
  char read_bytes[kCharacters + 3];
  const ssize_t count = read(file.fd, read_bytes, sizeof read_bytes);
  if (count < 0) refuse_key(path, std::strerror(errno), kMakeNew);
  std::size_t size = static_cast<std::size_t>(count);
  if (size > 0 && read_bytes[size - 1] == '\n') --size;  // an editor may add it
  if (size != kCharacters)
    refuse_key(path,
               fmt::format("has {}{} characters, a key has {}", size > kCharacters ? "more than " : "",
                           std::min(size, kCharacters), kCharacters),
               kMakeNew);
  Text text;
  std::memcpy(text.characters, read_bytes, kCharacters);
  return text;
}

std::string decode(const std::string& path, const Text& text) {
  std::string bytes(kBytes, '\0');
  if (std::strlen(text.characters) != kCharacters ||
      zmq_z85_decode(reinterpret_cast<std::uint8_t*>(bytes.data()), text.characters) == nullptr)
    refuse_key(path, "is damaged: not all of it is Z85", kMakeNew);
  return bytes;
}

void write_text(const std::string& path, const Text& text, mode_t mode, std::vector<std::string>& made) {
  const File file(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
  if (file.fd >= 0) made.push_back(path);
  const std::string line = std::string(text.characters) + "\n";
  if (file.fd < 0 || write(file.fd, line.data(), line.size()) != static_cast<ssize_t>(line.size()) ||
      fchmod(file.fd, mode) != 0)  // independent of the umask
    refuse_key(path, std::strerror(errno), "name a folder that may be written, on a disk with room");
}

}  // namespace

void make_keys(const std::string& folder) {
  const bool is_new = mkdir(folder.c_str(), 0700) == 0;
  if (!is_new) {
    const int error = errno;
    std::error_code ignored;
    if (error == EEXIST &&
        !(std::filesystem::is_directory(folder, ignored) && std::filesystem::is_empty(folder, ignored)))
      refuse_key(folder, "is there already and not an empty folder", "name a new one: no key is ever written over");
    if (error != EEXIST || chmod(folder.c_str(), 0700) != 0)
      refuse_key(folder, std::strerror(error == EEXIST ? errno : error), "name a folder that may be made");
  }
  std::vector<std::string> made;
  try {
    for (const Side side : {Side::kRigid, Side::kShell}) {
      Text open_text, secret_text;
      if (zmq_curve_keypair(open_text.characters, secret_text.characters) != 0)
        refuse_key(folder, "this machine's ZeroMQ has no CURVE", "install one that is built with libsodium");
      const std::string stem = folder + "/" + name(side);
      for (const auto& [ending, text, mode] :
           {std::tuple(".key", &secret_text, mode_t{0600}), std::tuple(".pub", &open_text, mode_t{0644})})
        write_text(stem + ending, *text, mode, made);
    }
  } catch (const Error&) {
    for (const std::string& path : made) unlink(path.c_str());
    if (is_new) rmdir(folder.c_str());
    throw;
  }
}

Keys read_keys(const std::string& folder, Side side) {
  struct stat info {};
  if (stat(folder.c_str(), &info) != 0 || !S_ISDIR(info.st_mode))
    refuse_key(folder, "no such folder", "make it with 'sunder keys DIR' and copy it to both machines");
  only_we_write(folder, info);
  const std::string own = folder + "/" + name(side), peer = folder + "/" + name(other(side)) + ".pub";
  const Text secret = read_text(own + ".key", true);
  Keys keys{decode(own + ".key", secret), decode(own + ".pub", read_text(own + ".pub", false)),
            decode(peer, read_text(peer, false))};
  Text derived;
  if (zmq_curve_public(derived.characters, secret.characters) != 0)
    refuse_key(own + ".key", "this machine's ZeroMQ has no CURVE", "install one that is built with libsodium");
  if (decode(own + ".pub", derived) != keys.own_public)
    refuse_key(own + ".pub", fmt::format("does not belong to {}.key", own), kMakeNew);
  return keys;
}

}  // namespace sunder::link
