#pragma once
// What ConfigNode and ConfigDocument share. Internal: yaml-cpp stays out of the public header.
#include <yaml-cpp/yaml.h>

#include <map>
#include <set>

#include "grouser/terrain/config.h"

namespace grouser {

struct ConfigDocument::Impl {
  std::string file;
  std::filesystem::path base;
  std::string text;
  std::optional<YAML::Node> root;
  std::vector<Diagnostic> diagnostics;
  std::vector<Assumption> assumptions;
  std::map<std::string, std::set<std::string>> asked;  ///< keys asked for, by path of their map
  std::map<std::string, Diagnostic> missing;           ///< by path of the key

  void note(Diagnostic d);  ///< the same words at the same place only once
  void assume(Assumption a);
};

/// A single value with its place.
struct Scalar {
  std::string text;
  std::string path;
  int line, column;
};

struct ConfigNode::Impl {
  std::shared_ptr<ConfigDocument::Impl> doc;
  YAML::Node node;
  std::string path;
  int line, column;  ///< of the value when scalar, else of the key that names the node

  struct Entry {
    YAML::Node key, value;
  };
  std::optional<Entry> find(const std::string& key) const;
  std::string child_path(const std::string& key) const { return path.empty() ? key : path + "." + key; }
  ConfigNode child(const Entry& e, const std::string& key) const;
  static std::string prefix(const std::string& path) { return path.empty() ? "" : path + ": "; }

  void note(int at_line, int at_column, const std::string& message) const {
    doc->note({doc->file, at_line, at_column, message});
  }
  void note_missing(const std::string& key, const std::string& example, const std::string& more = "") const;
  /// Notes that the key was asked for; false with a diagnostic when this is no map.
  bool ask(const std::string& key) const;

  /// Takes {value:, source:} and {assumed:, why:} off; what is left, with its place.
  std::optional<ConfigNode> unwrapped() const;
  std::optional<Scalar> scalar() const;
};

inline int mark_line(const YAML::Mark& m) { return m.line + 1; }
inline int mark_column(const YAML::Mark& m) { return m.column + 1; }

}  // namespace grouser
