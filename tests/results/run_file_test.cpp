// Errors of results files: whole messages, one line, with the remedy.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include "grouser/terrain/checkpoint.h"
#include "grouser/terrain/recorder.h"
#include "results/temporary_folder.h"

namespace grouser {
namespace {

using test::message_of;
using test::read_bytes;
using test::TemporaryFolder;
using test::write_bytes;
using testing::HasSubstr;

void write_run(const std::filesystem::path& file, int frames = 100) {
  Recorder r = Recorder::create(file, {"run", "", "", "rigid", "", 1}, 10);
  const int a = r.add_channel({"wheel.drawbar_pull", "N", "", "C", 1});
  for (int i = 0; i < frames; ++i) {
    r.set(a, i);
    r.end_frame(i);
  }
}

std::string error_of(const std::filesystem::path& file) {
  return message_of<ResultsError>([&] { const RunFile run(file); });
}

TEST(RunFile, MissingFileIsNamed) {
  const TemporaryFolder folder;
  EXPECT_EQ(error_of(folder / "run.h5"), (folder / "run.h5").string() + ": no such file; check the path");
}

TEST(RunFile, FolderInPlaceOfFileIsNamed) {
  const TemporaryFolder folder;
  EXPECT_EQ(error_of(folder / ""), (folder / "").string() + ": is a folder; name the .h5 file in it");
}

TEST(RunFile, EmptyFileIsNamed) {
  const TemporaryFolder folder;
  write_bytes(folder / "run.h5", "");
  EXPECT_EQ(error_of(folder / "run.h5"),
            (folder / "run.h5").string() + ": is empty; it was never written or not copied whole");
}

TEST(RunFile, OtherKindsOfFileAreNamed) {
  const TemporaryFolder folder;
  write_bytes(folder / "run.h5", "time,slip\n0,1\n");
  EXPECT_EQ(error_of(folder / "run.h5"),
            (folder / "run.h5").string() + ": is not an HDF5 file; name a file that grouser wrote");
}

TEST(RunFile, TruncatedFileIsNamedAtAnyLength) {
  const TemporaryFolder folder;
  write_run(folder / "whole.h5");
  const std::string whole = read_bytes(folder / "whole.h5");
  // From the superblock (96 bytes) on, the file says how long it should be.
  for (std::size_t n = 96; n < whole.size(); n += whole.size() / 37) {
    write_bytes(folder / "run.h5", whole.substr(0, n));
    EXPECT_EQ(error_of(folder / "run.h5"), (folder / "run.h5").string() + ": is truncated: it holds " +
                                               std::to_string(n) + " of " + std::to_string(whole.size()) +
                                               " bytes; copy it again or run again");
  }
}

TEST(RunFile, DamagedHeaderIsRefused) {
  const TemporaryFolder folder;
  write_run(folder / "run.h5");
  std::string bytes = read_bytes(folder / "run.h5");
  // The root's object header follows the superblock at byte 96 or 100.
  bytes.replace(96, 200, 200, '\0');
  write_bytes(folder / "run.h5", bytes);
  EXPECT_THAT(error_of(folder / "run.h5"), HasSubstr("run.h5: is damaged and cannot be opened"));
}

TEST(RunFile, FileOfAnotherProgramIsRefused) {
  const TemporaryFolder folder;
  const hid_t f = H5Fcreate((folder / "run.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Fclose(f);
  EXPECT_EQ(error_of(folder / "run.h5"),
            (folder / "run.h5").string() + ": was not written by grouser; name the run.h5 of a run");
}

TEST(RunFile, CheckpointIsNotARun) {
  const TemporaryFolder folder;
  write_checkpoint(folder / "checkpoint.h5", {});
  EXPECT_EQ(error_of(folder / "checkpoint.h5"),
            (folder / "checkpoint.h5").string() + ": is a checkpoint, not a run; name the run.h5 beside it");
}

TEST(RunFile, MissingDatasetIsNamedWithTheNearest) {
  const TemporaryFolder folder;
  write_run(folder / "run.h5");
  const RunFile run(folder / "run.h5");
  EXPECT_TRUE(run.has("wheel.drawbar_pull"));
  EXPECT_FALSE(run.has("wheel.drawbar_pul"));
  EXPECT_EQ(message_of<ResultsError>([&] { run.read("wheel.drawbar_pul"); }),
            (folder / "run.h5").string() + ": has no dataset 'wheel.drawbar_pul'; did you mean 'wheel.drawbar_pull'?");
}

TEST(RunFile, HostKeepsItsOwnErrorPrinting) {
  // The library silences HDF5 only while it is inside; the host program's own handler stays.
  static int calls = 0;
  H5E_auto2_t old = nullptr;
  void* data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &old, &data);
  H5Eset_auto2(
      H5E_DEFAULT, [](hid_t, void*) -> herr_t { return ++calls, 0; }, nullptr);
  const TemporaryFolder folder;
  write_bytes(folder / "run.h5", "no");
  EXPECT_NE(error_of(folder / "run.h5"), "");
  EXPECT_EQ(calls, 0);
  H5Fopen((folder / "run.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  EXPECT_EQ(calls, 1);
  H5Eset_auto2(H5E_DEFAULT, old, data);
}

}  // namespace
}  // namespace grouser
