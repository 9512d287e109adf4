// Work that is tried in a process of its own.
#include "shell/io/cad_trial.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <new>
#include <stdexcept>
#include <system_error>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "coupler/core/error.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSeconds = 20.0, kBytes = 1e9;

TrialEnd end_of(const std::function<void()>& work) { return tried(work, kSeconds, kBytes); }
std::string said(const TrialEnd& end) { return trial_fault(end, "the reader", kSeconds, kBytes); }

TEST(CadTrial, WorkThatEndsIsDoneAndChangesNothingHere) {
  int here = 1;
  testing::internal::CaptureStdout();
  const TrialEnd end = end_of([&] { here = 2, std::puts("not for the user"), std::fflush(stdout); });
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(end.kind, TrialEnd::kDone);
  EXPECT_EQ(here, 1);
  EXPECT_EQ(said(end), "");
}

TEST(CadTrial, AnErrorIsLeftToTheCaller) {
  EXPECT_EQ(end_of([] { require(false, "refused"); }).kind, TrialEnd::kDone);
  EXPECT_EQ(end_of([] { throw std::logic_error("internal"); }).kind, TrialEnd::kDone);
}

TEST(CadTrial, ASignalIsToldByItsName) {
  for (const auto& [signal, name] : {std::pair(SIGSEGV, "SIGSEGV"), {SIGABRT, "SIGABRT"}, {SIGFPE, "SIGFPE"}}) {
    const TrialEnd end = end_of([signal] { raise(signal); });
    EXPECT_EQ(end.kind, TrialEnd::kSignal);
    EXPECT_EQ(end.number, signal);
    EXPECT_EQ(said(end), fmt::format("stops the reader with {}; export it again, or simpler", name));
  }
}

TEST(CadTrial, AHandlerOfThisProcessDoesNotRunInTheChild) {
  struct sigaction before {};
  struct sigaction ours {};
  ours.sa_handler = [](int) { _exit(0); };
  sigaction(SIGSEGV, &ours, &before);
  const TrialEnd end = end_of([] { raise(SIGSEGV); });
  sigaction(SIGSEGV, &before, nullptr);
  EXPECT_EQ(end.number, SIGSEGV);
}

TEST(CadTrial, AnEndlessLoopEndsByItsProcessorTime) {
  const auto forever = [] {
    volatile bool on = true;
    while (on) {
    }
  };
  const TrialEnd end = tried(forever, 1.0, kBytes);
  EXPECT_EQ(end.kind, TrialEnd::kTime);
  EXPECT_EQ(trial_fault(end, "the reader", 1.0, kBytes),
            "takes the reader more than 1 s of processor time; export it again, simpler or in parts");
}

TEST(CadTrial, MemoryBeyondTheBoundIsToldAsMemory) {
  const auto take = [](double share) {
    return [share] {  // a compiler may leave out memory that nobody looks at
      volatile char* bytes = new char[static_cast<std::size_t>(share * kBytes)];
      bytes[0] = 1;
      delete[] bytes;
    };
  };
  EXPECT_EQ(end_of(take(0.5)).kind, TrialEnd::kDone);
  const TrialEnd end = end_of(take(1.5));
  EXPECT_EQ(end.kind, TrialEnd::kMemory);
  EXPECT_EQ(said(end), "takes the reader more than 1 GB of memory; export it again, simpler or in parts");
}

TEST(CadTrial, AKillIsNoLackOfTime) {
  const TrialEnd end = end_of([] { raise(SIGKILL); });
  EXPECT_EQ(end.kind, TrialEnd::kSignal);
  EXPECT_EQ(said(end), "was not read, as the process of the reader was killed by SIGKILL; is memory short?");
}

TEST(CadTrial, ALibraryThatLeavesIsToldWithItsStatus) {
  const TrialEnd end = end_of([] { _exit(7); });
  EXPECT_EQ(end.kind, TrialEnd::kStatus);
  EXPECT_EQ(said(end), "ends the reader with status 7; export it again, or simpler");
}

TEST(CadTrial, NoChildIsLeft) {
  end_of([] {}), end_of([] { raise(SIGABRT); });
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(CadTrial, WhereNoProcessCanBeStartedThatIsSaid) {
  const TrialEnd end = end_of([] {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_NPROC, &none);
    if (getuid() == 0 && setuid(65534) != 0) _exit(8);  // root has no such limit
    try {
      tried([] {}, kSeconds, kBytes);
    } catch (const std::system_error& e) {
      _exit(e.code().value() == EAGAIN ? 9 : 10);
    }
    _exit(11);
  });
  EXPECT_EQ(end.number, 9);
}

}  // namespace
