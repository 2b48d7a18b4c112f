#include "recorder_hdf5.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>

namespace grouser::hdf5 {

namespace {
std::recursive_mutex& library_mutex() {
  static std::recursive_mutex m;
  return m;
}

/// Where the superblock (version 0 or 1, 8-byte addresses) keeps the end of the file; 0 when it is another kind.
std::size_t end_offset(const std::array<unsigned char, 64>& superblock) {
  static constexpr unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
  if (std::memcmp(superblock.data(), signature, 8) != 0 || superblock[13] != 8) return 0;
  return superblock[8] == 0 ? 40 : superblock[8] == 1 ? 44 : 0;
}

std::uint64_t little_endian(const unsigned char* p) {
  std::uint64_t x = 0;
  for (int i = 7; i >= 0; --i) x = (x << 8) | p[i];
  return x;
}

/// Length that the file says it has, or 0 when it does not say.
std::uint64_t stated_length(const std::filesystem::path& file) {
  std::array<unsigned char, 64> head{};
  std::ifstream in(file, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(head.data()), head.size())) return 0;
  const std::size_t at = end_offset(head);
  return at ? little_endian(&head[at]) : 0;
}
}  // namespace

Scope::Scope() : lock_(library_mutex()) {
  H5Eget_auto2(H5E_DEFAULT, &old_, &old_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
Scope::~Scope() { H5Eset_auto2(H5E_DEFAULT, old_, old_data_); }

void fail(const std::filesystem::path& file, const std::string& what) {
  throw ResultsError(file.string() + ": " + what);
}

std::string reason() {
  std::string text;
  // Walking upward starts at the innermost error; that one is the cause.
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* e, void* out) -> herr_t {
        if (n == 0 && e->desc) *static_cast<std::string*>(out) = e->desc;
        return 0;
      },
      &text);
  return text;
}

Properties file_access() {
  Properties access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_file_locking(access.get(), false, true);
  H5AC_cache_config_t cache;
  cache.version = H5AC__CURR_CACHE_CONFIG_VERSION;
  H5Pget_mdc_config(access.get(), &cache);
  cache.evictions_enabled = false;
  cache.incr_mode = H5C_incr__off;
  cache.flash_incr_mode = H5C_flash_incr__off;
  cache.decr_mode = H5C_decr__off;
  H5Pset_mdc_config(access.get(), &cache);
  return access;
}

File open_file(const std::filesystem::path& file, bool write) {
  std::error_code ec;
  if (!std::filesystem::exists(file, ec)) fail(file, "no such file; check the path");
  if (std::filesystem::is_directory(file, ec)) fail(file, "is a folder; name the .h5 file in it");
  if (::access(file.c_str(), write ? R_OK | W_OK : R_OK) != 0)
    fail(file, write ? "may not be written" : "may not be read");
  const auto size = std::filesystem::file_size(file, ec);
  if (size == 0) fail(file, "is empty; it was never written or not copied whole");
  if (H5Fis_hdf5(file.c_str()) <= 0) {
    const std::uint64_t stated = stated_length(file);
    if (stated > size)
      fail(file, "is truncated: it holds " + std::to_string(size) + " of " + std::to_string(stated) +
                     " bytes; copy it again or run again");
    fail(file, "is not an HDF5 file; name a file that grouser wrote");
  }
  const Properties access = file_access();
  File f(H5Fopen(file.c_str(), write ? H5F_ACC_RDWR : H5F_ACC_RDONLY, access.get()));
  if (!f.valid()) {
    const std::string why = reason();
    const std::uint64_t stated = stated_length(file);
    if (stated > size)
      fail(file, "is truncated: it holds " + std::to_string(size) + " of " + std::to_string(stated) +
                     " bytes; copy it again or run again");
    fail(file, "is damaged and cannot be opened (" + why + "); copy it again or run again");
  }
  return f;
}

void write_text(hid_t object, const std::string& name, const std::string& value, const std::filesystem::path& file) {
  Datatype type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  const std::string doing = "write attribute '" + name + "'";
  Attribute a;
  if (H5Aexists(object, name.c_str()) > 0) {
    a = Attribute(must(H5Aopen(object, name.c_str(), H5P_DEFAULT), file, doing));
  } else {
    const Dataspace scalar(H5Screate(H5S_SCALAR));
    a = Attribute(
        must(H5Acreate2(object, name.c_str(), type.get(), scalar.get(), H5P_DEFAULT, H5P_DEFAULT), file, doing));
  }
  const char* text = value.c_str();
  must(H5Awrite(a.get(), type.get(), &text), file, doing);
}

namespace {
template <class T>
void write_scalar(hid_t object, const std::string& name, T value, hid_t stored, hid_t native,
                  const std::filesystem::path& file) {
  const std::string doing = "write attribute '" + name + "'";
  Attribute a;
  if (H5Aexists(object, name.c_str()) > 0) {
    a = Attribute(must(H5Aopen(object, name.c_str(), H5P_DEFAULT), file, doing));
  } else {
    const Dataspace scalar(H5Screate(H5S_SCALAR));
    a = Attribute(must(H5Acreate2(object, name.c_str(), stored, scalar.get(), H5P_DEFAULT, H5P_DEFAULT), file, doing));
  }
  must(H5Awrite(a.get(), native, &value), file, doing);
}

template <class T>
bool read_scalar(hid_t object, const std::string& name, T& value, hid_t native) {
  if (H5Aexists(object, name.c_str()) <= 0) return false;
  const Attribute a(H5Aopen(object, name.c_str(), H5P_DEFAULT));
  if (!a.valid()) return false;
  const Datatype type(H5Aget_type(a.get()));
  const Dataspace space(H5Aget_space(a.get()));
  const H5T_class_t c = H5Tget_class(type.get());
  if ((c != H5T_FLOAT && c != H5T_INTEGER) || H5Sget_simple_extent_npoints(space.get()) != 1) return false;
  return H5Aread(a.get(), native, &value) >= 0;
}
}  // namespace

void write_number(hid_t object, const std::string& name, double value, const std::filesystem::path& file) {
  write_scalar(object, name, value, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, file);
}
void write_integer(hid_t object, const std::string& name, std::int64_t value, const std::filesystem::path& file) {
  write_scalar(object, name, value, H5T_STD_I64LE, H5T_NATIVE_INT64, file);
}
bool read_number(hid_t object, const std::string& name, double& value) {
  return read_scalar(object, name, value, H5T_NATIVE_DOUBLE);
}
bool read_integer(hid_t object, const std::string& name, std::int64_t& value) {
  return read_scalar(object, name, value, H5T_NATIVE_INT64);
}

bool read_text(hid_t object, const std::string& name, std::string& value) {
  if (H5Aexists(object, name.c_str()) <= 0) return false;
  const Attribute a(H5Aopen(object, name.c_str(), H5P_DEFAULT));
  if (!a.valid()) return false;
  const Datatype stored(H5Aget_type(a.get()));
  const Dataspace space(H5Aget_space(a.get()));
  if (H5Tis_variable_str(stored.get()) <= 0 || H5Sget_simple_extent_npoints(space.get()) != 1) return false;
  Datatype type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5Tget_cset(stored.get()));
  char* text = nullptr;
  if (H5Aread(a.get(), type.get(), &text) < 0) return false;
  value = text ? text : "";
  H5free_memory(text);
  return true;
}

std::vector<hsize_t> extents(hid_t dataset, std::vector<hsize_t>* maximum) {
  const Dataspace space(H5Dget_space(dataset));
  const int n = space.valid() ? H5Sget_simple_extent_ndims(space.get()) : 0;
  std::vector<hsize_t> dims(static_cast<std::size_t>(std::max(n, 0))), top(dims.size());
  if (n > 0) H5Sget_simple_extent_dims(space.get(), dims.data(), top.data());
  if (maximum) *maximum = top;
  return dims;
}

std::vector<std::string> dataset_names(hid_t group) {
  std::vector<std::string> names;
  H5Literate(
      group, H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
        static_cast<std::vector<std::string>*>(out)->emplace_back(name);
        return 0;
      },
      &names);
  return names;
}

void secure_file_end(hid_t file, const std::filesystem::path& path) {
  hsize_t allocated = 0;
  void* handle = nullptr;
  must(H5Fget_filesize(file, &allocated), path, "ask for the file's length");
  must(H5Fget_vfd_handle(file, H5P_DEFAULT, &handle), path, "reach the file");
  const int fd = *static_cast<const int*>(handle);
  struct stat st {};
  if (::fstat(fd, &st) != 0) fail(path, std::string("cannot reach the file: ") + std::strerror(errno));
  std::array<unsigned char, 64> head{};
  if (::pread(fd, head.data(), head.size(), 0) != static_cast<ssize_t>(head.size())) return;  // nothing on disk yet
  const std::size_t at = end_offset(head);
  if (at == 0 || little_endian(&head[at]) >= allocated) return;
  if (static_cast<std::uint64_t>(st.st_size) < allocated && ::ftruncate(fd, static_cast<off_t>(allocated)) != 0)
    fail(path, std::string("cannot be made longer: ") + std::strerror(errno) + "; free some disk space");
  std::array<unsigned char, 8> end{};
  for (std::size_t i = 0; i < 8; ++i) end[i] = static_cast<unsigned char>(allocated >> (8 * i));
  if (::pwrite(fd, end.data(), end.size(), static_cast<off_t>(at)) != static_cast<ssize_t>(end.size()))
    fail(path, std::string("cannot be written: ") + std::strerror(errno));
}

bool lock_for_writing(hid_t file) {
  void* handle = nullptr;
  if (H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0) return true;
  // Record locks of the open file: other than flock(), they do not meet the locks that HDF5 readers take.
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return ::fcntl(*static_cast<const int*>(handle), F_OFD_SETLK, &lock) == 0 || (errno != EAGAIN && errno != EACCES);
}

}  // namespace grouser::hdf5
