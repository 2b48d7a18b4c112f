#include "grouser/terrain/checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <limits>

#include "grouser/terrain/recorder.h"
#include "grouser/terrain/state_stream.h"
#include "results/temporary_folder.h"

namespace grouser {
namespace {

using test::message_of;
using test::read_bytes;
using test::TemporaryFolder;
using test::write_bytes;
using testing::HasSubstr;

Checkpoint example() {
  Checkpoint c;
  c.scenario = "scenario: x\n" + std::string(100'000, '#');
  c.version = "1.2.3";
  c.time = 0.1 + 0.2;
  c.frames = 61;
  // Bits that text would lose: signed zero, denormal, NaN with a payload, infinity.
  std::vector<double> reals{-0.0, 5e-324, std::nan("123"), std::numeric_limits<double>::infinity(), 1.0 / 3};
  std::vector<double> big(5000, 0.7), none;
  std::vector<std::int64_t> integers{std::numeric_limits<std::int64_t>::min(), 0, 1};
  std::vector<std::uint8_t> bytes{0, 255, 7};
  std::string text = "a/b";
  double twice = 1;
  c.state.field("reals", reals);
  {
    auto g = c.state.group("wheel");
    c.state.field("big", big);
    c.state.field("none", none);
    c.state.field("integers", integers);
  }
  c.state.field("wheel", bytes);
  c.state.field("text", text);
  c.state.field("twice", twice);
  twice = 2;
  c.state.field("twice", twice);
  c.state.field("wheel.big", twice);
  return c;
}

TEST(Checkpoint, ComesBackBitByBit) {
  const TemporaryFolder folder;
  const Checkpoint a = example();
  write_checkpoint(folder / "c.h5", a);
  const Checkpoint b = read_checkpoint(folder / "c.h5");
  EXPECT_EQ(b.scenario, a.scenario);
  EXPECT_EQ(b.version, a.version);
  EXPECT_EQ(b.time, a.time);
  EXPECT_EQ(b.frames, a.frames);
  const auto d = State::first_difference(a.state, b.state);
  EXPECT_FALSE(d) << d->field << ' ' << d->left << ' ' << d->right;
  EXPECT_EQ(a.state.hash(), b.state.hash());
  EXPECT_TRUE(b.state.loading()) << "ready to be traversed";
  EXPECT_FALSE(std::filesystem::exists(folder / "c.h5.part"));
}

TEST(Checkpoint, IsAPlainHdf5FileToOthers) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-h5py is not installed";
  const TemporaryFolder folder;
  write_checkpoint(folder / "c.h5", example());
  const std::string command =
      "/usr/bin/python3 -c \"import h5py; f=h5py.File('" + (folder / "c.h5").string() +
      "'); assert f['state/wheel.integers'][2]==1 and f.attrs['frames']==61 and len(f['state'])==9\"";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST(Checkpoint, AnyFlippedByteIsFound) {
  const TemporaryFolder folder;
  write_checkpoint(folder / "c.h5", example());
  const std::string whole = read_bytes(folder / "c.h5");
  for (std::size_t at = 0; at < whole.size(); at += 997) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    write_bytes(folder / "c.h5", bytes);
    EXPECT_THROW(read_checkpoint(folder / "c.h5"), ResultsError) << "byte " << at;
  }
  std::string bytes = whole;
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_bytes(folder / "c.h5", bytes);
  EXPECT_EQ(message_of<ResultsError>([&] { read_checkpoint(folder / "c.h5"); }),
            (folder / "c.h5").string() +
                ": is damaged: its content does not match its stored hash; copy it again or start the run anew");
}

TEST(Checkpoint, TruncatedFileIsNamed) {
  const TemporaryFolder folder;
  write_checkpoint(folder / "c.h5", example());
  const std::string whole = read_bytes(folder / "c.h5");
  for (std::size_t n = 8; n < whole.size(); n += whole.size() / 29) {
    write_bytes(folder / "c.h5", whole.substr(0, n));
    EXPECT_EQ(message_of<ResultsError>([&] { read_checkpoint(folder / "c.h5"); }),
              (folder / "c.h5").string() +
                  ": is truncated, or not a checkpoint of grouser; copy it again or start the run anew");
  }
}

/// The fields of example(), named by an object that is traversed: with a group, a text and arrays.
struct Traversed {
  std::vector<double> big = std::vector<double>(5000, 0.7), none;
  std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(3'000'000, 9);
  std::string text = "a/b";
  bool flag = true;
  void traverse(State& s) {
    s.field("big", big);
    const auto g = s.group("inner");
    s.field("none", none);
    s.field("bytes", bytes);
    s.field("text", text);
    s.field("flag", flag);
  }
};

TEST(Checkpoint, AStateThatIsNeverHeldWholeIsTheSame) {
  const TemporaryFolder folder;
  Traversed object;
  Checkpoint head;
  head.scenario = "s";
  head.version = "v";
  Checkpoint whole = head;
  object.traverse(whole.state);
  write_checkpoint(folder / "whole.h5", whole);
  write_checkpoint(folder / "parts.h5", head, [&](State& s) { object.traverse(s); });
  Checkpoint a = read_checkpoint(folder / "whole.h5"), b = read_checkpoint(folder / "parts.h5");
  const auto d = State::first_difference(a.state, b.state);
  EXPECT_FALSE(d) << d->field << ' ' << d->left << ' ' << d->right;
  EXPECT_EQ(b.state.hash(), whole.state.hash());
  Traversed loaded;
  loaded.bytes.clear();
  loaded.traverse(b.state);
  b.state.finish();
  EXPECT_EQ(loaded.bytes, object.bytes);
}

TEST(StateStream, KeepsNoFieldAndHashesAsAState) {
  Traversed object;
  State whole;
  object.traverse(whole);
  std::size_t most = 0, fields = 0;
  StateStream stream([&](const State::Field&) { ++fields; });
  State other;  // beside it: is not touched
  other.field("flag", object.flag);
  {
    StateStream inner;
    object.traverse(inner.state());
    inner.finish();
    EXPECT_EQ(inner.hash(), whole.hash());
    most = inner.state().fields().size();
  }
  object.traverse(stream.state());
  EXPECT_EQ(stream.state().fields().size(), 1u) << "the last one, until finish()";
  stream.finish();
  EXPECT_EQ(most, 0u);
  EXPECT_EQ(fields, whole.fields().size());
  EXPECT_EQ(stream.hash_text(), whole.hash_text());
  EXPECT_EQ(other.fields().size(), 1u);
}

TEST(StateStream, CopiesOfItsStateKeepTheirFields) {
  Traversed object;
  std::size_t fields = 0;
  StateStream stream([&](const State::Field&) { ++fields; });
  State copied = stream.state(), assigned;
  assigned = stream.state();
  const State moved = std::move(copied);
  State of_moved = moved;
  object.traverse(assigned);
  object.traverse(of_moved);
  State whole;
  object.traverse(whole);
  EXPECT_EQ(assigned.hash(), whole.hash());
  EXPECT_EQ(of_moved.hash(), whole.hash());
  EXPECT_EQ(fields, 0u);
  stream.state() = whole;  // fields of another state are taken as if they were its own
  stream.finish();
  EXPECT_EQ(stream.hash(), whole.hash());
  EXPECT_EQ(fields, whole.fields().size());
}

TEST(Checkpoint, AFullDiskIsSaidAndTheOldOneStays) {
  const TemporaryFolder folder;
  Checkpoint head;
  head.version = "old";
  write_checkpoint(folder / "c.h5", head);
  // A limit of the size of files stands for the full disk; the signal would end the program.
  struct sigaction ignore {
  }, before{};
  ignore.sa_handler = SIG_IGN;
  ASSERT_EQ(sigaction(SIGXFSZ, &ignore, &before), 0);
  rlimit old{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  for (const rlim_t limit : {rlim_t{0}, rlim_t{3000}, rlim_t{100'000}, rlim_t{2'000'000}}) {
    const rlimit small{limit, old.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    Traversed object;
    const std::string said = message_of<ResultsError>(
        [&] { write_checkpoint(folder / "c.h5", head, [&](State& s) { object.traverse(s); }); });
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
    EXPECT_THAT(said, testing::StartsWith((folder / "c.h5").string() + ": cannot ")) << limit;
    EXPECT_EQ(read_checkpoint(folder / "c.h5").version, "old") << limit;
  }
  ASSERT_EQ(sigaction(SIGXFSZ, &before, nullptr), 0);
  head.version = "new";
  write_checkpoint(folder / "c.h5", head);
  EXPECT_EQ(read_checkpoint(folder / "c.h5").version, "new");
}

TEST(Checkpoint, OtherFilesAreNamed) {
  const TemporaryFolder folder;
  EXPECT_THAT(message_of<ResultsError>([&] { read_checkpoint(folder / "c.h5"); }), HasSubstr("no such file"));
  write_bytes(folder / "c.h5", "text");
  EXPECT_THAT(message_of<ResultsError>([&] { read_checkpoint(folder / "c.h5"); }), HasSubstr("not an HDF5 file"));
  { Recorder::create(folder / "run.h5", {}).close(); }
  EXPECT_THAT(message_of<ResultsError>([&] { read_checkpoint(folder / "run.h5"); }), HasSubstr("not a checkpoint"));
  EXPECT_THAT(message_of<ResultsError>([&] { write_checkpoint(folder / "no/such/c.h5", {}); }),
              HasSubstr("cannot be written"));
}

}  // namespace
}  // namespace grouser
