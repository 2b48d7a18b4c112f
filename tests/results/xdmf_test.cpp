#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "grouser/terrain/recorder.h"
#include "results/temporary_folder.h"

namespace grouser {
namespace {

using test::read_bytes;
using test::TemporaryFolder;
using testing::HasSubstr;
using testing::Not;

void write_run(const std::filesystem::path& file, int frames) {
  Recorder r = Recorder::create(file, {"run", "", "a < b & \"c\"", "rigid", "", 1}, 50);
  const int body = r.add_channel({"chassis.position", "m", "", "W", 3});
  const int q = r.add_channel({"chassis.orientation", "1", "", "W", 4});
  const int wheel = r.add_channel({"front.position", "m", "", "W", 3});
  const int force = r.add_channel({"front.force", "N", "", "W", 3});
  const int sinkage = r.add_channel({"front.sinkage", "m", "", "", 1});
  const std::vector<double> x{0, 1, 2, 3}, y{-1, 0, 1}, h{0, 1, 2, 3, 10, 11, 12, 13, 20, 21, 22, 23};
  r.write_static({"ground.x", "m", "", "W", 1}, x, {4});
  r.write_static({"ground.y", "m", "", "W", 1}, y, {3});
  r.write_static({"ground.height", "m", "", "W", 1}, h, {3, 4});
  for (int i = 0; i < frames; ++i) {
    const double p[3] = {0.5 * i, 1, 2}, f[3] = {1.0 * i, 0, 100};
    const double unit[4] = {1, 0, 0, 0};
    r.set(body, p);
    r.set(q, unit);
    r.set(wheel, p);
    r.set(force, f);
    r.set(sinkage, 0.001 * i);
    r.end_frame(0.005 * i);
  }
}

TEST(Xdmf, EveryReferenceIsInTheRunFile) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-h5py is not installed";
  const TemporaryFolder folder;
  write_run(folder / "run.h5", 20);
  write_xdmf(folder / "run.h5", folder / "run.xdmf");
  const std::string command =
      "/usr/bin/python3 " GROUSER_SOURCE_DIR "/tests/results/check_xdmf.py " + (folder / "run.xdmf").string() + " 20";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST(Xdmf, NamesTheRunFileRelativeToItself) {
  const TemporaryFolder folder;
  write_run(folder / "run.h5", 2);
  write_xdmf(folder / "run.h5", folder / "run.xdmf");
  const std::string text = read_bytes(folder / "run.xdmf");
  EXPECT_THAT(text, HasSubstr(">run.h5:/front.sinkage<"));
  EXPECT_THAT(text, HasSubstr("Value=\"a &lt; b &amp; &quot;c&quot;\""));
  EXPECT_THAT(text, Not(HasSubstr("orientation")));
}

TEST(Xdmf, LongRunIsThinnedAndSaysSo) {
  const TemporaryFolder folder;
  write_run(folder / "run.h5", 2500);
  write_xdmf(folder / "run.h5", folder / "run.xdmf");
  const std::string text = read_bytes(folder / "run.xdmf");
  EXPECT_THAT(text, HasSubstr("<Information Name=\"frame stride\" Value=\"3\"/>"));
  EXPECT_THAT(text, HasSubstr("Grid Name=\"frame 2499\""));
}

TEST(Xdmf, MissingRunIsAnError) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_xdmf(folder / "run.h5", folder / "run.xdmf"), ResultsError);
}

}  // namespace
}  // namespace grouser
