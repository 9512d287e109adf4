// sunder-shell: the fracture solver's process; owns the loop, asks the rigid side once a window.
#include "coupler/link/channel.h"
#include "coupler/link/recording.h"
#include "shell/run/program.h"

namespace {

std::unique_ptr<sunder::link::RigidLink> connect(const std::string& endpoint, const sunder::shell::RunOptions& o) {
  using namespace sunder::link;
  std::unique_ptr<Transport> transport;
  if (!o.replay.empty())
    transport = std::make_unique<ReplayTransport>(o.replay);
  else
    transport = std::make_unique<Channel>(Channel::Role::kConnect, endpoint, o.keys);
  if (!o.record.empty()) transport = std::make_unique<RecordingTransport>(std::move(transport), o.record);
  return std::make_unique<RemoteRigid>(std::move(transport), o.scene_hash, o.heard);
}

}  // namespace

constexpr const char* kUsage =
    "sunder-shell hello --endpoint ADDRESS [--keys DIR]           asks an engine who it is, and prints that as JSON\n"
    "sunder-shell replay-rigid FILE --endpoint ADDRESS [--keys DIR]  plays a recording to an engine; status 1 where "
    "its\n"
    "                                                             answers differ\n";

// What asks an engine something without a scene. Returns the exit status.
int ask(const std::string& what, const std::vector<std::string>& arguments) {
  using namespace sunder;
  std::string endpoint, keys, file;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& option = arguments[i];
    if (option == "--endpoint" || option == "--keys") {
      require(i + 1 < arguments.size(), "{} needs a value\n{}", option, kUsage);
      (option == "--keys" ? keys : endpoint) = arguments[++i];
    } else {
      require(what == "replay-rigid" && file.empty() && option.rfind("--", 0) != 0, "{}: unknown option\n{}", option,
              kUsage);
      file = option;
    }
  }
  require(!endpoint.empty(), "--endpoint is missing\n{}", kUsage);
  auto channel = std::make_unique<link::Channel>(link::Channel::Role::kConnect, endpoint, keys);
  if (what == "hello") {
    link::RemoteRigid rigid(std::move(channel), "");
    std::string words;
    for (const std::string& word : rigid.peer().capabilities)
      words += fmt::format("{}\"{}\"", words.empty() ? "" : ", ", word);
    fmt::print("{{\"name\": \"{}\", \"version\": \"{}\", \"capabilities\": [{}]}}\n", rigid.peer().name,
               rigid.peer().version, words);
    rigid.bye();
    return 0;
  }
  require(!file.empty(), "replay-rigid: the recording is missing\n{}", kUsage);
  const link::ReplayReport report = link::replay_requests(*channel, file);
  fmt::print("{} requests, {} answers differ{}{}\n", report.requests, report.different,
             report.first.empty() ? "" : "; first: ", report.first);
  return report.different == 0 ? 0 : static_cast<int>(Exit::kCheckFailed);
}

int main(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first == "hello" || first == "replay-rigid") try {
      return ask(first, {argv + 2, argv + argc});
    } catch (const sunder::Error& e) {
      fmt::print(stderr, "sunder-shell: {}: {}\n", e.kind, e.what());
      return static_cast<int>(e.status);
    }
  return sunder::shell::run_program({"sunder-shell", "--endpoint", "ipc://PATH|tcp://HOST:PORT", connect}, argc, argv);
}
