#pragma once
// Errors that reach a user: the problem, its place and the remedy.
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace sunder {

/// Exit statuses of every program of the project.
enum class Exit : int { kDone = 0, kCheckFailed = 1, kBadInput = 2, kPeerLost = 3, kPhysics = 4, kInterrupted = 130 };

/// An error with its place. run.json has every field.
struct Error : std::runtime_error {
  Error(Exit status, std::string kind, const std::string& message)
      : std::runtime_error(message), status(status), kind(std::move(kind)) {}
  Exit status;
  std::string kind;          // one word: bad_scene, peer_lost, ledger, ...
  std::string file;          // empty: none
  int line = 0;              // 1-based; 0: none
  int column = 0;            // 1-based; 0: none
  std::string field;         // path in the scene or message; empty: none
  std::int64_t window = -1;  // counted from 0; -1: none
  std::string body;          // name or id; empty: none
};

/// Throws Error (bad_input) where `condition` is false. The text says field, value and remedy.
template <class... Args>
void require(bool condition, fmt::format_string<Args...> format, Args&&... args) {
  if (!condition) throw Error(Exit::kBadInput, "bad_input", fmt::format(format, std::forward<Args>(args)...));
}

/// Throws std::logic_error where `condition` is false: an error in this program. Also checked in release builds.
template <class... Args>
void ensure(bool condition, fmt::format_string<Args...> format, Args&&... args) {
  if (!condition) throw std::logic_error("internal error: " + fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace sunder
