#pragma once
// What recorder, run file and checkpoint share of HDF5: handles that close themselves, quiet errors, text attributes.
#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "grouser/terrain/recorder.h"

namespace grouser::hdf5 {

/// An hid_t with its close function.
template <herr_t (*Close)(hid_t)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(hid_t id) : id_(id) {}
  Handle(Handle&& o) noexcept : id_(std::exchange(o.id_, H5I_INVALID_HID)) {}
  Handle& operator=(Handle&& o) noexcept {
    std::swap(id_, o.id_);
    return *this;
  }
  ~Handle() { reset(); }
  void reset() {
    if (id_ >= 0) Close(id_);
    id_ = H5I_INVALID_HID;
  }
  hid_t get() const { return id_; }
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

using File = Handle<H5Fclose>;
using Group = Handle<H5Gclose>;
using Dataset = Handle<H5Dclose>;
using Dataspace = Handle<H5Sclose>;
using Datatype = Handle<H5Tclose>;
using Attribute = Handle<H5Aclose>;
using Properties = Handle<H5Pclose>;

/// One at a time in HDF5, and without its error stack on stderr. Every public call that touches HDF5 opens one first.
class Scope {
 public:
  Scope();
  ~Scope();
  Scope(const Scope&) = delete;
  Scope& operator=(const Scope&) = delete;

 private:
  std::unique_lock<std::recursive_mutex> lock_;
  H5E_auto2_t old_ = nullptr;
  void* old_data_ = nullptr;
};

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what);
/// The innermost message of HDF5's error stack, "" when there is none.
std::string reason();
/// fail() when `result` is negative.
template <class T>
T must(T result, const std::filesystem::path& file, const std::string& doing) {
  if (result < 0) {
    const std::string why = reason();
    fail(file, "cannot " + doing + (why.empty() ? "" : " (" + why + ")"));
  }
  return result;
}

/// Access list of every file: no HDF5 file locks (a reader may look at a run that is being written, and a killed one),
/// metadata leaves the cache only in a flush.
Properties file_access();
/// Open for reading (or writing), or say what is wrong with the file: missing, not HDF5, truncated, damaged.
File open_file(const std::filesystem::path& file, bool write);

/// Text attributes are variable-length UTF-8: h5py shows them as str, and they may be longer than 64 kB.
void write_text(hid_t object, const std::string& name, const std::string& value, const std::filesystem::path& file);
void write_number(hid_t object, const std::string& name, double value, const std::filesystem::path& file);
void write_integer(hid_t object, const std::string& name, std::int64_t value, const std::filesystem::path& file);
/// False when there is no such attribute (of that class).
bool read_text(hid_t object, const std::string& name, std::string& value);
bool read_number(hid_t object, const std::string& name, double& value);
bool read_integer(hid_t object, const std::string& name, std::int64_t& value);

std::vector<hsize_t> extents(hid_t dataset, std::vector<hsize_t>* maximum = nullptr);
/// Names of the root's (or a group's) datasets in the order of their names.
std::vector<std::string> dataset_names(hid_t group);

/// Make the file as long as HDF5 has allocated, and say so in its superblock, before metadata that points there is
/// written: then a kill at any moment of the flush leaves a file that opens.
void secure_file_end(hid_t file, const std::filesystem::path& path);

/// Exclusive among writers, without hindering readers; released when the process dies. False when somebody else holds
/// it.
bool lock_for_writing(hid_t file);

inline constexpr const char* format_attribute = "format";
inline constexpr const char* frames_attribute = "frames_written";  // whole on disk when this was written
inline constexpr const char* run_format = "grouser run 1";
inline constexpr const char* checkpoint_format = "grouser checkpoint 1";

}  // namespace grouser::hdf5
