// The rules of a session: a wrong request gets an Error as reply, and the process ends.
#include <cmath>
#include <functional>

#include "coupler/link/capabilities.h"
#include "coupler/link/messages.h"
#include "exchange.pb.h"
#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;
using Requests = std::vector<proto::Request>;

constexpr double kEndSeconds = 2.0;  // limit of both sides for the end of a session
constexpr int kPeerLost = static_cast<int>(Exit::kPeerLost);

RigidBody any_body(const Suite& s, BodyId id) {
  if (s.info.can(kSpheres)) return sphere(id, 0.05);
  if (s.info.can(kBoxes)) return box(id, {0.05, 0.04, 0.03});
  return plate(id, {rectangle(0, 0, 0.06, 0.03)}, 0.01);
}

proto::Request hello() {
  proto::Request r;
  r.mutable_hello()->set_protocol_min(link::kProtocol), r.mutable_hello()->set_protocol_max(link::kProtocol);
  return r;
}

proto::Request load(const Suite& s) {
  proto::Request r;
  *r.mutable_load()->add_bodies() = link::encode(any_body(s, 1));
  return r;
}

proto::Request window(const Suite& s, std::int64_t tick = 0) {
  proto::Request r;
  auto* w = r.mutable_window();
  w->set_tick(tick), w->set_ticks(1), w->set_window_s(1e-3);
  *w->add_predicted() = link::encode(link::Motion{1, any_body(s, 1).motion});
  return r;
}

// Sends requests of which the last one is wrong. The row counts broken rules.
void refused(Suite& s, const std::string& what, const Requests& requests) {
  EngineProcess process(s.target);
  std::string broken;
  int count = 0;
  const auto note = [&](const std::string& words) { ++count, broken += (broken.empty() ? "" : "; ") + words; };
  {
    const auto channel = open_channel(process.endpoint());
    std::uint64_t sequence = 0;
    for (std::size_t i = 0; i < requests.size(); ++i) {
      proto::Request r = requests[i];
      ++sequence;
      if (r.sequence() == 0) r.set_sequence(sequence);
      proto::Reply reply;
      std::string bytes;
      try {
        bytes = channel->ask(r.SerializeAsString(), 10.0, what.c_str());
      } catch (const Error& e) {
        note(fmt::format("no reply: {}", e.what()));
        break;
      }
      if (!reply.ParseFromString(bytes)) {
        note("a reply that cannot be read");
        break;
      }
      const bool last = i + 1 == requests.size();
      if (reply.sequence() != sequence) note(fmt::format("reply {} to request {}", reply.sequence(), sequence));
      if (!last && reply.has_error()) {
        note("refused before it was wrong: " + reply.error().message());
        break;
      }
      if (last && !reply.has_error()) note("taken, and no Error");
      if (last && reply.has_error() && (reply.error().kind().empty() || reply.error().message().empty()))
        note("an Error that says nothing");
    }
    if (const auto status = process.wait(kEndSeconds); process.ours() && status != kPeerLost)
      note(status ? fmt::format("ends with status {}, must be {}", *status, kPeerLost) : "still runs after 2 s");
  }
  s.report.check(what, count, 0.0, 0.0, broken);
}

Requests spoiled(const Suite& s, const std::function<void(proto::Window&)>& spoil) {
  proto::Request r = window(s);
  spoil(*r.mutable_window());
  return {hello(), load(s), r};
}

// Requests for capabilities that the engine does not declare. An engine with all capabilities has no row here.
void undeclared(Suite& s) {
  proto::Request save, restore, more, rows, kept = load(s);
  save.mutable_save(), restore.mutable_restore(), more.mutable_add_bodies();
  rows.mutable_export_()->set_window_s(1e-3);
  *rows.mutable_export_()->add_motions() = link::encode(link::Motion{1, any_body(s, 1).motion});
  kept.mutable_load()->set_keep_windows(true);
  if (!s.info.can(kExportRows)) refused(s, "export_not_declared", {hello(), load(s), rows});
  if (s.info.can(kSaveRestore)) return;
  refused(s, "save_not_declared", {hello(), load(s), save});
  refused(s, "restore_not_declared", {hello(), load(s), restore});
  refused(s, "add_bodies_not_declared", {hello(), load(s), more});
  refused(s, "keep_windows_not_declared", {hello(), kept});
}

void turns(Suite& s) {
  proto::Request old = hello(), late = load(s), twice = load(s);
  old.mutable_hello()->set_protocol_min(link::kProtocol + 1),
      old.mutable_hello()->set_protocol_max(link::kProtocol + 7);
  late.set_sequence(7);
  *twice.mutable_load()->add_bodies() = link::encode(any_body(s, 1));
  refused(s, "version", {old});
  refused(s, "sequence", {hello(), late});
  refused(s, "load_before_hello", {load(s)});
  refused(s, "window_before_load", {hello(), window(s)});
  refused(s, "second_hello", {hello(), hello()});
  refused(s, "second_load", {hello(), load(s), load(s)});
  refused(s, "no_content", {hello(), proto::Request()});
  refused(s, "body_twice", {hello(), twice});
  undeclared(s);
}

void windows(Suite& s) {
  const double nan = std::nan("");
  refused(s, "tick", spoiled(s, [](auto& w) { w.set_tick(7); }));
  refused(s, "tick_repeated", {hello(), load(s), window(s), window(s)});
  refused(s, "no_ticks", spoiled(s, [](auto& w) { w.set_ticks(0); }));
  refused(s, "length_nan", spoiled(s, [&](auto& w) { w.set_window_s(nan); }));
  refused(s, "length_negative", spoiled(s, [](auto& w) { w.set_window_s(-1e-3); }));
  refused(s, "unknown_id", spoiled(s, [](auto& w) { w.mutable_predicted(0)->set_id(9); }));
  refused(s, "predicted_state_missing", spoiled(s, [](auto& w) { w.clear_predicted(); }));
  refused(s, "position_nan", spoiled(s, [&](auto& w) { w.mutable_predicted(0)->mutable_position()->set_x(nan); }));
  refused(s, "velocity_infinite",
          spoiled(s, [](auto& w) { w.mutable_predicted(0)->mutable_velocity()->set_z(INFINITY); }));
  refused(s, "quaternion", spoiled(s, [](auto& w) { w.mutable_predicted(0)->mutable_orientation()->set_x(0.1); }));
  refused(s, "no_quaternion", spoiled(s, [](auto& w) { w.mutable_predicted(0)->clear_orientation(); }));
  refused(s, "birth_without_shape", spoiled(s, [](auto& w) { w.add_births()->set_id(2); }));
  if (s.info.can(kExportRows))
    refused(s, "solved_body_that_is_not_there", spoiled(s, [](auto& w) { w.add_solved(9); }));
  refused(s, "birth_of_held_id", spoiled(s, [&](auto& w) { *w.add_births() = link::encode(any_body(s, 1)); }));
}

// Ends of a session; `leave` ends this side.
void ends(Suite& s, const std::string& what, int right, const std::function<void(link::Transport&)>& leave) {
  EngineProcess process(s.target);
  {
    const auto channel = open_channel(process.endpoint());
    std::uint64_t sequence = 0;
    for (proto::Request r : {hello(), load(s)}) {
      r.set_sequence(++sequence);
      channel->ask(r.SerializeAsString(), 10.0, what.c_str());
    }
    leave(*channel);
  }
  if (!process.ours()) return s.report.tell(what, 0.0, "a process that is not ours has no status to be seen");
  const auto status = process.wait(kEndSeconds);
  s.report.check_error(what, status ? *status : NAN, right, status ? std::abs(*status - right) : NAN, 0.0,
                       status ? "exit status" : "still runs after 2 s");
}

void endings(Suite& s) {
  ends(s, "bye", 0, [](link::Transport& channel) {
    proto::Request r;
    r.set_sequence(3), r.mutable_bye();
    channel.ask(r.SerializeAsString(), 10.0, "Bye");
  });
  ends(s, "shell_failed", kPeerLost, [](link::Transport& channel) {
    proto::Request r;
    r.set_sequence(3), r.mutable_error()->set_kind("unstable"), r.mutable_error()->set_message("the energy is nan");
    channel.tell(r.SerializeAsString());
  });
  ends(s, "shell_gone", kPeerLost, [](link::Transport&) {});  // as a killed process: its connection closes
  ends(s, "no_request", kPeerLost, [](link::Transport& channel) {
    proto::Reply reply;
    const std::string answer = channel.ask("\xff\xff\xff not a request", 10.0, "bytes that are no request");
    if (!reply.ParseFromString(answer) || !reply.has_error())
      throw Error(Exit::kCheckFailed, "no_error", "bytes that are no request were taken without an Error");
  });
}

void words(Suite& s) {
  const std::vector<std::string> notes = link::unknown_word_notes(s.info);
  std::string all;
  for (const std::string& note : notes) all += (all.empty() ? "" : "; ") + note;
  s.report.check("unknown", static_cast<double>(notes.size()), 0.0, 0.0, all);
}

}  // namespace

std::vector<Case> rule_cases() {
  return {
      {"rules_words", "declares capabilities only", {}, words},
      {"rules_turn", "requests out of turn are refused", {}, turns},
      {"rules_window", "wrong windows are refused", {}, windows},
      {"rules_end", "a session ends as it should", {}, endings},
  };
}

}  // namespace sunder::conformance
