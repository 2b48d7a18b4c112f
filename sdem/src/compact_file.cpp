#include "compact_file.h"

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>

#include "grouser/terrain/file_target.h"

namespace grouser::sdem {

namespace fs = std::filesystem;

namespace {

/// Closes what HDF5 opened.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void write_text(hid_t object, const char* name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const char* value = text.c_str();
  H5Awrite(attribute, type, &value);
}

bool write_array(hid_t file, const CompactArray& a) {
  const std::vector<hsize_t> size(a.dims.begin(), a.dims.end());
  // One chunk for each place on the first axis, so that a reader of one node reads no more.
  std::vector<hsize_t> chunk = size;
  chunk[0] = 1;
  if (size.size() == 1) chunk[0] = std::min<hsize_t>(size[0], 65536);
  const Handle space(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr), H5Sclose),
      creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
  H5Pset_shuffle(creation);
  H5Pset_deflate(creation, 6);
  const Handle data(H5Dcreate2(file, a.spec.name.c_str(), H5T_IEEE_F32LE, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                    H5Dclose);
  if (data < 0) return false;
  write_text(data, "unit", a.spec.unit);
  write_text(data, "description", a.spec.description);
  write_text(data, "frame", a.spec.frame);
  return H5Dwrite(data, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, a.values.data()) >= 0;
}

}  // namespace

void add_compact(const fs::path& file, const std::vector<CompactArray>& arrays) {
  static std::mutex one;
  const std::lock_guard lock(one);
  const Handle f(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  bool good = f >= 0;
  for (const CompactArray& a : arrays) good = good && (a.values.empty() || write_array(f, a));
  good = good && H5Fflush(f, H5F_SCOPE_GLOBAL) >= 0;
  if (!good) throw ResultsError(file.string() + ": cannot be written; is the disk full?");
}

fs::path part_of(const fs::path& file) {
  const FileTarget target = file_target(file);
  if (target.stream) throw ResultsError(file.string() + ": is a device or a pipe; HDF5 needs a file of its own");
  std::error_code failed;
  if (target.path.has_parent_path()) fs::create_directories(target.path.parent_path(), failed);
  if (failed) throw ResultsError(file.string() + ": its folder cannot be made: " + failed.message());
  return target.path.string() + "." + std::to_string(::getpid()) + ".part";
}

void rename_part(const fs::path& part, const fs::path& file) {
  std::error_code failed;
  fs::rename(part, file_target(file).path, failed);
  if (failed) throw ResultsError(file.string() + ": cannot be written: " + failed.message());
}

}  // namespace grouser::sdem
