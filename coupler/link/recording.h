#pragma once
// Records a session to a file, and plays it back to either side alone.
#include <cstdint>
#include <fstream>
#include <memory>
#include <string>

#include "coupler/link/transport.h"

namespace sunder::link {

/// Passes all messages on and records them. The file is a line "sunder recording 1" and then records. A record is one
/// character ('>' request, '<' reply, '!' message without reply), a length of eight bytes (little-endian), and the
/// message.
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

/// Plays the rigid side: gives the recorded reply to each request, as long as the requests are the recorded ones.
class ReplayTransport final : public Transport {
 public:
  /// Throws Error (bad_recording).
  explicit ReplayTransport(const std::string& path);
  /// The recorded reply. Throws Error (replay_differs), with the field, where the request differs from the recorded
  /// one.
  std::string ask(const std::string& request, double deadline_s, const char* what) override;
  void tell(const std::string&) override {}
  void check_peer() override {}

 private:
  std::string path_;
  std::ifstream file_;
  std::int64_t messages_ = 0;
};

/// Result of replay_requests.
struct ReplayReport {
  std::int64_t requests = 0, different = 0;  // number of requests, and of replies that differ
  std::string first;                         // the first difference; empty: none
};

/// Plays the shell side of a recording to `rigid` and compares replies to the bit, without times. Throws Error:
/// bad_recording, or the transport's errors.
ReplayReport replay_requests(Transport& rigid, const std::string& path);

}  // namespace sunder::link
