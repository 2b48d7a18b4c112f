#include <algorithm>
#include <fstream>
#include <functional>
#include <sstream>
#include <tuple>

#include "config_impl.h"
#include "config_syntax.h"
#include "text_check.h"

namespace grouser {
namespace {

constexpr int max_depth = 100;
constexpr long max_nodes = 1000000;

/// What yaml-cpp lets through: duplicate keys, keys without a colon, open quotes, keys that are no text, aliases that
/// contain themselves or blow up.
class Walker {
 public:
  using Note = std::function<void(const YAML::Mark&, const std::string&)>;
  Walker(const std::string& text, Note note) : text_(text), note_(std::move(note)) {}

  bool walk(const YAML::Node& node, const std::string& path, int depth) {
    if (stopped_) return false;
    if (depth > max_depth || ++count_ > max_nodes) {
      stop(node, depth > max_depth ? "nested deeper than 100 levels, or an alias that contains itself; write "
                                     "the values out in place of the alias ('*name')"
                                   : "more than a million entries once the aliases ('*name') are written out; "
                                     "no file here needs so many: write the values in place of the aliases");
      return false;
    }
    // yaml-cpp takes the rest of the file for the text of a quote that nobody closes.
    if (open_quote(node)) return false;
    if (node.IsSequence()) {
      std::size_t i = 0;
      for (const YAML::Node& item : node) walk(item, path + "[" + std::to_string(i++) + "]", depth + 1);
    } else if (node.IsMap()) {
      std::map<std::string, int> seen;
      for (const auto& pair : node) {
        if (!pair.first.IsScalar()) {
          note(pair.first, "a key must be plain text" + where(path));
          continue;
        }
        if (open_quote(pair.first)) return false;
        const std::string key = pair.first.Scalar();
        if (pair.second.IsNull() && key.find(' ') != std::string::npos)
          if (const auto wrong = missing_colon(key)) {
            broken_ = true;
            note(pair.first, "not valid YAML: " + *wrong);
          }
        const auto [it, fresh] = seen.emplace(key, mark_line(pair.first.Mark()));
        if (!fresh)
          note(pair.first, "duplicate key '" + key + "'" + where(path) + "; first given in line " +
                               std::to_string(it->second) + ", remove one of the two");
        walk(pair.second, path.empty() ? key : path + "." + key, depth + 1);
      }
    }
    return !stopped_ && !broken_;
  }

 private:
  static std::string where(const std::string& path) { return path.empty() ? "" : " in " + path; }
  bool open_quote(const YAML::Node& n) {
    if (!n.IsScalar() || n.Mark().pos < 0 || !is_open_quote(text_, static_cast<std::size_t>(n.Mark().pos)))
      return false;
    stop(n, "not valid YAML: the quote that opens here is not closed");
    return true;
  }
  void note(const YAML::Node& at, const std::string& message) { note_(at.Mark(), message); }
  void stop(const YAML::Node& at, const std::string& message) {
    stopped_ = true;
    note(at, message);
  }
  const std::string& text_;
  Note note_;
  long count_ = 0;
  bool stopped_ = false, broken_ = false;
};

}  // namespace

void ConfigDocument::Impl::note(Diagnostic d) {
  const bool known = std::any_of(diagnostics.begin(), diagnostics.end(), [&](const Diagnostic& x) {
    return x.file == d.file && x.line == d.line && x.column == d.column && x.message == d.message;
  });
  if (!known) diagnostics.push_back(std::move(d));
}

void ConfigDocument::Impl::assume(Assumption a) {
  const bool known = std::any_of(assumptions.begin(), assumptions.end(), [&](const Assumption& x) {
    return x.file == a.file && x.key == a.key && x.value == a.value;
  });
  if (!known) assumptions.push_back(std::move(a));
}

ConfigDocument ConfigDocument::from_text(std::string text, std::string name, std::filesystem::path base_directory) {
  ConfigDocument out;
  out.impl_ = std::make_shared<Impl>();
  Impl& d = *out.impl_;
  d.file = std::move(name);
  d.base = std::move(base_directory);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // yaml-cpp counts places without it
  d.text = std::move(text);
  const auto note = [&d](const YAML::Mark& m, const std::string& message) {
    d.note({d.file, std::max(1, mark_line(m)), std::max(1, mark_column(m)), message});
  };
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(d.text);
    if (documents.size() > 1)
      note(documents[1].Mark(), "a second YAML document starts here; one file holds one document");
    if (documents.empty() || !documents[0].IsDefined() || documents[0].IsNull()) return out;
    const YAML::Node& root = documents[0];
    if (!Walker(d.text, note).walk(root, "", 0)) return out;
    d.root.emplace(root);
  } catch (const YAML::Exception& e) {
    SyntaxFault f = explain_syntax(d.text, std::max(1, mark_line(e.mark)), std::max(1, mark_column(e.mark)), e.msg);
    d.note({d.file, f.line, f.column, std::move(f.message)});
  }
  return out;
}

ConfigDocument ConfigDocument::from_file(const std::filesystem::path& path) {
  const auto failed = [&](const std::string& why) {
    ConfigDocument out = from_text("", path.string(), path.parent_path());
    out.impl_->note({path.string(), 0, 0, why});
    return out;
  };
  std::error_code ec;
  if (!std::filesystem::exists(path, ec)) return failed("the file does not exist");
  if (std::filesystem::is_directory(path, ec)) return failed("this is a folder; a YAML file is wanted");
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return failed("the file cannot be read; look at its permissions");
  if (const auto wrong = find_non_text(text.view(), "a YAML file", true)) {
    ConfigDocument out = from_text("", path.string(), path.parent_path());
    out.impl_->note({path.string(), wrong->line, wrong->column, wrong->message});
    return out;
  }
  ConfigDocument out = from_text(text.str(), path.string(), path.parent_path());
  if (out.diagnostics().empty() && !out.root().present())
    out.impl_->note({path.string(), 1, 1, "the file is empty; 'key: value' lines are wanted"});
  return out;
}

ConfigNode ConfigDocument::root() const {
  if (!impl_ || !impl_->root) return {};
  const YAML::Mark m = impl_->root->Mark();
  return ConfigNode(
      std::make_shared<ConfigNode::Impl>(ConfigNode::Impl{impl_, *impl_->root, "", mark_line(m), mark_column(m)}));
}

const std::string& ConfigDocument::text() const { return impl_->text; }

std::string ConfigDocument::file() const { return impl_->file; }

const std::vector<Diagnostic>& ConfigDocument::diagnostics() const { return impl_->diagnostics; }

const std::vector<Assumption>& ConfigDocument::assumptions() const { return impl_->assumptions; }

void ConfigDocument::absorb(const ConfigDocument& other) const {
  if (other.impl_ == impl_) return;
  for (const Diagnostic& d : other.diagnostics()) impl_->note(d);
  for (const Assumption& a : other.assumptions()) impl_->assume(a);
}

void ConfigDocument::check() const {
  if (impl_->diagnostics.empty()) return;
  std::vector<Diagnostic> sorted = impl_->diagnostics;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return std::tie(a.file, a.line, a.column) < std::tie(b.file, b.line, b.column);
  });
  throw ConfigError(std::move(sorted));
}

}  // namespace grouser
