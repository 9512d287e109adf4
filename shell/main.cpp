// sunder-shell: the fracture solver's process; owns the loop, asks the rigid side once a window.
#include <nlohmann/json.hpp>

#include "coupler/core/command_line.h"
#include "coupler/link/channel.h"
#include "coupler/link/recording.h"
#include "shell/run/program.h"

namespace {

// `process`: the rigid one where this machine has just started it; 0: none.
std::unique_ptr<sunder::link::Channel> channel_to(const std::string& endpoint, const std::string& keys, int process) {
  using sunder::link::Channel;
  auto channel = std::make_unique<Channel>(Channel::Role::kConnect, endpoint, keys);
  if (process > 0) channel->expect(process);
  return channel;
}

std::unique_ptr<sunder::link::RigidLink> connect(const std::string& endpoint, const sunder::shell::RunOptions& o) {
  using namespace sunder::link;
  std::unique_ptr<Transport> transport;
  if (!o.replay.empty())
    transport = std::make_unique<ReplayTransport>(o.replay);
  else {
    auto channel = channel_to(endpoint, o.keys, o.rigid_process);
    if (o.interrupted != nullptr) channel->give_up_when([flag = o.interrupted] { return flag->load(); });
    transport = std::move(channel);
  }
  if (!o.record.empty()) transport = std::make_unique<RecordingTransport>(std::move(transport), o.record);
  return std::make_unique<RemoteRigid>(std::move(transport), o.scene_hash, o.heard);
}

}  // namespace

namespace {

using namespace sunder;

int hello(const std::string& endpoint, const std::string& keys, int process) {
  link::RemoteRigid rigid(channel_to(endpoint, keys, process), "");
  const link::EngineInfo& peer = rigid.peer();
  const nlohmann::ordered_json said = {
      {"name", peer.name}, {"version", peer.version}, {"capabilities", peer.capabilities}};
  fmt::print("{}\n", said.dump());
  rigid.bye();
  return 0;
}

int replay_rigid(const std::string& file, const std::string& endpoint, const std::string& keys, int process) {
  const link::ReplayReport report = link::replay_requests(*channel_to(endpoint, keys, process), file);
  fmt::print("{} requests, {} answers differ{}{}\n", report.requests, report.different,
             report.first.empty() ? "" : "; first: ", report.first);
  return report.different == 0 ? 0 : static_cast<int>(Exit::kCheckFailed);
}

/// Asks an engine something without a scene. Returns the exit status.
int ask(const std::string& what, int argc, char** argv) {
  std::string endpoint, keys, file;
  int process = 0;
  const bool is_hello = what == "hello";
  CLI::App app(is_hello ? "Asks an engine who it is, and prints the answer as JSON."
                        : "Plays a recording to an engine; exit status 1 where its answers differ.",
               "sunder-shell " + what);
  app.add_option("--endpoint", endpoint, "Where the engine waits: ipc://PATH or tcp://HOST:PORT")
      ->required()
      ->take_last();
  app.add_option("--keys", keys, "Folder of keys: the session is encrypted")->type_name("DIR")->take_last();
  app.add_option("--rigid-process", process, "The engine's process, just started: its own time counts")
      ->type_name("PID")
      ->check(CLI::PositiveNumber)
      ->take_last();
  if (!is_hello) app.add_option("FILE", file, "The recording")->required();
  if (!read_arguments(app, argc, argv)) return 0;
  return is_hello ? hello(endpoint, keys, process) : replay_rigid(file, endpoint, keys, process);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first == "hello" || first == "replay-rigid" || first == "inspect") try {
      return first == "inspect" ? shell::inspect_program(argc - 1, argv + 1) : ask(first, argc - 1, argv + 1);
    } catch (const Error& e) {
      fmt::print(stderr, "sunder-shell: {}: {}\n", e.kind, e.what());
      return static_cast<int>(e.status);
    }
  return shell::run_program({"sunder-shell", "--endpoint", "ipc://PATH|tcp://HOST:PORT", connect}, argc, argv);
}
