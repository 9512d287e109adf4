#pragma once
// Time of a process's own, which other work on the machine cannot use up: coupler/sunder_tools/launch/own_time.py in
// C++.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <time.h>
#include <unistd.h>

namespace sunder {

/// Seconds of its own that a process has had since the first look. Processor time counts, and so does the time in which
/// all threads sleep. The time in which a thread waits for a processor or a disk, or is stopped, does not count.
class OwnTime {
 public:
  explicit OwnTime(pid_t process) : process_(process), looked_(now()) { read(used_); }

  /// The seconds so far. Call it every few hundredths of a second.
  double look() {
    const double time = now(), since = std::min(time - looked_, kMostOfALook);
    double used = 0.0;
    const bool asleep = read(used);
    const double run = std::max(used - used_, 0.0);
    looked_ = time, used_ = used;
    return seconds_ += asleep && run == 0.0 ? since : std::min(run, since);
  }

 private:
  static constexpr double kMostOfALook = 0.1;  // [s]; this process itself may have been starved

  static double now() {
    timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  /// Reads the processor time [s]. Returns true where all threads sleep.
  bool read(double& used) const {
    bool asleep = true;
    std::error_code gone;
    for (const auto& thread :
         std::filesystem::directory_iterator("/proc/" + std::to_string(process_) + "/task", gone)) {
      std::stringstream text;
      text << std::ifstream(thread.path() / "stat").rdbuf();
      const std::string line = text.str();
      std::istringstream fields(line.substr(std::min(line.size(), line.rfind(')') + 1)));
      std::string state, skipped;
      double user = 0.0, system = 0.0;
      fields >> state;
      for (int k = 0; k < 10; ++k) fields >> skipped;
      if (!(fields >> user >> system)) continue;  // the thread has ended meanwhile
      asleep = asleep && state != "R" && state != "D" && state != "T" && state != "t";
      used += (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
    }
    return asleep;
  }

  pid_t process_;
  double looked_, used_ = 0.0, seconds_ = 0.0;
};

}  // namespace sunder
