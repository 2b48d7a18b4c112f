#include "seal.h"

#include <fmt/core.h>

#include <boost/uuid/name_generator_sha1.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace blind {
namespace {

boost::uuids::uuid name_of(std::string_view text) {
  if (text.empty()) throw std::invalid_argument("an empty text has no digest");
  return boost::uuids::name_generator_sha1(boost::uuids::ns::dns())(text.data(), text.size());
}

}  // namespace

std::string digest(std::string_view text) { return boost::uuids::to_string(name_of(text)); }

std::uint64_t seed_of(std::string_view text, int index) {
  const boost::uuids::uuid id = name_of(fmt::format("{}:{}", text, index));
  std::uint64_t seed = 0;
  for (int i = 0; i < 8; ++i) seed = seed << 8 | id.data[i];
  return seed;
}

std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(fmt::format("cannot read {}", path));
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

void write_text(const std::string& path, std::string_view content) {
  const std::filesystem::path file(path);
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  std::ofstream out(path, std::ios::binary);
  out << content;
  if (!out.flush()) throw std::runtime_error(fmt::format("cannot write {}", path));
}

}  // namespace blind
