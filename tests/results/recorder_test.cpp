#include "grouser/terrain/recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numeric>
#include <thread>

#include "results/temporary_folder.h"

namespace grouser {
namespace {

using test::message_of;
using test::TemporaryFolder;
using testing::HasSubstr;

RunAttributes example() { return {"run", "scenario: x\n# \xC3\xA4\n", "a title", "rigid", "1.2.3", -7}; }

double value(int channel, std::uint64_t frame, int component) {
  return 1e3 * channel + static_cast<double>(frame) + 0.125 * component;
}

/// Two channels, one of them a vector.
void write_frames(Recorder& r, std::uint64_t first, std::uint64_t last) {
  const int a = r.add_channel({"wheel.sinkage", "m", "sinkage", "", 1});
  const int b = r.add_channel({"wheel.force", "N", "soil on wheel", "W", 3});
  for (std::uint64_t i = first; i < last; ++i) {
    r.set(a, value(0, i, 0));
    const double f[3] = {value(1, i, 0), value(1, i, 1), value(1, i, 2)};
    r.set(b, f);
    r.end_frame(0.01 * static_cast<double>(i));
  }
}

void expect_frames(const std::filesystem::path& file, std::uint64_t n) {
  const RunFile run(file);
  ASSERT_EQ(run.frames(), n);
  std::vector<std::uint64_t> dims;
  const auto a = run.read("wheel.sinkage", &dims);
  ASSERT_EQ(dims, (std::vector<std::uint64_t>{n}));
  const auto b = run.read("wheel.force", &dims);
  ASSERT_EQ(dims, (std::vector<std::uint64_t>{n, 3}));
  const auto t = run.time();
  for (std::uint64_t i = 0; i < n; ++i) {
    ASSERT_EQ(t[i], 0.01 * static_cast<double>(i));
    ASSERT_EQ(a[i], value(0, i, 0));
    for (int k = 0; k < 3; ++k) ASSERT_EQ(b[3 * i + static_cast<std::uint64_t>(k)], value(1, i, k));
  }
}

TEST(Recorder, WhatIsWrittenIsReadBitByBit) {
  const TemporaryFolder folder;
  // 2500 frames cross two chunk borders (1024 rows) and end in the middle of a block.
  Recorder r = Recorder::create(folder / "run.h5", example(), 37);
  write_frames(r, 0, 2500);
  EXPECT_EQ(r.frames(), 2500u);
  r.close();
  expect_frames(folder / "run.h5", 2500);
}

TEST(Recorder, AttributesAndSpecsComeBack) {
  const TemporaryFolder folder;
  // An attribute in an object header may hold 64 kB at most; a scenario may be longer.
  RunAttributes a = example();
  a.scenario += std::string(200'000, 'x');
  Recorder r = Recorder::create(folder / "run.h5", a);
  write_frames(r, 0, 3);
  r.set_attribute("status", "running");
  r.set_attribute("status", "finished");
  r.set_attribute("timing.wall_s", 1.5);
  r.set_attribute("timing.wall_s", 2.5);
  r.close();
  const RunFile run(folder / "run.h5");
  EXPECT_EQ(run.attributes().kind, "run");
  EXPECT_EQ(run.attributes().scenario, a.scenario);
  EXPECT_EQ(run.attributes().title, a.title);
  EXPECT_EQ(run.attributes().terrain, a.terrain);
  EXPECT_EQ(run.attributes().version, a.version);
  EXPECT_EQ(run.attributes().seed, -7);
  EXPECT_EQ(run.attribute("status"), "finished");
  EXPECT_EQ(run.attribute("nothing"), "");
  EXPECT_EQ(run.number("timing.wall_s", 0), 2.5);
  EXPECT_EQ(run.number("nothing", 8), 8);
  const auto channels = run.channels();
  ASSERT_EQ(channels.size(), 2u);
  EXPECT_EQ(channels[0].name, "wheel.force");
  EXPECT_EQ(channels[0].unit, "N");
  EXPECT_EQ(channels[0].frame, "W");
  EXPECT_EQ(channels[0].description, "soil on wheel");
  EXPECT_EQ(channels[0].components, 3);
}

TEST(Recorder, ChannelThatIsLeftOutIsNaN) {
  const TemporaryFolder folder;
  Recorder r = Recorder::create(folder / "run.h5", example(), 2);
  const int a = r.add_channel({"a", "m", "", "", 1});
  for (int i = 0; i < 5; ++i) {
    if (i % 2 == 0) r.set(a, i);
    r.end_frame(i);
  }
  r.close();
  const auto x = RunFile(folder / "run.h5").read("a");
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(std::isnan(x[i]), i % 2 == 1) << i;
}

TEST(Recorder, StaticsKeepTheirExtents) {
  const TemporaryFolder folder;
  std::vector<double> h(12);
  std::iota(h.begin(), h.end(), 0.0);
  Recorder r = Recorder::create(folder / "run.h5", example());
  r.write_static({"ground.height", "m", "height", "W", 1}, h, {3, 4});
  write_frames(r, 0, 1);
  r.write_static({"late", "1", "written after the first frame", "", 1}, std::vector<double>{1}, {1});
  EXPECT_THROW(r.write_static({"wrong", "m", "", "", 1}, h, {5, 4}), std::logic_error);
  r.close();
  const RunFile run(folder / "run.h5");
  std::vector<std::uint64_t> dims;
  EXPECT_EQ(run.read("ground.height", &dims), h);
  EXPECT_EQ(dims, (std::vector<std::uint64_t>{3, 4}));
  EXPECT_EQ(run.statics().size(), 2u);
  EXPECT_EQ(run.channels().size(), 2u);
}

TEST(Recorder, LargeStaticsAreDeflatedAndReadBitByBit) {
  const TemporaryFolder folder;
  // Rounded to float, as grains are: half of each number is zeros.
  std::vector<double> x(3 * 70000);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<float>(std::sin(0.37 * static_cast<double>(i)));
  Recorder r = Recorder::create(folder / "run.h5", example());
  r.write_static({"points.0", "m", "grains", "W", 3}, x, {x.size() / 3, 3});
  r.close();
  const RunFile run(folder / "run.h5");
  std::vector<std::uint64_t> dims;
  EXPECT_EQ(run.read("points.0", &dims), x);
  EXPECT_EQ(dims, (std::vector<std::uint64_t>{70000, 3}));
  EXPECT_LT(std::filesystem::file_size(folder / "run.h5"), 0.6 * 8 * static_cast<double>(x.size()));
}

TEST(Recorder, ResumeCutsLaterFramesAndContinues) {
  const TemporaryFolder folder;
  {
    Recorder r = Recorder::create(folder / "run.h5", example(), 10);
    write_frames(r, 0, 3000);
  }
  Recorder r = Recorder::resume(folder / "run.h5", 1500, 10);
  write_frames(r, 1500, 2200);
  r.close();
  expect_frames(folder / "run.h5", 2200);
}

TEST(Recorder, ResumedRunEqualsOneThatWasNeverStopped) {
  const TemporaryFolder folder;
  for (const std::uint64_t cut : {0u, 1u, 1023u, 1024u, 1025u}) {
    Recorder first = Recorder::create(folder / "run.h5", example(), 7);
    write_frames(first, 0, 1100);
    first.close();
    Recorder second = Recorder::resume(folder / "run.h5", cut, 7);
    write_frames(second, cut, 1300);
    second.close();
    expect_frames(folder / "run.h5", 1300);
  }
}

TEST(Recorder, ResumeRefusesOtherChannelsByName) {
  const TemporaryFolder folder;
  Recorder::create(folder / "run.h5", example());
  {
    Recorder r = Recorder::create(folder / "run.h5", example());
    write_frames(r, 0, 10);
  }
  {
    Recorder r = Recorder::resume(folder / "run.h5", 10);
    EXPECT_THAT(message_of<ResultsError>([&] {
                  r.add_channel({"wheel.slip", "1", "", "", 1});
                }),
                HasSubstr("it has no channel 'wheel.slip'"));
    EXPECT_THAT(message_of<ResultsError>([&] {
                  r.add_channel({"wheel.sinkage", "mm", "", "", 1});
                }),
                HasSubstr("channel 'wheel.sinkage' has unit 'm'"));
  }
  {
    Recorder r = Recorder::resume(folder / "run.h5", 10);
    r.set(r.add_channel({"wheel.sinkage", "m", "", "", 1}), 1);
    EXPECT_THAT(message_of<ResultsError>([&] { r.end_frame(1); }),
                HasSubstr("holds channel 'wheel.force', which this run does not record"));
  }
  EXPECT_THAT(message_of<ResultsError>([&] { Recorder::resume(folder / "run.h5", 11); }),
              HasSubstr("holds 10 frames, 11 are needed"));
  expect_frames(folder / "run.h5", 10);
}

TEST(Recorder, WrongCallsAreNamed) {
  const TemporaryFolder folder;
  Recorder r = Recorder::create(folder / "run.h5", example());
  const int a = r.add_channel({"a", "m", "", "", 2});
  EXPECT_THROW(r.add_channel({"a", "m", "", "", 1}), std::logic_error);
  EXPECT_THROW(r.add_channel({"time", "s", "", "", 1}), std::logic_error);
  EXPECT_THROW(r.add_channel({"a/b", "m", "", "", 1}), std::logic_error);
  EXPECT_THROW(r.set(a, 1.0), std::logic_error);
  EXPECT_EQ(r.channel("a"), a);
  EXPECT_THROW(r.channel("b"), std::out_of_range);
  EXPECT_THROW(r.end_frame(std::nan("")), std::logic_error);
  r.end_frame(0);
  EXPECT_THROW(r.add_channel({"b", "m", "", "", 1}), std::logic_error);
  EXPECT_THAT(message_of<ResultsError>([&] { Recorder::create(folder / "no/such/run.h5", example()); }),
              HasSubstr("its folder does not exist"));
}

TEST(Recorder, OldFileStaysUntilTheNewOneIsWhole) {
  const TemporaryFolder folder;
  {
    Recorder r = Recorder::create(folder / "run.h5", example());
    write_frames(r, 0, 10);
  }
  Recorder r = Recorder::create(folder / "run.h5", example());
  expect_frames(folder / "run.h5", 10);
  write_frames(r, 0, 20);
  r.close();
  expect_frames(folder / "run.h5", 20);
  EXPECT_FALSE(std::filesystem::exists(folder / "run.h5.part"));
}

TEST(Recorder, RunCanBeReadWhileItIsWritten) {
  const TemporaryFolder folder;
  Recorder r = Recorder::create(folder / "run.h5", example(), 10);
  write_frames(r, 0, 95);
  expect_frames(folder / "run.h5", 90);
  r.flush();
  expect_frames(folder / "run.h5", 95);
}

TEST(Recorder, IndexOfChunksMaySplit) {
  // One index node holds 256 chunks of 1024 frames; 300 000 frames force the first split.
  const TemporaryFolder folder;
  Recorder r = Recorder::create(folder / "run.h5", example(), 5000);
  write_frames(r, 0, 300'000);
  r.close();
  expect_frames(folder / "run.h5", 300'000);
}

TEST(Recorder, TwoThreadsMayWriteTwoFiles) {
  const TemporaryFolder folder;
  auto write = [&](const std::string& name) {
    Recorder r = Recorder::create(folder / name, example(), 10);
    write_frames(r, 0, 2000);
  };
  std::thread a(write, "a.h5"), b(write, "b.h5");
  a.join();
  b.join();
  expect_frames(folder / "a.h5", 2000);
  expect_frames(folder / "b.h5", 2000);
}

TEST(Recorder, PythonReadsEverything) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-h5py is not installed";
  const TemporaryFolder folder;
  Recorder r = Recorder::create(folder / "run.h5", example(), 10);
  r.write_static({"ground.x", "m", "grid", "W", 1}, std::vector<double>{0, 1, 2}, {3});
  write_frames(r, 0, 1234);
  r.close();
  const std::string command =
      "/usr/bin/python3 " GROUSER_SOURCE_DIR "/tests/results/read_run.py " + (folder / "run.h5").string() + " 1234";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

}  // namespace
}  // namespace grouser
