// sunder-shell: the fracture solver's process; owns the loop, asks the rigid side once a window.
#include "coupler/link/channel.h"
#include "coupler/link/recording.h"
#include "shell/io/program.h"

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

int main(int argc, char** argv) {
  return sunder::shell::run_program({"sunder-shell", "--endpoint", "ipc://PATH|tcp://HOST:PORT", connect}, argc, argv);
}
