#include "shell/io/trace.h"

#include <chrono>
#include <limits>

#include <nlohmann/json.hpp>

#include "shell/io/vtp.h"

namespace sunder::shell {
namespace {

constexpr int kShell = 1, kRigid = 2;  // process numbers in the trace

std::string event(const std::string& name, int process, std::int64_t begin, std::int64_t end, std::int64_t window) {
  return fmt::format(
      ",\n{{\"name\": \"{}\", \"ph\": \"X\", \"pid\": {}, \"tid\": 1, \"ts\": {:.3f}, \"dur\": {:.3f}{}}}", name,
      process, 1e-3 * static_cast<double>(begin), 1e-3 * static_cast<double>(end - begin),
      window >= 0 ? fmt::format(", \"args\": {{\"window\": {}}}", window) : "");
}

// What the trace calls a process. A program of the user's may have any name.
std::string called(int process, const std::string& name) {
  const nlohmann::json event = {{"name", "process_name"}, {"ph", "M"}, {"pid", process}, {"args", {{"name", name}}}};
  return event.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// Keeps only plain characters: names come from the other process.
std::string plain(const std::string& name) {
  std::string out;
  for (const char c : name.substr(0, 64))
    if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ' ') out += c;
  return out;
}

}  // namespace

std::int64_t Trace::now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void Trace::add(const char* name, std::int64_t begin_ns, std::int64_t end_ns, std::int64_t window) {
  events_.push_back({name, begin_ns, end_ns, window});
}

void Trace::heard(const link::TimedReply& reply) { replies_.push_back(reply); }

void Trace::write(const std::string& path, const std::string& shell, const std::string& rigid) const {
  // The offset puts the engine's work into the middle of the exchange. Its error is at most half of the time that the
  // exchange took beyond that work.
  std::int64_t offset = 0, least = std::numeric_limits<std::int64_t>::max();
  for (const link::TimedReply& r : replies_) {
    if (r.spans.empty()) continue;
    const std::int64_t begin = r.spans.front().begin_ns(), end = r.spans.back().end_ns();
    const std::int64_t slack = (r.received_ns - r.sent_ns) - (end - begin);
    if (end < begin || slack < 0 || slack >= least) continue;
    least = slack, offset = (r.sent_ns - begin) + slack / 2;
  }
  std::int64_t start = std::numeric_limits<std::int64_t>::max();
  for (const Event& e : events_) start = std::min(start, e.begin);
  for (const link::TimedReply& r : replies_) start = std::min(start, r.sent_ns);
  std::string out = "{\"displayTimeUnit\": \"ms\", \"traceEvents\": [\n" + called(kShell, shell);
  if (!replies_.empty()) out += ",\n" + called(kRigid, rigid);
  for (const Event& e : events_) out += event(e.name, kShell, e.begin - start, e.end - start, e.window);
  for (const link::TimedReply& r : replies_) {
    out += event(r.request, kShell, r.sent_ns - start, r.received_ns - start, -1);
    for (const auto& s : r.spans)
      out += event(plain(s.name()), kRigid, s.begin_ns() + offset - start, s.end_ns() + offset - start, -1);
  }
  write_atomically(path, out + "\n]}\n");
}

}  // namespace sunder::shell
