#pragma once
// Errors that reach a user: what went wrong, where, and what to do about it.
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace sunder {

/// Exit statuses of every program of the project.
enum class Exit : int { kDone = 0, kCheckFailed = 1, kBadInput = 2, kPeerLost = 3, kPhysics = 4, kInterrupted = 130 };

/// An error with the place it belongs to; run.json carries every field.
struct Error : std::runtime_error {
  Error(Exit status, std::string kind, const std::string& message)
      : std::runtime_error(message), status(status), kind(std::move(kind)) {}
  Exit status;
  std::string kind;  // one word: bad_scene, peer_lost, ledger, ...
  std::string file;  // empty: none
  int line = 0;      // 1-based; 0: none
  int column = 0;
  std::string field;
  std::int64_t window = -1;
  std::string body;
};

/// Throws an Error of status bad input unless `condition` holds; `format` says field, value, remedy.
template <class... Args>
void require(bool condition, fmt::format_string<Args...> format, Args&&... args) {
  if (!condition) throw Error(Exit::kBadInput, "bad_input", fmt::format(format, std::forward<Args>(args)...));
}

/// For what can only be our own mistake; stays on in release builds.
template <class... Args>
void ensure(bool condition, fmt::format_string<Args...> format, Args&&... args) {
  if (!condition) throw std::logic_error("internal error: " + fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace sunder
