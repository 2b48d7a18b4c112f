#include <algorithm>
#include <limits>
#include <map>

#include "grouser/terrain/config.h"
#include "recorder_hdf5.h"

namespace grouser {

using namespace hdf5;

struct RunFile::Impl {
  std::filesystem::path path;
  File file;
  RunAttributes attributes;
  std::vector<ChannelSpec> channels, statics;
  std::map<std::string, bool> grows;  // every dataset: true for a channel
  std::uint64_t frames = 0;
};

RunFile::RunFile(const std::filesystem::path& file) : impl_(std::make_unique<Impl>()) {
  const Scope scope;
  Impl& d = *impl_;
  d.path = file;
  try {
    d.file = open_file(file, false);
    const hid_t root = d.file.get();
    std::string format;
    if (!read_text(root, format_attribute, format) || format != run_format)
      fail(file, format == checkpoint_format ? "is a checkpoint, not a run; name the run.h5 beside it"
                                             : "was not written by grouser; name the run.h5 of a run");
    RunAttributes& a = d.attributes;
    read_text(root, "kind", a.kind);
    read_text(root, "scenario", a.scenario);
    read_text(root, "title", a.title);
    read_text(root, "terrain", a.terrain);
    read_text(root, "version", a.version);
    read_integer(root, "seed", a.seed);
    // A kill within a flush leaves some channels one block longer than others: what all have counts.
    std::uint64_t frames = std::numeric_limits<std::uint64_t>::max();
    if (std::int64_t whole = 0; read_integer(root, frames_attribute, whole) && whole >= 0)
      frames = static_cast<std::uint64_t>(whole);
    for (const std::string& name : dataset_names(root)) {
      const Dataset data(
          must(H5Dopen2(root, name.c_str(), H5P_DEFAULT), file, "open dataset '" + name + "'; the file is damaged"));
      std::vector<hsize_t> top;
      const auto dims = extents(data.get(), &top);
      ChannelSpec s;
      s.name = name;
      read_text(data.get(), "unit", s.unit);
      read_text(data.get(), "description", s.description);
      read_text(data.get(), "frame", s.frame);
      const bool grows = !top.empty() && top[0] == H5S_UNLIMITED;
      d.grows[name] = grows;
      if (grows) frames = std::min(frames, static_cast<std::uint64_t>(dims[0]));
      for (std::size_t i = 1; i < dims.size(); ++i) s.components *= static_cast<int>(dims[i]);
      if (name != "time") (grows ? d.channels : d.statics).push_back(std::move(s));
    }
    if (!d.grows.contains("time")) fail(file, "has no dataset 'time'; it was not written whole: run again");
    d.frames = frames;
  } catch (...) {
    impl_.reset();
    throw;
  }
}

RunFile::RunFile(RunFile&&) noexcept = default;
RunFile::~RunFile() {
  const Scope scope;
  impl_.reset();
}

const RunAttributes& RunFile::attributes() const { return impl_->attributes; }
std::vector<ChannelSpec> RunFile::channels() const { return impl_->channels; }
std::vector<ChannelSpec> RunFile::statics() const { return impl_->statics; }
bool RunFile::has(const std::string& name) const { return impl_->grows.contains(name); }
std::uint64_t RunFile::frames() const { return impl_->frames; }
std::vector<double> RunFile::time() const { return read("time"); }

std::vector<double> RunFile::read(const std::string& name, std::vector<std::uint64_t>* dims) const {
  const Scope scope;
  const auto it = impl_->grows.find(name);
  if (it == impl_->grows.end()) {
    std::vector<std::string> known;
    for (const auto& [n, g] : impl_->grows) known.push_back(n);
    const auto near = did_you_mean(name, known);
    fail(impl_->path, "has no dataset '" + name + "'" +
                          (near ? "; did you mean '" + *near + "'?"
                                : "; it was recorded by another version or for another kind of run"));
  }
  const std::string doing = "read dataset '" + name + "'; the file is damaged: copy it again or run again";
  const Dataset data(must(H5Dopen2(impl_->file.get(), name.c_str(), H5P_DEFAULT), impl_->path, doing));
  std::vector<hsize_t> size = extents(data.get());
  if (it->second) size[0] = impl_->frames;
  std::size_t n = 1;
  for (const hsize_t s : size) n *= s;
  if (dims) dims->assign(size.begin(), size.end());
  std::vector<double> values(n);
  if (n == 0) return values;
  const Dataspace disk(H5Dget_space(data.get()));
  const Dataspace memory(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr));
  const std::vector<hsize_t> start(size.size(), 0);
  must(H5Sselect_hyperslab(disk.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr), impl_->path,
       doing);
  must(H5Dread(data.get(), H5T_NATIVE_DOUBLE, memory.get(), disk.get(), H5P_DEFAULT, values.data()), impl_->path,
       doing);
  return values;
}

std::string RunFile::attribute(const std::string& name) const {
  const Scope scope;
  std::string text;
  read_text(impl_->file.get(), name, text);
  return text;
}

double RunFile::number(const std::string& name, double fallback) const {
  const Scope scope;
  double x = fallback;
  return read_number(impl_->file.get(), name, x) ? x : fallback;
}

}  // namespace grouser
