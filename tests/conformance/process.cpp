#include "tests/conformance/process.h"

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "coupler/core/error.h"
#include "coupler/core/own_time.h"

namespace sunder::conformance {
namespace {

constexpr useconds_t kPoll_us = 2000;
constexpr useconds_t kLastSession_us = 200000;  // a running engine may still end its last session
constexpr double kKillSeconds = 5.0;
constexpr double kBindSeconds = 600.0;  // includes the start of an interpreter on a busy machine
constexpr int kCannotExecute = 127;

}  // namespace

double seconds_now() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

EngineProcess::EngineProcess(const Target& target) : endpoint_(target.endpoint) {
  if (target.command.empty()) {
    usleep(kLastSession_us);
    return;
  }
  folder_.emplace();
  endpoint_ = "ipc://" + folder_->path + "/link";
  std::vector<std::string> command = target.command;
  for (const std::string& a : {std::string("--endpoint"), endpoint_, std::string("--die-with-parent")})
    command.push_back(a);
  std::vector<char*> argv;
  for (std::string& a : command) argv.push_back(a.data());
  argv.push_back(nullptr);
  const std::string log = folder_->path + "/log";
  pid_ = fork();
  if (pid_ < 0) throw Error(Exit::kBadInput, "bad_engine", "no process can be started");
  if (pid_ == 0) {
    const int in = open("/dev/null", O_RDONLY), out = open(log.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
    dup2(in, 0), dup2(out, 1), dup2(out, 2);
    execvp(argv[0], argv.data());
    _exit(kCannotExecute);
  }
  const double end = seconds_now() + kBindSeconds;
  while (!std::filesystem::exists(folder_->path + "/link") && !wait(0.0) && seconds_now() < end) usleep(kPoll_us);
  if (wait(0.0)) {
    throw Error(
        Exit::kPeerLost, "bad_engine",
        fmt::format("{} ends with status {} before there is a session. {}", command[0], *status_, last_words()));
  }
}

EngineProcess::~EngineProcess() {
  if (ours() && !wait(0.0)) kill(pid_, SIGKILL), wait(kKillSeconds);
}

std::optional<int> EngineProcess::wait(double seconds) {
  if (!ours()) return std::nullopt;
  for (OwnTime had(pid_); !status_; usleep(kPoll_us)) {
    int s = 0;
    if (waitpid(pid_, &s, WNOHANG) == pid_) status_ = WIFEXITED(s) ? WEXITSTATUS(s) : 256 + WTERMSIG(s);
    if (status_ || had.look() >= seconds) break;
  }
  return status_;
}

std::string EngineProcess::last_words() const {
  if (!folder_) return {};
  std::ifstream in(folder_->path + "/log");
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) last = line;
  return last;
}

}  // namespace sunder::conformance
