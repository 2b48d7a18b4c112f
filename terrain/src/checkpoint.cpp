#include "grouser/terrain/checkpoint.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>

#include "grouser/terrain/file_target.h"
#include "grouser/terrain/recorder.h"
#include "recorder_hdf5.h"

namespace grouser {

using namespace hdf5;

// The HDF5 image is made in memory and followed by 16 bytes: a mark and the hash of the image. HDF5 ignores what
// follows its end, and a damaged file is found out before HDF5 looks at it.
namespace {

constexpr std::array<char, 8> mark{'g', 'r', 'o', 'u', 's', 'e', 'r', '1'};

std::uint64_t fnv(const char* p, std::size_t n) {
  std::uint64_t h = 1469598103934665603ull;
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

std::vector<char> image(const Checkpoint& c, const std::filesystem::path& file) {
  const Properties access = memory_access();
  const File f(must(H5Fcreate("checkpoint", H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), file, "make a checkpoint"));
  const hid_t root = f.get();
  write_text(root, format_attribute, checkpoint_format, file);
  write_text(root, "scenario", c.scenario, file);
  write_text(root, "version", c.version, file);
  write_number(root, "time", c.time, file);
  write_integer(root, "frames", static_cast<std::int64_t>(c.frames), file);
  write_text(root, "state_hash", c.state.hash_text(), file);
  write_integer(root, "fields", static_cast<std::int64_t>(c.state.fields().size()), file);
  const Group group(must(H5Gcreate2(root, "state", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), file, "make a checkpoint"));
  const Properties small(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_layout(small.get(), H5D_COMPACT);
  std::set<std::string> taken;
  std::int64_t order = 0;
  for (const State::Field& x : c.state.fields()) {
    const StoredKind k = stored_kind(x.kind);
    const std::string name = flat_name(x.name, taken);
    const hsize_t n = x.size();
    const Dataspace space(H5Screate_simple(1, &n, nullptr));
    const hid_t creation = n > 0 && n * H5Tget_size(k.stored) <= 4096 ? small.get() : H5P_DEFAULT;
    const Dataset d(
        must(H5Dcreate2(group.get(), name.c_str(), k.stored, space.get(), H5P_DEFAULT, creation, H5P_DEFAULT), file,
             "store field '" + x.name + "'"));
    if (n > 0)
      must(H5Dwrite(d.get(), k.native, H5S_ALL, H5S_ALL, H5P_DEFAULT, content(x)), file,
           "store field '" + x.name + "'");
    write_integer(d.get(), "order", order++, file);
    write_text(d.get(), "field", x.name, file);
  }
  must(H5Fflush(root, H5F_SCOPE_LOCAL), file, "make a checkpoint");
  const auto size = must(H5Fget_file_image(root, nullptr, 0), file, "make a checkpoint");
  std::vector<char> bytes(static_cast<std::size_t>(size));
  must(H5Fget_file_image(root, bytes.data(), bytes.size()), file, "make a checkpoint");
  return bytes;
}

void write_all(int fd, const char* p, std::size_t n, const std::filesystem::path& file) {
  while (n > 0) {
    const ssize_t k = ::write(fd, p, n);
    if (k < 0 && errno == EINTR) continue;
    if (k <= 0) fail(file, std::string("cannot be written: ") + std::strerror(errno));
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

}  // namespace

void write_checkpoint(const std::filesystem::path& file, const Checkpoint& c) {
  const Scope scope;
  std::vector<char> bytes = image(c, file);
  const std::uint64_t hash = fnv(bytes.data(), bytes.size());
  bytes.insert(bytes.end(), mark.begin(), mark.end());
  for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<char>((hash >> (8 * i)) & 0xff));

  const FileTarget target = file_target(file);
  if (target.stream) fail(file, "is a device or a pipe; HDF5 needs a file of its own");
  const std::filesystem::path temporary = target.path.string() + ".part";
  {
    const Descriptor d{::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
    if (d.fd < 0) fail(file, std::string("cannot be written: ") + std::strerror(errno));
    write_all(d.fd, bytes.data(), bytes.size(), file);
    if (::fsync(d.fd) != 0) fail(file, std::string("cannot be written: ") + std::strerror(errno));
  }
  if (std::rename(temporary.c_str(), target.path.c_str()) != 0)
    fail(file, std::string("cannot be written: ") + std::strerror(errno));
  // The new name itself must survive a power cut too.
  const Descriptor folder{::open(target.path.has_parent_path() ? target.path.parent_path().c_str() : ".",
                                 O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (folder.fd >= 0) ::fsync(folder.fd);
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
