// A run that is killed at any moment leaves a file that opens with what it had, and that can be continued.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <random>

#include "grouser/terrain/checkpoint.h"
#include "grouser/terrain/recorder.h"
#include "results/temporary_folder.h"

namespace grouser {
namespace {

using test::TemporaryFolder;

constexpr int channels = 24;

double value(int channel, std::uint64_t frame) { return 1e6 * channel + static_cast<double>(frame); }

/// What the child tells the parent, in shared memory.
struct Progress {
  std::atomic<std::uint64_t> flushed{0};
};
Progress* shared_progress() {
  void* p = ::mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  return new (p) Progress;
}

void add_channels(Recorder& r) {
  for (int c = 0; c < channels; ++c)
    r.add_channel({"channel_" + std::to_string(c), "N", "a value", "W", c % 2 ? 3 : 1});
}
void write_frame(Recorder& r, std::uint64_t i) {
  for (int c = 0; c < channels; ++c) {
    const double v[3] = {value(c, i), value(c, i), value(c, i)};
    r.set(c, std::span<const double>(v, c % 2 ? 3 : 1));
  }
  r.end_frame(static_cast<double>(i));
}
void expect_whole(const std::filesystem::path& file, std::uint64_t at_least) {
  const RunFile run(file);
  ASSERT_GE(run.frames(), at_least);
  const auto t = run.time();
  for (std::uint64_t i = 0; i < run.frames(); ++i) ASSERT_EQ(t[i], static_cast<double>(i));
  for (int c = 0; c < channels; ++c) {
    const auto x = run.read("channel_" + std::to_string(c));
    const std::size_t width = c % 2 ? 3 : 1;
    ASSERT_EQ(x.size(), width * run.frames());
    for (std::size_t i = 0; i < x.size(); ++i)
      ASSERT_EQ(x[i], value(c, i / width)) << "channel " << c << " value " << i;
  }
}

/// Let `child` run until it has flushed `target` frames, then a little longer, then kill it.
template <class F>
void run_and_kill(Progress& progress, std::uint64_t target, int extra, F child) {
  progress.flushed = 0;
  const pid_t pid = ::fork();
  ASSERT_GE(pid, 0);
  if (pid == 0) {
    child();
    ::_exit(0);
  }
  int status = 0;
  while (progress.flushed < target && ::waitpid(pid, &status, WNOHANG) == 0) ::sched_yield();
  for (std::atomic<int> i = 0; i < extra; ++i) continue;
  ::kill(pid, SIGKILL);
  ::waitpid(pid, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << "the child must not end by itself";
}

TEST(KilledRun, OpensWithEverythingUpToTheLastFlush) {
  const TemporaryFolder folder;
  Progress* progress = shared_progress();
  std::mt19937 random(1);
  for (int trial = 0; trial < 40; ++trial) {
    // Flushing every 3 frames spends most of the time inside a flush: far worse than the default of 50.
    const std::uint64_t target = 1 + random() % 2000;
    const int extra = static_cast<int>(random() % 3'000'000);
    run_and_kill(*progress, target, extra, [&] {
      Recorder r = Recorder::create(folder / "run.h5", {"run", "scenario", "", "rigid", "", 1}, 3);
      add_channels(r);
      for (std::uint64_t i = 0;; ++i) {
        write_frame(r, i);
        if ((i + 1) % 3 == 0) progress->flushed = i + 1;
      }
    });
    expect_whole(folder / "run.h5", target);
    if (testing::Test::HasFatalFailure()) FAIL() << "trial " << trial;
  }
}

TEST(KilledRun, ContinuesFromItsCheckpointTimeAfterTime) {
  const TemporaryFolder folder;
  Progress* progress = shared_progress();
  std::mt19937 random(2);
  {
    Recorder r = Recorder::create(folder / "run.h5", {"run", "scenario", "", "rigid", "", 1}, 5);
    add_channels(r);
    write_frame(r, 0);
    r.close();
    Checkpoint c;
    c.frames = 1;
    write_checkpoint(folder / "checkpoint.h5", c);
  }
  std::uint64_t frames = 1;
  for (int trial = 0; trial < 20; ++trial) {
    run_and_kill(*progress, 40 + random() % 400, static_cast<int>(random() % 1'000'000), [&] {
      const std::uint64_t first = read_checkpoint(folder / "checkpoint.h5").frames;
      Recorder r = Recorder::resume(folder / "run.h5", first, 5);
      add_channels(r);
      for (std::uint64_t i = first;; ++i) {
        write_frame(r, i);
        progress->flushed = i + 1 - first;
        if ((i + 1) % 20 != 0) continue;
        r.flush();
        Checkpoint c;
        c.frames = i + 1;
        std::vector<double> x(1000, static_cast<double>(i));
        c.state.field("x", x);
        write_checkpoint(folder / "checkpoint.h5", c);
      }
    });
    // Whenever the kill came, the checkpoint is whole and the run holds at least its frames.
    const Checkpoint c = read_checkpoint(folder / "checkpoint.h5");
    EXPECT_GE(c.frames, frames);
    frames = c.frames;
    expect_whole(folder / "run.h5", frames);
    if (testing::Test::HasFatalFailure()) FAIL() << "trial " << trial;
  }
  EXPECT_GT(frames, 400u);
}

TEST(KilledRun, SecondWriterIsRefusedWhileTheFirstLives) {
  const TemporaryFolder folder;
  Progress* progress = shared_progress();
  {
    Recorder r = Recorder::create(folder / "run.h5", {"run", "", "", "rigid", "", 1}, 5);
    add_channels(r);
    for (std::uint64_t i = 0; i < 10; ++i) write_frame(r, i);
  }
  std::string message;
  const pid_t pid = ::fork();
  if (pid == 0) {
    Recorder r = Recorder::resume(folder / "run.h5", 10);
    progress->flushed = 1;
    for (;;) ::pause();
  }
  while (progress->flushed == 0) ::sched_yield();
  try {
    Recorder::resume(folder / "run.h5", 10);
  } catch (const ResultsError& e) {
    message = e.what();
  }
  ::kill(pid, SIGKILL);
  ::waitpid(pid, nullptr, 0);
  EXPECT_EQ(message, (folder / "run.h5").string() + ": is being written by another process; wait for it or stop it");
  EXPECT_NO_THROW(Recorder::resume(folder / "run.h5", 10)) << "a killed writer leaves no lock behind";
}

}  // namespace
}  // namespace grouser
