#include <algorithm>

#include "config_impl.h"

namespace grouser {
namespace {

bool is_null(const YAML::Node& n) { return !n.IsDefined() || n.IsNull(); }

std::string quoted_list(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& w : words) text += (text.empty() ? "" : ", ") + w;
  return text;
}

}  // namespace

std::optional<ConfigNode::Impl::Entry> ConfigNode::Impl::find(const std::string& key) const {
  if (!node.IsMap()) return std::nullopt;
  for (const auto& pair : node)
    if (pair.first.IsScalar() && pair.first.Scalar() == key) return Entry{pair.first, pair.second};
  return std::nullopt;
}

ConfigNode ConfigNode::Impl::child(const Entry& e, const std::string& key) const {
  const YAML::Mark m = e.value.IsScalar() ? e.value.Mark() : e.key.Mark();
  return ConfigNode(std::make_shared<Impl>(Impl{doc, e.value, child_path(key), mark_line(m), mark_column(m)}));
}

void ConfigNode::Impl::note_missing(const std::string& key, const std::string& example, const std::string& more) const {
  const std::string in = path.empty() ? "" : " in " + path;
  const Diagnostic d{doc->file, line, column,
                     "missing key '" + key + "'" + in + "; for example '" + key + ": " + example + "'" + more};
  doc->missing.emplace(child_path(key), d);
  doc->note(d);
}

bool ConfigNode::Impl::ask(const std::string& key) const {
  doc->asked[path].insert(key);
  if (node.IsMap() || is_null(node)) return true;
  note(line, column, prefix(path) + "a map with 'key: value' lines is wanted here");
  return false;
}

std::optional<ConfigNode> ConfigNode::Impl::unwrapped() const {
  if (is_null(node)) {
    note(line, column, prefix(path) + "a value is missing after the ':'");
    return std::nullopt;
  }
  if (!node.IsMap()) return ConfigNode(std::make_shared<Impl>(*this));
  const auto value = find("value");
  const auto assumed = find("assumed");
  if (!value && !assumed) {
    note(line, column,
         prefix(path) + "a single value is wanted, or {value: ..., source: ...}, or {assumed: ..., why: ...}");
    return std::nullopt;
  }
  if (value && assumed) {
    note(line, column, prefix(path) + "both 'value' and 'assumed' are given; a value is the one or the other");
    return std::nullopt;
  }
  const std::string reason_key = value ? "source" : "why";
  const std::vector<std::string> allowed{value ? "value" : "assumed", reason_key};
  bool good = true;
  for (const auto& pair : node) {
    if (!pair.first.IsScalar()) continue;  // the walk over the file has noted it
    const std::string key = pair.first.Scalar();
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    const auto near = did_you_mean(key, allowed);
    note(mark_line(pair.first.Mark()), mark_column(pair.first.Mark()),
         "unknown key '" + key + "' in " + path +
             (near ? "; did you mean '" + *near + "'?" : "; known here: " + quoted_list(allowed)));
    good = false;
  }
  const auto reason = find(reason_key);
  const bool has_reason = reason && reason->value.IsScalar() && !reason->value.Scalar().empty();
  if (!has_reason && good)
    note(line, column, prefix(path) + "'" + allowed[0] + "' needs '" + reason_key + ": text' next to it");
  const Entry& e = value ? *value : *assumed;
  ConfigNode inner = child(e, allowed[0]);
  Impl bare{doc, e.value, path, inner.impl_->line, inner.impl_->column};
  if (assumed && has_reason) {
    YAML::Emitter text;
    text << YAML::Flow << e.value;
    doc->assume({doc->file, path, text.c_str(), reason->value.Scalar()});
  }
  return ConfigNode(std::make_shared<Impl>(std::move(bare)));
}

std::optional<Scalar> ConfigNode::Impl::scalar() const {
  const auto bare = unwrapped();
  if (!bare) return std::nullopt;
  const Impl& b = *bare->impl_;
  if (!b.node.IsScalar()) {
    if (is_null(b.node))
      note(b.line, b.column, prefix(path) + "a value is missing after the ':'");
    else
      note(b.line, b.column, prefix(path) + "a single value is wanted, not a " + (b.node.IsMap() ? "map" : "list"));
    return std::nullopt;
  }
  return Scalar{b.node.Scalar(), path, b.line, b.column};
}

bool ConfigNode::present() const { return impl_ != nullptr; }
bool ConfigNode::is_map() const { return impl_ && impl_->node.IsMap(); }
bool ConfigNode::is_list() const { return impl_ && impl_->node.IsSequence(); }
bool ConfigNode::is_scalar() const { return impl_ && impl_->node.IsScalar(); }

bool ConfigNode::has(const std::string& key) const {
  if (!impl_) return false;
  impl_->doc->asked[impl_->path].insert(key);
  return impl_->find(key).has_value();
}

ConfigNode ConfigNode::node(const std::string& key) const {
  if (!impl_ || !impl_->ask(key)) return {};
  const auto e = impl_->find(key);
  return e ? impl_->child(*e, key) : ConfigNode();
}

ConfigNode ConfigNode::optional_map(const std::string& key) const {
  const ConfigNode n = node(key);
  if (!n.present() || n.is_map() || is_null(n.impl_->node)) return n;
  n.error("a map with 'key: value' lines is wanted here");
  return {};
}

ConfigNode ConfigNode::map(const std::string& key) const {
  const ConfigNode n = optional_map(key);
  if (impl_ && impl_->ask(key) && !impl_->find(key)) impl_->note_missing(key, "{...}");
  return n;
}

std::vector<ConfigNode> ConfigNode::optional_list(const std::string& key) const {
  const ConfigNode n = node(key);
  if (!n.present() || is_null(n.impl_->node)) return {};
  if (n.is_list()) return n.items();
  n.error("a list is wanted here: one '- ...' line per item");
  return {};
}

std::vector<ConfigNode> ConfigNode::list(const std::string& key) const {
  if (!impl_ || !impl_->ask(key)) return {};
  const auto e = impl_->find(key);
  if (!e) {
    impl_->note_missing(key, "[...]");
    return {};
  }
  const std::vector<ConfigNode> out = optional_list(key);
  if (out.empty() && (e->value.IsSequence() || is_null(e->value)))
    impl_->child(*e, key).error("the list is empty; at least one item is wanted");
  return out;
}

std::vector<ConfigNode> ConfigNode::items() const {
  std::vector<ConfigNode> out;
  if (!is_list()) return out;
  for (const YAML::Node& item : impl_->node) {
    const YAML::Mark m = item.Mark();
    out.push_back(ConfigNode(std::make_shared<Impl>(
        Impl{impl_->doc, item, impl_->path + "[" + std::to_string(out.size()) + "]", mark_line(m), mark_column(m)})));
  }
  return out;
}

std::vector<std::string> ConfigNode::keys() const {
  std::vector<std::string> out;
  if (!is_map()) return out;
  for (const auto& pair : impl_->node)
    if (pair.first.IsScalar() && std::find(out.begin(), out.end(), pair.first.Scalar()) == out.end())
      out.push_back(pair.first.Scalar());
  return out;
}

void ConfigNode::finish() const {
  if (!is_map()) return;
  const std::set<std::string>& asked = impl_->doc->asked[impl_->path];
  std::vector<std::string> absent, known(asked.begin(), asked.end());
  for (const std::string& k : known)
    if (!impl_->find(k)) absent.push_back(k);
  for (const std::string& key : keys()) {
    if (asked.count(key) != 0) continue;
    // A typo more likely stands for a key that is not there yet.
    auto near = did_you_mean(key, absent);
    if (!near) near = did_you_mean(key, known);
    const auto e = impl_->find(key);
    impl_->note(mark_line(e->key.Mark()), mark_column(e->key.Mark()),
                "unknown key '" + key + "'" + (impl_->path.empty() ? "" : " in " + impl_->path) +
                    (near            ? "; did you mean '" + *near + "'?"
                     : known.empty() ? "; no keys are known here"
                                     : "; known here: " + quoted_list(known)));
    // One mistake, one line: the key under its wrong name is not missing as well.
    if (!near) continue;
    const auto missing = impl_->doc->missing.find(impl_->child_path(*near));
    if (missing == impl_->doc->missing.end()) continue;
    auto& all = impl_->doc->diagnostics;
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&](const Diagnostic& d) {
                               const Diagnostic& m = missing->second;
                               return d.line == m.line && d.column == m.column && d.message == m.message;
                             }),
              all.end());
    impl_->doc->missing.erase(missing);
  }
}

void ConfigNode::error(const std::string& message) const {
  if (impl_) impl_->note(impl_->line, impl_->column, Impl::prefix(impl_->path) + message);
}

void ConfigNode::error_at(const std::string& key, const std::string& message) const {
  if (!impl_) return;
  const auto e = impl_->find(key);
  if (!e) return error(message);
  ConfigNode at = impl_->child(*e, key);
  // Point at the number inside {value: ...} rather than at the map.
  for (const char* inner : {"value", "assumed"})
    if (const auto v = at.impl_->find(inner); v && v->value.IsScalar()) {
      const YAML::Mark m = v->value.Mark();
      impl_->note(mark_line(m), mark_column(m), Impl::prefix(at.path()) + message);
      return;
    }
  at.error(message);
}

void ConfigNode::report(Diagnostic d) const {
  if (impl_) impl_->doc->note(std::move(d));
}

void ConfigNode::assume(const std::string& key, const std::string& value, const std::string& why) const {
  if (impl_) impl_->doc->assume({impl_->doc->file, impl_->child_path(key), value, why});
}

std::size_t ConfigNode::errors() const { return impl_ ? impl_->doc->diagnostics.size() : 0; }

std::string ConfigNode::path() const { return impl_ ? impl_->path : ""; }
int ConfigNode::line() const { return impl_ ? impl_->line : 0; }
int ConfigNode::column() const { return impl_ ? impl_->column : 0; }
std::string ConfigNode::file() const { return impl_ ? impl_->doc->file : ""; }

}  // namespace grouser
