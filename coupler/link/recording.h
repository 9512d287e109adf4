#pragma once
// A session on disk: written while it runs, played back to either side alone.
#include <cstdint>
#include <fstream>
#include <memory>
#include <string>

#include "coupler/link/transport.h"

namespace sunder::link {

/// Hands everything on and writes it down. The file: a line "sunder recording 1", then records of one character
/// ('>' request, '<' reply, '!' told without reply), eight bytes of length (little-endian) and the message.
class RecordingTransport final : public Transport {
 public:
  /// Throws Error (io) where the file cannot be written.
  RecordingTransport(std::unique_ptr<Transport> inner, const std::string& path);
  std::string ask(const std::string& request, double deadline_s, const char* what) override;
  void tell(const std::string& request) override;
  void check_peer() override { inner_->check_peer(); }

 private:
  void write(char kind, const std::string& bytes);
  std::unique_ptr<Transport> inner_;
  std::string path_;
  std::ofstream file_;
};

/// Plays the rigid side: answers as was recorded, while every request is what was recorded.
class ReplayTransport final : public Transport {
 public:
  /// Throws Error (bad_recording).
  explicit ReplayTransport(const std::string& path);
  /// Throws Error (replay_differs) with the field, where the request is another one.
  std::string ask(const std::string& request, double deadline_s, const char* what) override;
  void tell(const std::string&) override {}
  void check_peer() override {}

 private:
  std::string path_;
  std::ifstream file_;
  std::int64_t messages_ = 0;
};

struct ReplayReport {
  std::int64_t requests = 0, different = 0;
  std::string first;  // difference
};

/// Plays the shell's side of a recording to `rigid` and compares its replies to the bit, times left out.
/// Throws Error: bad_recording, or what the transport throws.
ReplayReport replay_requests(Transport& rigid, const std::string& path);

}  // namespace sunder::link
