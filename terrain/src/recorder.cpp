#include "grouser/terrain/recorder.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "grouser/terrain/file_target.h"
#include "recorder_hdf5.h"

namespace grouser {

using namespace hdf5;

namespace {
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr hsize_t chunk_rows = 1024;
constexpr std::uint64_t compressed_from = 4096;  ///< values of a static

struct Channel {
  ChannelSpec spec;
  Dataset data;
  std::vector<double> block;  // flush_every rows
};

void write_spec(hid_t dataset, const ChannelSpec& s, const std::filesystem::path& file) {
  write_text(dataset, "unit", s.unit, file);
  write_text(dataset, "description", s.description, file);
  write_text(dataset, "frame", s.frame, file);
}
}  // namespace

struct Recorder::Impl {
  std::filesystem::path path, temporary;  // `temporary` until the first flush has made the file whole
  File file;
  Channel time;
  std::vector<Channel> channels;
  std::map<std::string, int> index;
  std::vector<std::string> expected;  // resume: channels of the file that the caller has not named yet
  bool resumed = false, started = false;
  std::uint64_t written = 0;  // frames on disk
  std::size_t rows = 0, capacity = 50;
  bool closed = false;

  const std::filesystem::path& where() const { return temporary.empty() ? path : temporary; }

  void clear_block(Channel& c) const { c.block.assign(capacity * static_cast<std::size_t>(c.spec.components), nan); }

  Channel create(const ChannelSpec& s) const {
    const bool vector = s.components > 1;
    const auto width = static_cast<hsize_t>(s.components);
    const std::array<hsize_t, 2> dims{0, width}, top{H5S_UNLIMITED, width}, chunk{chunk_rows, width};
    const Dataspace space(H5Screate_simple(vector ? 2 : 1, dims.data(), top.data()));
    const Properties creation(H5Pcreate(H5P_DATASET_CREATE));
    H5Pset_chunk(creation.get(), vector ? 2 : 1, chunk.data());
    H5Pset_fill_value(creation.get(), H5T_NATIVE_DOUBLE, &nan);
    const Properties access(H5Pcreate(H5P_DATASET_ACCESS));
    // No chunk cache: a block goes straight to its place instead of the whole chunk once per flush.
    H5Pset_chunk_cache(access.get(), 1, 0, 1.0);
    Channel c{s,
              Dataset(must(H5Dcreate2(file.get(), s.name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT,
                                      creation.get(), access.get()),
                           path, "create channel '" + s.name + "'")),
              {}};
    write_spec(c.data.get(), s, path);
    clear_block(c);
    return c;
  }

  Channel open(const std::string& name) const {
    const Properties access(H5Pcreate(H5P_DATASET_ACCESS));
    H5Pset_chunk_cache(access.get(), 1, 0, 1.0);
    Channel c;
    c.spec.name = name;
    c.data = Dataset(must(H5Dopen2(file.get(), name.c_str(), access.get()), path, "open channel '" + name + "'"));
    read_text(c.data.get(), "unit", c.spec.unit);
    read_text(c.data.get(), "description", c.spec.description);
    read_text(c.data.get(), "frame", c.spec.frame);
    const auto dims = extents(c.data.get());
    c.spec.components = dims.size() == 2 ? static_cast<int>(dims[1]) : 1;
    clear_block(c);
    return c;
  }

  void append(Channel& c) {
    const auto width = static_cast<hsize_t>(c.spec.components);
    const int rank = c.spec.components > 1 ? 2 : 1;
    const std::array<hsize_t, 2> size{written + rows, width}, start{written, 0}, count{rows, width};
    const std::string doing = "write channel '" + c.spec.name + "'";
    must(H5Dset_extent(c.data.get(), size.data()), path, doing);
    const Dataspace disk(H5Dget_space(c.data.get()));
    const Dataspace memory(H5Screate_simple(rank, count.data(), nullptr));
    must(H5Sselect_hyperslab(disk.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr), path, doing);
    must(H5Dwrite(c.data.get(), H5T_NATIVE_DOUBLE, memory.get(), disk.get(), H5P_DEFAULT, c.block.data()), path,
         doing + "; is the disk full?");
    std::fill(c.block.begin(), c.block.end(), nan);
  }

  void flush() {
    const bool more = rows > 0;
    if (more) {
      for (Channel& c : channels) append(c);
      append(time);
      written += rows;
      rows = 0;
    }
    secure_file_end(file.get(), path);
    must(H5Fflush(file.get(), H5F_SCOPE_LOCAL), path, "write to disk; is the disk full?");
    // A kill within the flush may leave longer channels whose last chunk is not in the index yet: count what is whole.
    if (more) {
      write_integer(file.get(), frames_attribute, static_cast<std::int64_t>(written), path);
      must(H5Fflush(file.get(), H5F_SCOPE_LOCAL), path, "write to disk; is the disk full?");
    }
    if (temporary.empty()) return;
    // From here on the file is whole: give it its name.
    if (std::rename(temporary.c_str(), path.c_str()) != 0)
      fail(path, std::string("cannot be written: ") + std::strerror(errno));
    temporary.clear();
  }

  void check_channels() {
    for (const std::string& name : expected)
      if (!index.contains(name))
        fail(path, "cannot be continued: it holds channel '" + name + "', which this run does not record; " +
                       "resume with the scenario and the version that wrote it");
    expected.clear();
  }

  void close() {
    if (closed) return;
    closed = true;
    flush();
    time.data.reset();
    for (Channel& c : channels) c.data.reset();
    file.reset();
  }
};

Recorder::Recorder(std::unique_ptr<Impl> i) : impl_(std::move(i)) {}
Recorder::Recorder(Recorder&&) noexcept = default;
Recorder& Recorder::operator=(Recorder&& o) noexcept {
  std::swap(impl_, o.impl_);
  return *this;
}

Recorder::~Recorder() {
  if (!impl_) return;
  const Scope scope;
  try {
    impl_->close();
  } catch (const std::exception&) {
    // A destructor cannot report; whoever wants to know calls close().
  }
  impl_.reset();
}

Recorder Recorder::create(const std::filesystem::path& file, const RunAttributes& a, int flush_every) {
  const Scope scope;
  auto impl = std::make_unique<Impl>();
  const FileTarget target = file_target(file);
  if (target.stream) fail(file, "is a device or a pipe; HDF5 needs a file of its own");
  impl->path = target.path;
  impl->temporary = target.path.string() + ".part";
  impl->capacity = static_cast<std::size_t>(std::max(1, flush_every));
  std::error_code ec;
  if (impl->path.has_parent_path() && !std::filesystem::is_directory(impl->path.parent_path(), ec))
    fail(file, "its folder does not exist; create it first");
  const Properties creation(H5Pcreate(H5P_FILE_CREATE));
  // One node of a chunk index takes 2 * 128 chunks: it splits after 262144 frames, and only then.
  H5Pset_istore_k(creation.get(), 128);
  const Properties access = file_access();
  // Remove first: a file that somebody still writes keeps its own copy.
  std::filesystem::remove(impl->temporary, ec);
  impl->file = File(must(H5Fcreate(impl->temporary.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), file,
                         "be created; is the folder writable?"));
  const hid_t root = impl->file.get();
  write_text(root, format_attribute, run_format, file);
  write_text(root, "kind", a.kind, file);
  write_text(root, "scenario", a.scenario, file);
  write_text(root, "title", a.title, file);
  write_text(root, "terrain", a.terrain, file);
  write_text(root, "version", a.version, file);
  write_integer(root, "seed", a.seed, file);
  lock_for_writing(impl->file.get());
  impl->time = impl->create({"time", "s", "simulated time of the frame", "", 1});
  return Recorder(std::move(impl));
}

Recorder Recorder::resume(const std::filesystem::path& file, std::uint64_t frames, int flush_every) {
  const Scope scope;
  const std::uint64_t held = RunFile(file).frames();
  if (held < frames)
    fail(file, "holds " + std::to_string(held) + " frames, " + std::to_string(frames) +
                   " are needed to continue; it belongs to another checkpoint: start the run anew");
  auto impl = std::make_unique<Impl>();
  impl->path = file;
  impl->capacity = static_cast<std::size_t>(std::max(1, flush_every));
  impl->file = open_file(file, true);
  if (!lock_for_writing(impl->file.get())) fail(file, "is being written by another process; wait for it or stop it");
  for (const std::string& name : dataset_names(impl->file.get())) {
    std::vector<hsize_t> top;
    Dataset d(must(H5Dopen2(impl->file.get(), name.c_str(), H5P_DEFAULT), file, "open channel '" + name + "'"));
    std::vector<hsize_t> dims = extents(d.get(), &top);
    if (top.empty() || top[0] != H5S_UNLIMITED) continue;
    if (dims[0] != frames) {
      dims[0] = frames;
      must(H5Dset_extent(d.get(), dims.data()), file,
           "cut channel '" + name + "' to " + std::to_string(frames) + " frames");
    }
    if (name != "time") impl->expected.push_back(name);
  }
  write_integer(impl->file.get(), frames_attribute, static_cast<std::int64_t>(frames), file);
  must(H5Fflush(impl->file.get(), H5F_SCOPE_LOCAL), file, "write to disk; is the disk full?");
  impl->written = frames;
  impl->resumed = true;
  impl->time = impl->open("time");
  return Recorder(std::move(impl));
}

int Recorder::add_channel(const ChannelSpec& s) {
  if (impl_->started) throw std::logic_error("channel '" + s.name + "' is added after the first frame");
  if (impl_->index.contains(s.name) || s.name == "time")
    throw std::logic_error("channel '" + s.name + "' is added twice");
  if (s.name.empty() || s.name.find('/') != std::string::npos)
    throw std::logic_error("channel name '" + s.name + "' must be flat and not empty");
  if (s.components < 1) throw std::logic_error("channel '" + s.name + "' needs at least one component");
  const Scope scope;
  Channel c;
  if (impl_->resumed) {
    const auto& known = impl_->expected;
    if (std::find(known.begin(), known.end(), s.name) == known.end())
      fail(impl_->path, "cannot be continued: it has no channel '" + s.name +
                            "'; resume with the scenario and the version that wrote it");
    c = impl_->open(s.name);
    if (c.spec.unit != s.unit || c.spec.frame != s.frame || c.spec.components != s.components)
      fail(impl_->path, "cannot be continued: channel '" + s.name + "' has unit '" + c.spec.unit + "', frame '" +
                            c.spec.frame + "' and " + std::to_string(c.spec.components) + " components in the file, '" +
                            s.unit + "', '" + s.frame + "' and " + std::to_string(s.components) +
                            " in this run; resume with the version that wrote it");
  } else {
    c = impl_->create(s);
  }
  const int handle = static_cast<int>(impl_->channels.size());
  impl_->channels.push_back(std::move(c));
  impl_->index[s.name] = handle;
  return handle;
}

int Recorder::channel(const std::string& name) const {
  const auto it = impl_->index.find(name);
  if (it == impl_->index.end()) throw std::out_of_range("no channel '" + name + "' in " + impl_->path.string());
  return it->second;
}

void Recorder::set(int channel, std::span<const double> values) {
  Channel& c = impl_->channels.at(static_cast<std::size_t>(channel));
  const auto width = static_cast<std::size_t>(c.spec.components);
  if (values.size() != width)
    throw std::logic_error("channel '" + c.spec.name + "' takes " + std::to_string(width) + " values, got " +
                           std::to_string(values.size()));
  std::copy(values.begin(), values.end(), c.block.begin() + static_cast<std::ptrdiff_t>(impl_->rows * width));
}

void Recorder::end_frame(double t) {
  if (!std::isfinite(t)) throw std::logic_error("frame time is not finite in " + impl_->path.string());
  if (!impl_->started) {
    impl_->check_channels();
    impl_->started = true;
    // The first frame makes the structure visible on disk.
    if (!impl_->resumed) {
      const Scope scope;
      impl_->flush();
    }
  }
  impl_->time.block[impl_->rows] = t;
  if (++impl_->rows < impl_->capacity) return;
  const Scope scope;
  impl_->flush();
}

std::uint64_t Recorder::frames() const { return impl_->written + impl_->rows; }

void Recorder::write_static(const ChannelSpec& s, std::span<const double> values,
                            const std::vector<std::uint64_t>& dims) {
  std::uint64_t n = 1;
  for (const std::uint64_t d : dims) n *= d;
  if (dims.empty() || n != values.size())
    throw std::logic_error("static '" + s.name + "' has " + std::to_string(values.size()) + " values for extents of " +
                           std::to_string(n));
  const Scope scope;
  const std::filesystem::path& file = impl_->path;
  const std::vector<hsize_t> size(dims.begin(), dims.end());
  Dataset d;
  if (H5Lexists(impl_->file.get(), s.name.c_str(), H5P_DEFAULT) > 0) {
    d = Dataset(must(H5Dopen2(impl_->file.get(), s.name.c_str(), H5P_DEFAULT), file, "open dataset '" + s.name + "'"));
    if (extents(d.get()) != size)
      fail(file, "dataset '" + s.name + "' exists with other extents; resume with the version that wrote it");
  } else {
    const Dataspace space(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr));
    const Properties creation(H5Pcreate(H5P_DATASET_CREATE));
    if (n >= compressed_from) {
      std::vector<hsize_t> chunk = size;
      chunk[0] = std::min<hsize_t>(chunk[0], 1 << 16);
      H5Pset_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data());
      H5Pset_shuffle(creation.get());
      H5Pset_deflate(creation.get(), 4);
    }
    d = Dataset(must(H5Dcreate2(impl_->file.get(), s.name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT,
                                creation.get(), H5P_DEFAULT),
                     file, "create dataset '" + s.name + "'"));
    write_spec(d.get(), s, file);
  }
  must(H5Dwrite(d.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), file,
       "write dataset '" + s.name + "'");
}

void Recorder::set_attribute(const std::string& name, const std::string& value) {
  const Scope scope;
  write_text(impl_->file.get(), name, value, impl_->path);
}
void Recorder::set_attribute(const std::string& name, double value) {
  const Scope scope;
  write_number(impl_->file.get(), name, value, impl_->path);
}

void Recorder::flush() {
  const Scope scope;
  impl_->flush();
}

void Recorder::close() {
  const Scope scope;
  impl_->close();
}

}  // namespace grouser
