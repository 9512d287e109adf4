// The same scene with the engine in the shell's process and in another one. Both compute the same to the bit, so all
// that differs is the boundary: start of a session, and its messages. Whole times are compared too. On a shared
// machine they scatter by more than the boundary costs. So the reported number leaves the solver's own stages out of
// the difference.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "coupler/core/error.h"
#include "tests/benchmarks/two_processes.h"
#include "tests/conformance/process.h"
#include "tests/temporary_folder.h"

namespace sunder::bench {
namespace {

constexpr const char* kUntil = "2e-4";  // four windows of the impact, the first shards handed off within them
constexpr int kPairs = 5;
constexpr double kFinish = 5.0;  // [s] that an engine may take to end after Bye

std::string read(const std::string& path) {
  std::stringstream s;
  s << std::ifstream(path).rdbuf();
  return s.str();
}

void run_to_end(std::vector<std::string> command, const std::string& log) {
  std::vector<char*> argv;
  for (std::string& a : command) argv.push_back(a.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  ensure(child >= 0, "no process can be started");
  if (child == 0) {
    const int in = open("/dev/null", O_RDONLY), out = open(log.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
    dup2(in, 0), dup2(out, 1), dup2(out, 2);
    execv(argv[0], argv.data());
    _exit(127);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  require(WIFEXITED(status) && WEXITSTATUS(status) == 0, "{} ends with status {}: {}", command[0],
          WIFEXITED(status) ? WEXITSTATUS(status) : 256 + WTERMSIG(status), read(log));
}

// Of a side: least, median and most seconds.
std::string spread(const std::vector<RunCost>& runs, double RunCost::*what) {
  std::vector<double> s;
  for (const RunCost& r : runs) s.push_back(r.*what);
  return fmt::format("{:.4f} {:.4f} {:.4f}", percentile(s, 1e-9), percentile(s, 0.5), percentile(s, 1.0));
}

// Of all processes that have been waited for.
double children_cpu_s() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

double least(const std::vector<RunCost>& runs, double RunCost::*what) {
  double found = runs.front().*what;
  for (const RunCost& r : runs) found = std::min(found, r.*what);
  return found;
}

}  // namespace

RunCost run_glass(bool two_processes, const std::string& until) {
  const TemporaryFolder folder;
  const std::string out = folder.path + "/out";
  std::filesystem::create_directory(out);
  std::unique_ptr<conformance::EngineProcess> engine;
  std::vector<std::string> command{two_processes ? SUNDER_SHELL : SUNDER_SINGLE};
  if (two_processes) {
    engine =
        std::make_unique<conformance::EngineProcess>(conformance::Target{{SUNDER_RIGID, "--engine", "bullet"}, ""});
    command.insert(command.end(), {"--endpoint", engine->endpoint()});
  } else {
    command.insert(command.end(), {"--engine", "bullet"});
  }
  command.insert(command.end(), {"--scene", SUNDER_SCENES "/glass.textproto", "--out", out, "--until", until,
                                 "--threads", "1", "--quiet", "--die-with-parent"});
  const double before = children_cpu_s();
  run_to_end(command, folder.path + "/log");
  if (engine) {
    const auto status = engine->wait(kFinish);
    require(status == 0, "the engine process ends with status {}: {}", status.value_or(-1), engine->last_words());
  }
  google::protobuf::Struct run;
  require(google::protobuf::util::JsonStringToMessage(read(out + "/run.json"), &run).ok(), "{}/run.json is no JSON",
          out);
  RunCost cost;
  cost.cpu_s = children_cpu_s() - before;  // the engine has been waited for
  const auto& time = run.fields().at("time").struct_value().fields();
  cost.wall_s = cost.outside_s = time.at("wall_s").number_value();
  for (const auto& [stage, seconds] : time.at("stage_s").struct_value().fields())
    if (stage == "coupling")
      cost.coupling_s = seconds.number_value();
    else
      cost.outside_s -= seconds.number_value();
  cost.state_hash = run.fields().at("state_hash").string_value();
  return cost;
}

void measure_process_boundary(std::map<std::string, double>& out) {
  std::vector<RunCost> one, two;
  for (int pair = 0; pair < kPairs; ++pair)
    for (const bool second : {false, true}) {  // who is first takes turns: a slow moment meets both
      const bool two_processes = second != (pair % 2 == 1);
      (two_processes ? two : one).push_back(run_glass(two_processes, kUntil));
      const RunCost& last = two_processes ? two.back() : one.back();
      ensure(last.state_hash == one.front().state_hash, "a run with {} ends in another state than the first one",
             two_processes ? "two processes" : "one process");
    }
  const double base = least(one, &RunCost::wall_s);
  const double overhead = 100.0 * (least(two, &RunCost::outside_s) - least(one, &RunCost::outside_s)) / base;
  fmt::print(
      "process_boundary_overhead: glass.textproto to {} s, Bullet, one thread, {} runs each, taking turns; least,\n"
      "  median and most seconds, and how much the least of two processes is above that of one\n",
      kUntil, kPairs);
  const auto line = [&](const char* name, double RunCost::*what) {
    fmt::print("  {:<34} {:<26} {:<26} {:+.2f} %\n", name, spread(one, what), spread(two, what),
               100.0 * (least(two, what) - least(one, what)) / base);
  };
  fmt::print("  {:<34} {:<26} {:<26} of wall_s\n", "", "one process", "two");
  line("wall_s", &RunCost::wall_s);
  line("of it outside the solver's stages", &RunCost::outside_s);
  line("of that stage_s.coupling", &RunCost::coupling_s);
  line("processor time of all processes", &RunCost::cpu_s);
  out["process_boundary_overhead_percent"] = overhead;
}

}  // namespace sunder::bench
