#pragma once
// Starts the real executables of both sides, for tests/end_to_end.
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include "coupler/core/own_time.h"
#include "tests/temporary_folder.h"

namespace sunder::test {

inline double now() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
inline void pause(double seconds) { usleep(static_cast<useconds_t>(1e6 * seconds)); }

/// A child process; it is killed at the end of its scope.
class Process {
 public:
  Process(const std::vector<std::string>& command, const std::string& log) {
    std::vector<char*> argv;
    for (const std::string& a : command) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      const int fd = open(log.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
      dup2(fd, 1), dup2(fd, 2);
      execv(argv[0], argv.data());
      _exit(127);
    }
  }
  ~Process() {
    if (running()) send(SIGKILL), wait(5.0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) const { kill(pid_, signal); }
  bool running() {
    if (status_ < 0) {
      int s = 0;
      if (waitpid(pid_, &s, WNOHANG) == pid_) status_ = WIFEXITED(s) ? WEXITSTATUS(s) : 256 + WTERMSIG(s);
    }
    return status_ < 0;
  }
  /// Exit status; 256 + the signal where one ended it, -1 where it still runs after `seconds` of its own time.
  int wait(double seconds) {
    for (OwnTime had(pid_); running() && had.look() < seconds;) pause(0.005);
    return status_;
  }

 private:
  pid_t pid_ = -1;
  int status_ = -1;
};

inline std::string read_file(const std::string& path) {
  std::stringstream s;
  s << std::ifstream(path).rdbuf();
  return s.str();
}

/// Both processes of one run, in a fresh folder.
class Pair {
 public:
  /// `wrapper` is a command that runs the shell's command.
  Pair(const std::string& scene, const std::vector<std::string>& options,
       const std::vector<std::string>& wrapper = {}) {
    const std::string endpoint = "ipc://" + folder_.path + "/socket";
    rigid = std::make_unique<Process>(std::vector<std::string>{SUNDER_RIGID, "--endpoint", endpoint},
                                      folder_.path + "/rigid.log");
    std::vector<std::string> command = wrapper;
    for (const std::string& a :
         {std::string(SUNDER_SHELL), std::string("--scene"), SUNDER_SCENES + ("/" + scene), std::string("--out"), out(),
          std::string("--endpoint"), endpoint, std::string("--quiet")})
      command.push_back(a);
    command.insert(command.end(), options.begin(), options.end());
    std::filesystem::create_directory(out());
    shell = std::make_unique<Process>(command, folder_.path + "/shell.log");
  }
  ~Pair() { shell.reset(), rigid.reset(); }
  std::string out() const { return folder_.path + "/out"; }
  std::string log(const std::string& side) const { return read_file(folder_.path + "/" + side + ".log"); }
  /// Waits until the shell has written its n-th frame. Returns false after `seconds`.
  bool frame(int n, double seconds) const {
    const std::string path = fmt::format("{}/frames/bodies_{:06d}.vtp", out(), n);
    for (const double end = now() + seconds; now() < end; pause(0.005))
      if (std::filesystem::exists(path)) return true;
    return false;
  }

  google::protobuf::Struct summary() const {
    google::protobuf::Struct s;
    const auto status = google::protobuf::util::JsonStringToMessage(read_file(out() + "/run.json"), &s);
    EXPECT_TRUE(status.ok()) << status.ToString() << log("shell");
    return s;
  }
  /// Returns a number or text of run.json by its path, such as "time.simulated_s".
  google::protobuf::Value value(const std::string& path) const {
    google::protobuf::Value v;
    *v.mutable_struct_value() = summary();
    std::stringstream parts(path);
    for (std::string key; std::getline(parts, key, '.');) {
      const auto& fields = v.struct_value().fields();
      EXPECT_TRUE(fields.contains(key)) << path;
      if (!fields.contains(key)) return {};
      v = google::protobuf::Value(fields.at(key));
    }
    return v;
  }
  double number(const std::string& path) const { return value(path).number_value(); }
  std::string text(const std::string& path) const { return value(path).string_value(); }

  std::unique_ptr<Process> rigid, shell;

 private:
  TemporaryFolder folder_;
};

}  // namespace sunder::test
