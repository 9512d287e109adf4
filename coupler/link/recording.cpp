#include "coupler/link/recording.h"

#include <google/protobuf/util/message_differencer.h>

#include "coupler/core/error.h"
#include "coupler/link/messages.h"

namespace sunder::link {
namespace {

const std::string kFirstLine = "sunder recording 1\n";
constexpr char kRequest = '>', kReply = '<', kTold = '!';
constexpr int kLengthBytes = 8;

[[noreturn]] void bad(const std::string& path, const std::string& what) {
  Error e(Exit::kBadInput, "bad_recording", fmt::format("{}: {}; record the run anew", path, what));
  e.file = path;
  throw e;
}

// False at the end of the file.
bool read_record(std::ifstream& file, const std::string& path, char& kind, std::string& bytes) {
  const int first = file.get();
  if (first == std::char_traits<char>::eof()) return false;
  kind = static_cast<char>(first);
  if (kind != kRequest && kind != kReply && kind != kTold)
    bad(path, fmt::format("byte {} begins no record", static_cast<std::int64_t>(file.tellg()) - 1));
  unsigned char length[kLengthBytes];
  file.read(reinterpret_cast<char*>(length), kLengthBytes);
  std::uint64_t size = 0;
  for (int i = kLengthBytes - 1; i >= 0; --i) size = size << 8 | length[i];
  if (!file || size > kMaxMessage) bad(path, "ends within a record, or a record is too long");
  bytes.resize(size);
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!file) bad(path, "ends within a record");
  return true;
}

std::ifstream open_recording(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) bad(path, "cannot be read");
  std::string line(kFirstLine.size(), '\0');
  file.read(line.data(), static_cast<std::streamsize>(line.size()));
  if (!file || line != kFirstLine) bad(path, "is no recording of a session");
  return file;
}

// The first field in which two messages differ; empty where they are equal.
template <class Message>
std::string difference(const std::string& recorded, const std::string& now) {
  Message a, b;
  if (!a.ParseFromString(recorded) || !b.ParseFromString(now)) return "a message that does not parse";
  if constexpr (std::is_same_v<Message, proto::Reply>) a.clear_spans(), b.clear_spans();
  if constexpr (std::is_same_v<Message, proto::Request>)  // tracing does not change the results
    for (Message* m : {&a, &b})
      if (m->has_hello()) m->mutable_hello()->clear_trace();
  std::string report;
  google::protobuf::util::MessageDifferencer differ;
  differ.ReportDifferencesToString(&report);
  if (differ.Compare(a, b)) return "";
  return report.substr(0, report.find('\n'));
}

}  // namespace

RecordingTransport::RecordingTransport(std::unique_ptr<Transport> inner, const std::string& path)
    : inner_(std::move(inner)), path_(path), file_(path, std::ios::binary) {
  file_ << kFirstLine;
  if (!file_.flush()) throw Error(Exit::kBadInput, "io", path_ + ": cannot be written");
}

void RecordingTransport::write(char kind, const std::string& bytes) {
  file_.put(kind);
  for (int i = 0; i < kLengthBytes; ++i) file_.put(static_cast<char>(bytes.size() >> (8 * i) & 0xff));
  file_ << bytes;
  if (!file_) throw Error(Exit::kBadInput, "io", path_ + ": cannot be written; free some space, or do not record");
}

std::string RecordingTransport::ask(const std::string& request, double deadline_s, const char* what) {
  write(kRequest, request);
  std::string reply = inner_->ask(request, deadline_s, what);
  write(kReply, reply);
  return reply;
}

void RecordingTransport::tell(const std::string& request) {
  write(kTold, request);
  inner_->tell(request);
}

ReplayTransport::ReplayTransport(const std::string& path) : path_(path), file_(open_recording(path)) {}

std::string ReplayTransport::ask(const std::string& request, double, const char* what) {
  char kind = 0;
  std::string recorded, reply;
  if (!read_record(file_, path_, kind, recorded) || kind != kRequest)
    throw Error(Exit::kCheckFailed, "replay_differs",
                fmt::format("request {} ({}): the recording ends before it", messages_ + 1, what));
  ++messages_;
  const std::string differs = recorded == request ? "" : difference<proto::Request>(recorded, request);
  if (!differs.empty())
    throw Error(Exit::kCheckFailed, "replay_differs",
                fmt::format("request {} ({}) is not as recorded: {}", messages_, what, differs));
  if (!read_record(file_, path_, kind, reply) || kind != kReply)
    throw Error(Exit::kCheckFailed, "replay_differs",
                fmt::format("request {} ({}): no reply was recorded: the run ended here", messages_, what));
  return reply;
}

ReplayReport replay_requests(Transport& rigid, const std::string& path) {
  std::ifstream file = open_recording(path);
  ReplayReport report;
  char kind = 0;
  std::string request, recorded;
  while (read_record(file, path, kind, request)) {
    if (kind == kTold) {
      rigid.tell(request);
      break;
    }
    if (kind != kRequest) bad(path, "has a reply without a request");
    ++report.requests;
    const std::string reply = rigid.ask(request, 0.0, "a recorded request");
    if (!read_record(file, path, kind, recorded) || kind != kReply) break;  // end of the recorded run
    const std::string differs = reply == recorded ? "" : difference<proto::Reply>(recorded, reply);
    if (differs.empty()) continue;
    ++report.different;
    if (report.first.empty()) report.first = fmt::format("reply {}: {}", report.requests, differs);
  }
  return report;
}

}  // namespace sunder::link
