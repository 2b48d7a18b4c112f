#include "grouser/terrain/checkpoint.h"

#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>

#include "grouser/terrain/file_target.h"
#include "grouser/terrain/recorder.h"
#include "grouser/terrain/state_stream.h"
#include "recorder_hdf5.h"

namespace grouser {

using namespace hdf5;

// HDF5 1.10 ends the program when it closes a file on a full disk: room for all is made first, which fails with a message.
// The HDF5 file is followed by 16 bytes: a mark and the hash of what comes before. HDF5 ignores what follows its end, and
// a damaged file is found out before HDF5 looks at it.
namespace {

constexpr std::array<char, 8> mark{'g', 'r', 'o', 'u', 's', 'e', 'r', '1'};

constexpr std::uint64_t fnv_begin = 1469598103934665603ull;
std::uint64_t fnv(const char* p, std::size_t n, std::uint64_t h = fnv_begin) {
  for (std::size_t i = 0; i < n; ++i) h = (h ^ static_cast<unsigned char>(p[i])) * 1099511628211ull;
  return h;
}

Properties memory_access() {
  Properties p(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_fapl_core(p.get(), std::size_t{1} << 20, false);
  return p;
}

/// Flat and unique dataset name of a field.
std::string flat_name(const std::string& field, std::set<std::string>& taken) {
  std::string base = field;
  std::replace(base.begin(), base.end(), '/', '.');
  if (base.empty() || base == ".") base = "field";
  std::string name = base;
  for (int i = 2; !taken.insert(name).second; ++i) name = base + " (" + std::to_string(i) + ")";
  return name;
}

struct StoredKind {
  hid_t stored, native;
  const char* name;
};
StoredKind stored_kind(State::Kind k) {
  if (k == State::Kind::real) return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, "real"};
  if (k == State::Kind::integer) return {H5T_STD_I64LE, H5T_NATIVE_INT64, "integer"};
  return {H5T_STD_U8LE, H5T_NATIVE_UINT8, "byte"};
}
const void* content(const State::Field& f) {
  if (f.kind == State::Kind::real) return f.real.data();
  if (f.kind == State::Kind::integer) return f.integer.data();
  return f.byte.data();
}

/// Fields of a state as datasets of an HDF5 file.
class FieldWriter {
 public:
  FieldWriter(hid_t root, const std::filesystem::path& file)
      : file_(file),
        group_(must(H5Gcreate2(root, "state", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), file, "make a checkpoint")),
        small_(H5Pcreate(H5P_DATASET_CREATE)) {
    H5Pset_layout(small_.get(), H5D_COMPACT);
  }
  void write(const State::Field& x) {
    const StoredKind k = stored_kind(x.kind);
    const std::string name = flat_name(x.name, taken_), doing = "store field '" + x.name + "'";
    const hsize_t n = x.size();
    const Dataspace space(H5Screate_simple(1, &n, nullptr));
    const hid_t creation = n > 0 && n * H5Tget_size(k.stored) <= 4096 ? small_.get() : H5P_DEFAULT;
    const Dataset d(
        must(H5Dcreate2(group_.get(), name.c_str(), k.stored, space.get(), H5P_DEFAULT, creation, H5P_DEFAULT), file_,
             doing));
    if (n > 0) must(H5Dwrite(d.get(), k.native, H5S_ALL, H5S_ALL, H5P_DEFAULT, content(x)), file_, doing);
    write_integer(d.get(), "order", order_++, file_);
    write_text(d.get(), "field", x.name, file_);
  }

 private:
  std::filesystem::path file_;
  Group group_;
  Properties small_;
  std::set<std::string> taken_;
  std::int64_t order_ = 0;
};

struct Written {
  std::string hash;
  std::uint64_t fields;
};
/// Hands every field to the writer.
using Source = std::function<Written(FieldWriter&)>;

/// Bytes that a field takes in the file, at most: its values, its name twice, headers.
std::uint64_t room_of(const State::Field& f) {
  return f.size() * H5Tget_size(stored_kind(f.kind).stored) + 2 * f.name.size() + 4096;
}

void write_image(const std::filesystem::path& place, const Checkpoint& head, const Source& source,
                 const std::filesystem::path& file) {
  const Properties access = file_access();
  const File f(must(H5Fcreate(place.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), file, "make a checkpoint"));
  const hid_t root = f.get();
  write_text(root, format_attribute, checkpoint_format, file);
  write_text(root, "scenario", head.scenario, file);
  write_text(root, "version", head.version, file);
  write_number(root, "time", head.time, file);
  write_integer(root, "frames", static_cast<std::int64_t>(head.frames), file);
  FieldWriter fields(root, file);
  const Written all = source(fields);
  write_text(root, "state_hash", all.hash, file);
  write_integer(root, "fields", static_cast<std::int64_t>(all.fields), file);
  must(H5Fflush(root, H5F_SCOPE_LOCAL), file, "make a checkpoint");
}

[[noreturn]] void fail_to_write(const std::filesystem::path& file) {
  fail(file, std::string("cannot be written: ") + std::strerror(errno));
}

/// From the beginning; leaves the file at its end.
std::uint64_t hash_of_file(int fd, const std::filesystem::path& file) {
  std::vector<char> piece(std::size_t{1} << 20);
  std::uint64_t h = fnv_begin;
  for (;;) {
    const ssize_t n = ::read(fd, piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_to_write(file);
    if (n == 0) return h;
    h = fnv(piece.data(), static_cast<std::size_t>(n), h);
  }
}

void write_all(int fd, const char* p, std::size_t n, const std::filesystem::path& file) {
  while (n > 0) {
    const ssize_t k = ::write(fd, p, n);
    if (k < 0 && errno == EINTR) continue;
    if (k <= 0) fail_to_write(file);
    p += k;
    n -= static_cast<std::size_t>(k);
  }
}

struct Descriptor {
  int fd = -1;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

void write(const std::filesystem::path& file, const Checkpoint& head, std::uint64_t room, const Source& source) {
  const Scope scope;
  const FileTarget target = file_target(file);
  if (target.stream) fail(file, "is a device or a pipe; HDF5 needs a file of its own");
  const std::filesystem::path temporary = target.path.string() + ".part";
  {
    const Descriptor d{::open(temporary.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
    if (d.fd < 0) fail_to_write(file);
    errno = ::posix_fallocate(d.fd, 0, static_cast<off_t>(room + (1U << 16)));
    if (errno != 0) {
      const int why = errno;
      std::filesystem::remove(temporary);
      errno = why;
      fail_to_write(file);
    }
    write_image(temporary, head, source, file);
    H5garbage_collect();  // what HDF5 keeps for the next file: up to 20 MB
    std::vector<char> bytes(mark.begin(), mark.end());
    const std::uint64_t hash = hash_of_file(d.fd, file);
    for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<char>((hash >> (8 * i)) & 0xff));
    write_all(d.fd, bytes.data(), bytes.size(), file);
    if (::fsync(d.fd) != 0) fail_to_write(file);
  }
  if (std::rename(temporary.c_str(), target.path.c_str()) != 0) fail_to_write(file);
  // The new name itself must survive a power cut too.
  const Descriptor folder{::open(target.path.has_parent_path() ? target.path.parent_path().c_str() : ".",
                                 O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (folder.fd >= 0) ::fsync(folder.fd);
}

}  // namespace

void write_checkpoint(const std::filesystem::path& file, const Checkpoint& c) {
  std::uint64_t room = 0;
  for (const State::Field& f : c.state.fields()) room += room_of(f);
  write(file, c, room, [&c](FieldWriter& out) {
    for (const State::Field& f : c.state.fields()) out.write(f);
    return Written{c.state.hash_text(), c.state.fields().size()};
  });
}

void write_checkpoint(const std::filesystem::path& file, const Checkpoint& head,
                      const std::function<void(State&)>& traverse) {
  std::uint64_t room = 0;
  StateStream counted([&room](const State::Field& f) { room += room_of(f); });
  traverse(counted.state());
  counted.finish();
#ifdef __GLIBC__
  malloc_trim(0);  // its copies of fields; the next pass would not take their places
#endif
  write(file, head, room, [&traverse](FieldWriter& out) {
    StateStream state([&out](const State::Field& f) { out.write(f); });
    traverse(state.state());
    state.finish();
    return Written{state.hash_text(), state.fields()};
  });
}

Checkpoint read_checkpoint(const std::filesystem::path& file) {
  const Scope scope;
  std::error_code ec;
  if (!std::filesystem::exists(file, ec)) fail(file, "no such file; the run was not checkpointed: start it anew");
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file, ec)) fail(file, "cannot be read; name the checkpoint.h5 of a run");
  std::vector<char> bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  static constexpr std::array<char, 8> signature{'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  if (bytes.size() < 8 || !std::equal(signature.begin(), signature.end(), bytes.begin()))
    fail(file, bytes.empty() ? "is empty; start the run anew"
                             : "is not a checkpoint (not an HDF5 file); name the checkpoint.h5 of a run");
  const std::size_t tail = mark.size() + 8;
  if (bytes.size() < 64 + tail ||
      !std::equal(mark.begin(), mark.end(), bytes.end() - static_cast<std::ptrdiff_t>(tail)))
    fail(file, "is truncated, or not a checkpoint of grouser; copy it again or start the run anew");
  std::uint64_t stored = 0;
  for (std::size_t i = 0; i < 8; ++i)
    stored |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[bytes.size() - 8 + i])) << (8 * i);
  bytes.erase(bytes.end() - static_cast<std::ptrdiff_t>(tail), bytes.end());
  if (fnv(bytes.data(), bytes.size()) != stored)
    fail(file, "is damaged: its content does not match its stored hash; copy it again or start the run anew");

  const Properties access = memory_access();
  must(H5Pset_file_image(access.get(), bytes.data(), bytes.size()), file, "read the checkpoint");
  // The image is opened under a name that no file has: HDF5 refuses an image in place of a file that exists.
  const std::string name = file.string() + ".image";
  const File f(must(H5Fopen(name.c_str(), H5F_ACC_RDONLY, access.get()), file, "read the checkpoint"));
  const hid_t root = f.get();
  std::string format, hash;
  if (!read_text(root, format_attribute, format) || format != checkpoint_format)
    fail(file, "is not a checkpoint of this version of grouser; resume with the version that wrote it");
  Checkpoint c;
  std::int64_t frames = 0, fields = 0;
  if (!read_text(root, "scenario", c.scenario) || !read_text(root, "version", c.version) ||
      !read_number(root, "time", c.time) || !read_integer(root, "frames", frames) ||
      !read_text(root, "state_hash", hash) || !read_integer(root, "fields", fields))
    fail(file, "is not a checkpoint of this version of grouser; resume with the version that wrote it");
  c.frames = static_cast<std::uint64_t>(frames);

  const Group group(must(H5Gopen2(root, "state", H5P_DEFAULT), file, "read the checkpoint"));
  std::vector<State::Field> all(static_cast<std::size_t>(fields));
  for (const std::string& flat : dataset_names(group.get())) {
    const std::string doing = "read field '" + flat + "'";
    const Dataset d(must(H5Dopen2(group.get(), flat.c_str(), H5P_DEFAULT), file, doing));
    std::int64_t order = -1;
    State::Field x;
    if (!read_integer(d.get(), "order", order) || order < 0 || order >= fields || !read_text(d.get(), "field", x.name))
      fail(file, "is not a checkpoint of this version of grouser; resume with the version that wrote it");
    const Datatype type(H5Dget_type(d.get()));
    x.kind = H5Tget_class(type.get()) == H5T_FLOAT ? State::Kind::real
             : H5Tget_size(type.get()) == 8        ? State::Kind::integer
                                                   : State::Kind::byte;
    const auto dims = extents(d.get());
    const std::size_t n = dims.empty() ? 0 : dims[0];
    void* target = nullptr;
    if (x.kind == State::Kind::real)
      x.real.resize(n), target = x.real.data();
    else if (x.kind == State::Kind::integer)
      x.integer.resize(n), target = x.integer.data();
    else
      x.byte.resize(n), target = x.byte.data();
    if (n > 0) must(H5Dread(d.get(), stored_kind(x.kind).native, H5S_ALL, H5S_ALL, H5P_DEFAULT, target), file, doing);
    all[static_cast<std::size_t>(order)] = std::move(x);
  }
  for (State::Field& x : all) c.state.append(std::move(x));
  if (c.state.hash_text() != hash)
    fail(file, "is damaged: its state does not match its stored hash; start the run anew");
  c.state.rewind(State::Mode::load);
  return c;
}

}  // namespace grouser
